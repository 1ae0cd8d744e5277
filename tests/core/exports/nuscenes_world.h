#pragma once

// The world of layouts' tests as nuScenes, and a reader in Python that does what the devkit does to open and join its
// tables, written after docs/schema_nuscenes.md of github.com/nutonomy/nuscenes-devkit.

#include <fmt/core.h>

#include "tests/core/exports/export_world.h"

namespace scanmill {

inline constexpr const char* kNuScenesReader = R"(
import re
root = folder / 'v1.0-trainval'
names = ['attribute', 'calibrated_sensor', 'category', 'ego_pose', 'instance', 'log', 'map', 'sample',
         'sample_annotation', 'sample_data', 'scene', 'sensor', 'visibility']
names += [name for name in ('lidarseg', 'panoptic') if (root / (name + '.json')).exists()]
table = {name: json.loads((root / (name + '.json')).read_text()) for name in names}
by_token = {name: {row['token']: row for row in rows} for name, rows in table.items()}
def get(name, token):
    return by_token[name][token]
for name in ('lidarseg', 'panoptic'):
    if name in table:
        assert len(list((folder / name / 'v1.0-trainval').iterdir())) == len(table[name])
lidar_data = [d for d in table['sample_data'] if d['fileformat'] == 'pcd']   # the others are black pictures
for a in table['sample_annotation']:
    a['category_name'] = get('category', get('instance', a['instance_token'])['category_token'])['name']
for s in table['sample']:
    s['data'], s['anns'] = {}, []
for d in table['sample_data']:
    sensor = get('sensor', get('calibrated_sensor', d['calibrated_sensor_token'])['sensor_token'])
    if not d['is_key_frame']: continue
    get('sample', d['sample_token'])['data'][sensor['channel']] = d['token']
for a in table['sample_annotation']:
    get('sample', a['sample_token'])['anns'].append(a['token'])

def rotation(q):
    w, x, y, z = q
    assert abs(w * w + x * x + y * y + z * z - 1) < 1e-8
    return np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
                     [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
                     [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]])
def pose(row):
    m = np.eye(4)
    m[:3, :3], m[:3, 3] = rotation(row['rotation']), row['translation']
    return m
def ego_and_sensor(data):
    names = 'ego_pose', 'calibrated_sensor'
    return [pose(get(name, data[name + '_token'])) for name in names]
def points_of(data):
    return np.fromfile(folder / data['filename'], dtype=np.float32).reshape(-1, 5)
def lidarseg_of(data):
    return np.fromfile(folder / get('lidarseg', data['token'])['filename'], dtype=np.uint8)
def panoptic_of(data):
    return np.load(folder / get('panoptic', data['token'])['filename'])['data']
# As get_sample_data() does: boxes in the frame of the sensor, as middle, axes and half of length, width and height.
def boxes_of(data):
    ego, sensor = ego_and_sensor(data)
    for token in get('sample', data['sample_token'])['anns']:
        a = get('sample_annotation', token)
        box = np.linalg.inv(ego @ sensor) @ pose(a)
        w, l, h = a['size']
        yield a, box[:3, 3], box[:3, :3], np.array([l, w, h]) / 2
)";

class NuScenesWorld : public ExportWorld {
 protected:
  NuScenesWorld() : ExportWorld(makeNuScenes(), "nuscenes") {}

  std::string readTables(const std::string& code) const { return python(kNuScenesReader + code); }

  ExportFolder folder() const { return ExportFolder(folder_.path()); }
};

}  // namespace scanmill
