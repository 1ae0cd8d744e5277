#include <fmt/format.h>

#include <random>

#include "exports/mcap_file.h"
#include "tests/core/exports/export_world.h"

namespace scanmill {
namespace {

using testing::HasSubstr;

class McapLayout : public ExportWorld {
 protected:
  McapLayout() : ExportWorld(makeMcap()) {}

  // Runs Python with the independent reader at hand: File, cloud, and values(name) of what dump() has written.
  std::string read(const std::string& code) const {
    return python(fmt::format(R"(
sys.path.insert(0, '{}/tests/core/exports')
sys.dont_write_bytecode = True
from read_mcap import File, cloud
expected = pathlib.Path('{}')
def values(name, like):
    return np.frombuffer((expected / name).read_bytes(), like.dtype)
def on(file, topic):
    return [message['value'] for message in file.messages if message['topic'] == topic]
)",
                              SCANMILL_SOURCE_DIR, scripts_.path().string()) +
                  code);
  }

  void dump(const Scan& scan, const std::string& name) const {
    std::string names = "xyz";
    const auto put = [&](std::string_view column, const auto& all) {
      const std::string_view bytes(reinterpret_cast<const char*>(all.data()), all.size() * sizeof(all[0]));
      scripts_.write(fmt::format("{}.{}", name, column), bytes);
    };
    put("xyz", scan.position);
    visitColumns(scan, [&](std::string_view column, const auto& all) {
      names += fmt::format(" {}", column);
      put(column, all);
    });
    scripts_.write(name + ".names", names);
  }
};

TEST_F(McapLayout, PointsAreThoseOfTheScansInAllColumns) {
  for (const bool organised : {false, true}) {
    useBothSensors();
    write(*layout_, organised);
    for (const std::size_t sensor : {0, 1}) {
      for (const std::size_t frame : {0, 1}) {
        dump(scan(sensor, frame, organised), fmt::format("{}.{}", plan_.sensors[sensor]->name, frame));
      }
    }
    const std::string printed = read(fmt::format("organised = {}\n", organised ? "True" : "False") + R"(
total = 0
for path in ['train/street-s1-lane.mcap', 'val/street-s2-lane.mcap']:
    file = File(folder / path)
    assert file.header['profile'] == 'ros2'
    assert sorted({m['topic'] for m in file.messages}) == [
        '/objects', '/odom', '/rear/points', '/tf', '/tf_static', '/top/points']
    for sensor in ['top', 'rear']:
        clouds = on(file, '/%s/points' % sensor)
        assert len(clouds) == 2
        for frame, value in enumerate(clouds):
            name = '%s.%d.' % (sensor, frame)
            points = cloud(value)
            assert points.shape == ((4, 90) if organised else (1, 308)), points.shape
            assert value['is_dense'] != organised and np.isnan(points['x']).any() == organised
            names = (expected / (name + 'names')).read_text().split()
            assert list(points.dtype.names) == ['x', 'y', 'z'] + names[1:]
            flat = points.ravel()
            xyz = values(name + 'xyz', flat['x']).reshape(-1, 3)
            for axis, own in zip(xyz.T, ['x', 'y', 'z']):
                assert axis.tobytes() == flat[own].tobytes(), own
            for own in names[1:]:
                assert values(name + own, flat[own]).tobytes() == flat[own].tobytes(), own
            assert value['header']['frame_id'] == sensor
            stamp = value['header']['stamp']
            assert stamp == {'sec': 1577836800, 'nanosec': 100000000 * frame}, stamp
            total += flat.size
print(total)
)");
    EXPECT_THAT(printed, HasSubstr(organised ? "2880" : "2464"));
  }
}

TEST_F(McapLayout, TransformsChainToThePosesOfTheSensors) {
  useBothSensors();
  write(*layout_);
  std::string poses;
  for (const ScanRecord& scan : plan_.manifest.samples[1].scans) {
    const Vec3d tip = scan.worldFromSensor.front() * Vec3d{3, -2, 1};
    poses += fmt::format("'{}': [{}, {}, {}],", scan.sensor, tip.x, tip.y, tip.z);
  }
  read("world = {" + poses + "}\n" + R"(
def moved(transform, point):
    t, q = transform['transform']['translation'], transform['transform']['rotation']
    v, w = np.array([q['x'], q['y'], q['z']]), q['w']
    return point + 2 * np.cross(v, np.cross(v, point) + w * point) + [t['x'], t['y'], t['z']]
file = File(folder / 'train/street-s1-lane.mcap')
static, = on(file, '/tf_static')
poses = on(file, '/tf')
assert file.messages[0]['topic'] == '/tf_static' and len(poses) == 2
vehicle, = poses[1]['transforms']
assert (vehicle['header']['frame_id'], vehicle['child_frame_id']) == ('map', 'base_link')
assert vehicle['header']['stamp'] == {'sec': 1577836800, 'nanosec': 100000000}
assert len(static['transforms']) == 2
for mount in static['transforms']:
    assert mount['header']['frame_id'] == 'base_link'
    point = moved(vehicle, moved(mount, np.array([3., -2, 1])))
    assert np.allclose(point, world[mount['child_frame_id']], rtol=0, atol=1e-9), point
durability = {c['topic']: 'durability: 1' in c['metadata']['offered_qos_profiles'] for c in file.channels.values()}
assert [topic for topic, latched in durability.items() if latched] == ['/tf_static']
def numbers(v):
    return np.array([v[key] for key in 'xyz'])
a, b = [p['transforms'][0]['transform'] for p in poses]
back = {'transform': {'translation': {'x': 0, 'y': 0, 'z': 0}, 'rotation': {**a['rotation'], 'w': -a['rotation']['w']}}}
for number, odom in enumerate(on(file, '/odom')):
    assert (odom['header'], odom['child_frame_id']) == (poses[number]['transforms'][0]['header'], 'base_link')
    assert odom['pose']['pose']['orientation'] == [a, b][number]['rotation']
    linear = odom['twist']['twist']['linear']
    if number == 0:
        assert np.allclose(numbers(linear), moved(back, (numbers(b['translation']) - numbers(a['translation'])) / 0.1))
)");
}

TEST_F(McapLayout, TheVehicleIsGivenAtTheTimeOfEachSensor) {
  useBothSensors();
  plan_.manifest.samples[1].scans[1].time = 0.125;
  std::vector<Pose>& moving = plan_.manifest.samples[1].scans[1].worldFromSensor;
  moving.push_back(moving.front());
  plan_.ros = {"odom", "robot", folder_.write("a.urdf", "<robot/>")};
  write(*layout_);
  read(R"(
file = File(folder / 'train/street-s1-lane.mcap')
stamps = [p['transforms'][0]['header']['stamp']['nanosec'] for p in on(file, '/tf')]
assert stamps == [0, 100000000, 125000000, 223888889], stamps
assert on(file, '/tf')[0]['transforms'][0]['header']['frame_id'] == 'odom'
assert on(file, '/robot_description') == [{'data': '<robot/>'}]
assert [v['header']['stamp']['nanosec'] for v in on(file, '/rear/points')] == [0, 125000000]
)");
}

TEST_F(McapLayout, MarkersAreTheBoxesOfTheObjects) {
  write(*layout_);
  read(R"(
file = File(folder / 'train/street-s1-lane.mcap')
for frame, value in enumerate(on(file, '/objects')):
    clear, car, name, walker, walkers = value['markers']
    assert clear['action'] == 3
    assert [(m['type'], m['action'], m['ns'], m['id']) for m in value['markers'][1:]] == [
        (1, 0, 'car', 7), (9, 0, 'name', 7), (1, 0, 'pedestrian', 9), (9, 0, 'name', 9)]
    assert all(m['header']['frame_id'] == 'map' for m in value['markers'])
    assert all(m['header']['stamp']['nanosec'] == 100000000 * frame for m in value['markers'])
    p, q = car['pose']['position'], car['pose']['orientation']
    assert np.allclose([p['x'], p['y'], p['z']], [115 + 0.8 * frame, 24, 1])
    assert np.allclose([q['x'], q['y'], q['z'], q['w']], [0, 0, np.sin(0.15), np.cos(0.15)])
    assert car['scale'] == {'x': 4.5, 'y': 1.8, 'z': 1.5}
    assert np.allclose([car['color'][c] for c in 'rgba'], [40 / 255, 90 / 255, 1, 0.4])
    assert car['lifetime'] == {'sec': 0, 'nanosec': 0} and not car['frame_locked']
    assert (name['text'], walkers['text']) == ('car 7, 72 %', 'pedestrian 9, 60 %')
    assert name['pose']['position']['z'] > 1 + 1.5 / 2 and name['pose']['position']['x'] == p['x']
)");
}

TEST_F(McapLayout, TheMostOfTheExportedSensorsTellsHowVisibleAnObjectIs) {
  useBothSensors();
  const auto change = [](ExportSample& sample) {
    ObjectRecord& car = sample.objects->objects[0];
    car.views[0].beams = 5;  // of 100
    car.views[1].beams = 25;
    car.views.push_back(car.views[0]);
    car.views[2].sensor = "other";
    car.views[2].beams = 100;
    for (ObjectView& view : sample.objects->objects[1].views) view.beams = view.beamsAlone = 0;
  };
  writeChanged(*layout_, 0, 0, change);
  read(R"(
markers = on(File(folder / 'train/street-s1-lane.mcap'), '/objects')[0]['markers']
assert [m['text'] for m in markers] == ['', '', 'car 7, 25 %', '', 'pedestrian 9'], markers
)");
}

TEST_F(McapLayout, ScansWithoutPointsColumnsOrObjectsAreWritten) {
  withObjects_ = false;
  writeChanged(*layout_, 0, 0, [](ExportSample& sample) {
    Scan& scan = sample.scans[0].scan;
    if (sample.frame == 0) scan = {};
    scan[kLabel].clear();
    scan[kIntensity].clear();
    scan[kReturn].assign(scan.size(), 2);
  });
  read(R"(
file = File(folder / 'train/street-s1-lane.mcap')
assert on(file, '/objects') == [] and len(file.channels) == 4
none, some = [cloud(value) for value in on(file, '/top/points')]
assert none.shape == (1, 0) and some.shape == (1, 308)
assert 'label' not in some.dtype.names and 'intensity' not in some.dtype.names and 'instance' in some.dtype.names
assert (some['return'] == 2).all() and some.dtype['return'] == np.uint8
)");
}

TEST_F(McapLayout, FurtherReturnsAreRowsOfTheirOwn) {
  writeChanged(*layout_, 0, 0, [this](ExportSample& sample) {
    Scan both = scan(0, sample.frame, true);
    const Scan one = both;
    both.planes = 2;
    both.position.insert(both.position.end(), one.position.begin(), one.position.end());
    visitTable(both, [&](auto key, auto& values) {
      if (!values.empty()) values.insert(values.end(), one[key].begin(), one[key].end());
    });
    sample.scans[0].scan = both;
  });
  read(R"(
for value in on(File(folder / 'train/street-s1-lane.mcap'), '/top/points'):
    points = cloud(value)
    assert points.shape == (8, 90) and points[:4].tobytes() == points[4:].tobytes()
)");
}

TEST_F(McapLayout, ClassesAreThoseThatAreAskedFor) {
  use("semantic_kitti");
  write(*layout_);
  read(R"(
file = File(folder / 'train/street-s1-lane.mcap')
labels = {file.metadata['classes'][str(id)] for id in np.unique(cloud(on(file, '/top/points')[0])['label'])}
assert labels == {'building', 'car', 'person'}, labels
assert file.metadata['scanmill'] == {
    'dataset': 'world', 'sequence': 'street-s1-lane', 'split': 'train', 'deskewed': 'false'}
assert on(file, '/objects')[0]['markers'][3]['ns'] == 'person'
)");
}

TEST_F(McapLayout, TopicsHaveNamesThatRosTakesAndThatDiffer) {
  useBothSensors();
  nameSensor(0, "front-left");
  nameSensor(1, "2nd");
  write(*layout_);
  read(R"(
file = File(folder / 'train/street-s1-lane.mcap')
assert {c['topic'] for c in file.channels.values()} >= {'/front_left/points', '/sensor_2nd/points'}
assert on(file, '/front_left/points')[0]['header']['frame_id'] == 'front-left'
)");
  plan_.manifest.sensors[1].name = "front_left";
  EXPECT_THAT(messageOf<InputError>([&] { layout_->check(plan_); }), HasSubstr("share the topic /front_left/points"));
  plan_.manifest.sensors[1].name = "base_link";
  EXPECT_THAT(messageOf<InputError>([&] { layout_->check(plan_); }), HasSubstr("'base_link'"));
  plan_.ros.links = {"base_footprint", "base_link", "mast"};
  EXPECT_THAT(messageOf<InputError>([&] { layout_->check(plan_); }), HasSubstr("'base_link'"));
  plan_.manifest.sensors[1].name = "mast";
  EXPECT_THAT(messageOf<InputError>([&] { layout_->check(plan_); }), HasSubstr("give --frames map,base_footprint"));
  plan_.ros.vehicle = "base_footprint";
  EXPECT_THAT(messageOf<InputError>([&] { layout_->check(plan_); }), HasSubstr("has a link 'mast'"));
}

TEST_F(McapLayout, NothingIsLeftOfAFileThatBreaksOff) {
  EXPECT_THROW(writeChanged(*layout_, 0, 0,
                            [](ExportSample& sample) {
                              if (sample.frame == 1) throw Error("stopped");
                            }),
               Error);
  EXPECT_TRUE(std::filesystem::is_empty(folder_.path() / "train"));
}

// A chunk ends behind the message that fills it. What cannot be compressed stays as it is.
TEST_F(McapLayout, ChunksAreAboutFourMegabytes) {
  constexpr std::size_t kHalf = std::size_t{2} << 20;
  std::mt19937 random(1);
  std::string noise(kHalf, '\0');
  for (char& c : noise) c = static_cast<char>(random());
  McapFile file(folder_.path() / "large.mcap", "", "test");
  const std::uint16_t schema = file.addSchema("bytes", "", "");
  const std::uint16_t even = file.addChannel(schema, "even", "", {});
  const std::uint16_t odd = file.addChannel(schema, "odd", "", {{"a", "b"}, {"c", ""}});
  for (const std::string& bytes : {std::string(kHalf, '\0'), noise}) {
    for (std::uint64_t i = 0; i < 4; ++i) file.addMessage(i % 2 == 0 ? even : odd, 1000 - i, bytes);
  }
  for (std::uint64_t i = 0; i < 3; ++i) file.addMessage(odd, i, "");
  file.commit();
  McapFile(folder_.path() / "empty.mcap", "", "test").commit();
  read(R"(
file = File(folder / 'large.mcap', ros=False)
assert [c['compression'] for c in file.chunks] == ['lz4', 'lz4', '', '', 'lz4'], file.chunks
assert [c['messages'] for c in file.chunks] == [2, 2, 2, 2, 3]
assert all(4 << 20 < c['size'] < (4 << 20) + 1000 for c in file.chunks[:4])
assert [len(v) for v in on(file, 'odd')] == [2 << 20] * 4 + [0] * 3
empty = File(folder / 'empty.mcap', ros=False)
assert not empty.messages and not empty.chunks
)");
}

}  // namespace
}  // namespace scanmill
