#include "sensors/recorded_poses.h"
#include "tests/core/exports/nuscenes_world.h"

namespace scanmill {
namespace {

class NuScenesTables : public NuScenesWorld {};

// As the schema says: which fields rows have, which rows fields point to, and that chains run both ways.
TEST_F(NuScenesTables, RowsHaveTheSchemasFieldsAndPointToEachOther) {
  write(*layout_);
  readTables(R"(
fields = {
    'attribute': 'name description', 'calibrated_sensor': 'sensor_token translation rotation camera_intrinsic',
    'category': 'name description index', 'ego_pose': 'translation rotation timestamp',
    'instance': 'category_token nbr_annotations first_annotation_token last_annotation_token',
    'lidarseg': 'filename sample_data_token', 'panoptic': 'filename sample_data_token',
    'log': 'logfile vehicle date_captured location', 'map': 'log_tokens category filename',
    'sample': 'timestamp scene_token next prev',
    'sample_annotation': 'sample_token instance_token attribute_tokens visibility_token translation size rotation '
                         'num_lidar_pts num_radar_pts next prev',
    'sample_data': 'sample_token ego_pose_token calibrated_sensor_token filename fileformat width height timestamp '
                   'is_key_frame next prev',
    'scene': 'name description log_token nbr_samples first_sample_token last_sample_token',
    'sensor': 'channel modality', 'visibility': 'level description'}
added = {'category_name', 'data', 'anns'}
assert sorted(fields) == sorted(names)
for name, rows in table.items():
    assert len(by_token[name]) == len(rows) > 0, name
    for row in rows:
        assert set(row) - added == {'token', *fields[name].split()}, row
        assert name == 'visibility' or re.fullmatch('[0-9a-f]{32}', row['token']), row
        for key, value in row.items():
            if not key.endswith('_token'):
                continue
            target = re.sub('^(first|last)_', '', key[:-6])
            target = {'annotation': 'sample_annotation'}.get(target, target)
            assert value in by_token[target], (name, key)
def chain(name, first, last, same):
    token, before, rows = first, '', []
    while token:
        row = get(name, token)
        assert row['prev'] == before and same(row)
        rows.append(row)
        before, token = token, row['next']
    assert before == last
    return rows
for name in ('sample', 'sample_data', 'sample_annotation'):
    assert all(get(name, row['next'])['prev'] == row['token'] for row in table[name] if row['next'])
assert [scene['name'] for scene in table['scene']] == ['scene-0001', 'scene-0003']
assert [scene['description'] for scene in table['scene']] == ['street-s1-lane', 'street-s2-lane']
times = []
for scene in table['scene']:
    samples = chain('sample', scene['first_sample_token'], scene['last_sample_token'],
                    lambda row: row['scene_token'] == scene['token'])
    assert len(samples) == scene['nbr_samples'] == 2
    data = [get('sample_data', row['data']['LIDAR_TOP']) for row in samples]
    assert chain('sample_data', data[0]['token'], data[-1]['token'], lambda row: row['is_key_frame']) == data
    for row, d in zip(samples, data):
        assert row['timestamp'] == d['timestamp'] == get('ego_pose', d['ego_pose_token'])['timestamp']
        assert d['fileformat'] == 'pcd' and d['width'] == d['height'] == 0
        assert re.search(r'samples/LIDAR_TOP/.*__LIDAR_TOP__%d\.pcd\.bin$' % d['timestamp'], d['filename'])
        assert (folder / d['filename']).is_file()
    assert samples[1]['timestamp'] - samples[0]['timestamp'] == 100000
    times += [row['timestamp'] for row in samples]
assert times == sorted(set(times)) and times[0] == 1577836800000000, times   # date -u -d 2020-01-01 +%s
assert [log['date_captured'] for log in table['log']] == ['2020-01-01', '2020-01-02']
for i in table['instance']:
    rows = chain('sample_annotation', i['first_annotation_token'], i['last_annotation_token'],
                 lambda row: row['instance_token'] == i['token'])
    assert len(rows) == i['nbr_annotations'] == 2
assert len(table['instance']) == 4 and len(table['sample_annotation']) == 8
for row in table['sample_annotation']:
    assert all(token in by_token['attribute'] for token in row['attribute_tokens'])
assert {token for row in table['map'] for token in row['log_tokens']} == set(by_token['log'])
assert [s['channel'] for s in table['sensor'] if s['modality'] == 'lidar'] == ['LIDAR_TOP']
cameras = {s['token']: s['channel'] for s in table['sensor'] if s['modality'] == 'camera'}
assert len(cameras) == 6
# What the front camera sees ahead of the vehicle is in the middle of its image.
for mount in table['calibrated_sensor']:
    if cameras.get(mount['sensor_token']) == 'CAM_FRONT':
        x, y, z = np.array(mount['camera_intrinsic']) @ rotation(mount['rotation']).T @ np.array([10, 0, 0])
        assert abs(x / z - 800) < 1e-9 and abs(y / z - 450) < 1e-9
assert (folder / 'sweeps/LIDAR_TOP').is_dir()
)");
}

// The names are those of the devkit's colour map, by their index in lidarseg.
TEST_F(NuScenesTables, CategoriesAreThoseOfLidarseg) {
  write(*layout_);
  readTables(R"(
human = ['adult', 'child', 'construction_worker', 'personal_mobility', 'police_officer', 'stroller', 'wheelchair']
wanted = (['noise', 'animal'] + ['human.pedestrian.' + name for name in human] +
          ['movable_object.' + name for name in ('barrier', 'debris', 'pushable_pullable', 'trafficcone')] +
          ['static_object.bicycle_rack'] +
          ['vehicle.' + name for name in ('bicycle', 'bus.bendy', 'bus.rigid', 'car', 'construction',
           'emergency.ambulance', 'emergency.police', 'motorcycle', 'trailer', 'truck')] +
          ['flat.' + name for name in ('driveable_surface', 'other', 'sidewalk', 'terrain')] +
          ['static.' + name for name in ('manmade', 'other', 'vegetation')] + ['vehicle.ego'])
assert [row['name'] for row in table['category']] == wanted
assert [row['index'] for row in table['category']] == list(range(32))
assert 'car' in table['category'][17]['description']
)");
  // nuScenes has boxes of 23 categories.
  const std::vector<SemanticClass>& classes = plan_.classes.target().classes;
  EXPECT_EQ(std::count_if(classes.begin(), classes.end(), [](const auto& c) { return c.thing; }), 23);
}

// The devkit derives velocities from the annotations before and after: the car drives 0.8 m in 0.1 s.
TEST_F(NuScenesTables, AnnotationsAreTheObjects) {
  write(*layout_);
  readTables(R"(
attribute = {row['token']: row['name'] for row in table['attribute']}
for a in table['sample_annotation']:
    car = a['category_name'] == 'vehicle.car'
    assert car or a['category_name'] == 'human.pedestrian.adult'
    assert a['num_lidar_pts'] == (72 if car else 60) and a['num_radar_pts'] == 0
    assert a['size'] == ([1.8, 4.5, 1.5] if car else [0.6, 0.5, 1.75])   # width, length, height
    assert get('visibility', a['visibility_token'])['level'] == 'v60-80'
    assert [attribute[t] for t in a['attribute_tokens']] == ['vehicle.moving' if car else 'pedestrian.standing']
    first = get('sample_annotation', a['prev'] or a['token'])
    last = get('sample_annotation', a['next'] or a['token'])
    moved = np.array(last['translation']) - first['translation']
    begin, end = [get('sample', row['sample_token'])['timestamp'] for row in (first, last)]
    seconds = 1e-6 * (end - begin)
    assert np.allclose(moved / seconds, [8, 0, 0] if car else 0, atol=1e-6), moved / seconds
    yaw = 2 * np.arctan2(a['rotation'][3], a['rotation'][0])
    assert abs(np.angle(np.exp(1j * (yaw - (0.3 if car else -2))))) < 1e-9
)");
}

// One object a way of being seen or not.
TEST_F(NuScenesTables, AnnotatesThingsWithPointsOnly) {
  struct Case {
    const char* semantic;
    double speed;
    bool moves;
    std::uint32_t beams;  // of 100
    std::uint64_t points;
  };
  const std::vector<Case> cases{{"car", 0.1, true, 39, 5},       {"car", 0, false, 40, 5},
                                {"truck", 0.3, true, 59, 5},     {"bicycle", 0, true, 60, 5},
                                {"motorcycle", 0, false, 79, 5}, {"pedestrian", 1, true, 80, 5},
                                {"animal", 1, true, 100, 1},     {"truck", 0, false, 0, 3},
                                {"car", 9, true, 100, 0},        {"building", 0, false, 100, 9}};
  write(*layout_);
  layout_->finish(
      plan_,
      [&](std::size_t s, std::size_t f) {
        SampleObjects all = objects(s, f);
        const ObjectRecord model = all.objects.front();
        all.objects.clear();
        for (const Case& c : cases) {
          ObjectRecord object = model;
          object.id = static_cast<std::uint32_t>(all.objects.size() + 100'000);
          object.semantic = classId(c.semantic);
          object.velocity = {0, c.speed, 0};
          object.moves = c.moves;
          object.views.front().beams = c.beams;
          if (c.beams == 0) object.views.front().beamsAlone = 0;  // only edges of beams hit it
          object.views.front().points = c.points;
          all.objects.push_back(object);
        }
        ObjectRecord unseen = model;
        unseen.views.front().sensor = "rear";  // by another sensor alone
        all.objects.push_back(unseen);
        return std::optional(all);
      },
      folder());
  readTables(R"(
attribute = {row['token']: row['name'] for row in table['attribute']}
found = [(a['category_name'], a['visibility_token'], [attribute[t] for t in a['attribute_tokens']])
         for a in table['sample_annotation'][:8]]
assert found == [('vehicle.car', '1', ['vehicle.stopped']), ('vehicle.car', '2', ['vehicle.parked']),
                 ('vehicle.truck', '2', ['vehicle.moving']), ('vehicle.bicycle', '3', ['cycle.with_rider']),
                 ('vehicle.motorcycle', '3', ['cycle.without_rider']),
                 ('human.pedestrian.adult', '4', ['pedestrian.moving']), ('animal', '4', []),
                 ('vehicle.truck', '1', ['vehicle.parked'])], found
assert len(table['sample_annotation']) == 4 * 8 and len(table['instance']) == 2 * 8
)");
}

// A pedestrian's box grows with each stride; that of nuScenes holds all of them.
TEST_F(NuScenesTables, AnInstanceHasOneSize) {
  write(*layout_);
  layout_->finish(
      plan_,
      [&](std::size_t s, std::size_t f) {
        SampleObjects all = objects(s, f);
        all.objects.back().size = f == 0 ? Vec3d{0.9, 0.6, 1.7} : Vec3d{0.5, 0.7, 1.75};
        return std::optional(all);
      },
      folder());
  readTables(R"(
sizes = [a['size'] for a in table['sample_annotation'] if a['category_name'].startswith('human')]
assert sizes == [[0.7, 0.9, 1.75]] * 4, sizes   # width, length, height
)");
}

TEST_F(NuScenesTables, SplitsNameTheScenes) {
  write(*layout_);
  readTables(R"(
splits = json.loads((root / 'splits.json').read_text())
assert splits == {'train': ['scene-0001'], 'scanmill_train': ['scene-0001'],
                  'val': ['scene-0003'], 'scanmill_val': ['scene-0003']}
)");
}

TEST_F(NuScenesTables, OfADatasetWithoutObjectsHaveNoAnnotations) {
  withObjects_ = false;
  write(*layout_);
  readTables(R"(
assert table['sample_annotation'] == [] and table['instance'] == []
assert len(table['sample']) == 4 and len(table['lidarseg']) == 4
)");
}

}  // namespace
}  // namespace scanmill
