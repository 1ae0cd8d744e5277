#include <fmt/format.h>

#include "tests/core/exports/export_world.h"

namespace scanmill {
namespace {

class NpzLayout : public ExportWorld {
 protected:
  NpzLayout() : ExportWorld(makeNpz()) {}

  // Of what NumPy finds in the file of the first sample's first sensor.
  std::string npz(const std::string& code) const {
    return python("npz = dict(np.load(folder / 'train/street-s1-lane-000000.top.npz', allow_pickle=False))\n" + code);
  }
  static std::string numbers(const Vec3d& v) { return fmt::format("[{}, {}, {}]", v.x, v.y, v.z); }
};

TEST_F(NpzLayout, ArraysAreTheColumnsInTheirOwnTypes) {
  useBothSensors();
  write(*layout_);
  python(R"(
npz = np.load(folder / 'val/street-s2-lane-000001.rear.npz', allow_pickle=False)
points = {name: npz[name].dtype.str for name in npz.files if not name.startswith('box')}
assert points == {'xyz': '<f4', 'intensity': '<f4', 'label': '<u2', 'instance': '<u4', 'ring': '<u2', 'column': '<u2',
                  'time': '<f4', 'range_true': '<f4', 'world_from_sensor': '<f8'}, points
i = np.array([i for i in range(360) if i % 7])
distance = 12 + 0.01 * i
angle = np.radians(4 * (i % 90)) - np.pi
want = np.stack([distance * np.cos(angle), distance * np.sin(angle), 0.1 * (i // 90)], axis=1)
assert npz['xyz'].shape == (308, 3) and np.abs(npz['xyz'] - want).max() < 1e-6
for name in set(points) - {'xyz', 'world_from_sensor'}: assert npz[name].shape == (308,)
assert (npz['ring'] == i // 90).all() and (npz['column'] == i % 90).all()
assert (npz['instance'] == np.select([i % 5 == 1, i % 5 == 2], [7, 9], 0)).all()
assert len(set(zip(npz['instance'], npz['label']))) == 3
)");
}

// Points on a wall of the world, moved there by the pose, and the boxes as the objects' own poses in the world say.
TEST_F(NpzLayout, PosesAndBoxesAreInOneFrame) {
  useBothSensors();
  write(*layout_);
  const Pose pose = vehicle(1) * *plan_.sensors[1]->vehicleFromSensor;
  const SampleObjects all = objects(0, 1);
  python("pose = " + numbers(pose * Vec3d{3, 4, 5}) + "\ncar = " + numbers(all.objects[0].worldFromBox.translation) +
         "\nahead = " + numbers(all.objects[0].worldFromBox * Vec3d{1, 0, 0}) + R"(
npz = np.load(folder / 'train/street-s1-lane-000001.rear.npz', allow_pickle=False)
matrix = npz['world_from_sensor']
assert matrix.shape == (1, 4, 4) and np.abs(matrix[0] @ [3, 4, 5, 1] - (pose + [1])).max() < 1e-12
boxes = npz['boxes']
assert boxes.shape == (2, 7) and boxes.dtype == np.float32
x, y, z, l, w, h, yaw = boxes[0].astype(float)
assert np.abs((matrix[0] @ [x, y, z, 1])[:3] - car).max() < 1e-4
assert np.abs((matrix[0] @ [x + np.cos(yaw), y + np.sin(yaw), z, 1])[:3] - ahead).max() < 1e-4
assert np.allclose([l, w, h], [4.5, 1.8, 1.5]) and np.allclose(boxes[1, 3:6], [0.5, 0.6, 1.75])
velocity = npz['box_velocity']
assert velocity.dtype == np.float32 and np.abs(matrix[0, :3, :3] @ velocity[0] - [8, 0, 0]).max() < 1e-5
assert not velocity[1].any()
assert npz['box_instance'].tolist() == [7, 9] and npz['box_instance'].dtype == np.uint32
assert npz['box_points'].tolist() == [72, 60] and npz['box_points'].dtype == np.uint32
assert np.allclose(npz['box_visibility'], [0.72, 0.6]) and npz['box_visibility'].dtype == np.float32
semantic = [npz['label'][npz['instance'] == id][0] for id in (7, 9)]
own = npz['box_pose']
assert own.shape == (2, 4, 4) and np.allclose(own[:, :3, 3], boxes[:, :3]) and np.allclose(own[:, 3], [0, 0, 0, 1])
assert np.allclose(np.arctan2(own[:, 1, 0], own[:, 0, 0]), boxes[:, 6], atol=1e-6)
assert npz['box_class'].tolist() == semantic and npz['box_class'].dtype == np.uint16
)");
}

TEST_F(NpzLayout, BoxesAreThoseThatTheSensorReaches) {
  useBothSensors();
  ExportSample sample = this->sample(0, 0);
  sample.objects->objects[0].views.erase(sample.objects->objects[0].views.begin());  // the car's by `top`
  sample.objects->objects[1].views[0].beams = 0;
  sample.objects->objects[1].views[0].beamsAlone = 0;
  writeSample(sample);
  npz(R"(
assert npz['box_instance'].tolist() == [9] and npz['boxes'].shape == (1, 7)
assert np.isnan(npz['box_visibility']).tolist() == [True]
assert np.load(folder / 'train/street-s1-lane-000000.rear.npz')['box_instance'].tolist() == [7, 9]
)");
  sample.objects->objects.clear();
  writeSample(sample);
  npz("assert npz['boxes'].shape == (0, 7) and npz['box_velocity'].shape == (0, 3) and npz['box_class'].shape == "
      "(0,)\n");
}

TEST_F(NpzLayout, WithoutAListThereAreNoBoxes) {
  withObjects_ = false;
  write(*layout_);
  npz("assert not [name for name in npz if name.startswith('box')] and len(npz['xyz']) == 308\n");
}

TEST_F(NpzLayout, OrganisedScansStayImages) {
  ExportSample sample = this->sample(0, 0, true);
  writeSample(sample);
  npz(R"(
assert npz['xyz'].shape == (4, 90, 3)
assert np.isnan(npz['xyz'][:, 89]).all() and np.isfinite(npz['xyz'][:, :89]).all()
row, column = np.mgrid[:4, :90]
assert (npz['ring'] == row).all() and (npz['column'] == column).all() and npz['intensity'].shape == (4, 90)
)");
  Scan& scan = sample.scans[0].scan;
  scan.planes = 2;
  scan.position.resize(720);
  scan.position[360] = {1, 2, 3};
  visitTable(scan, [](auto, auto& values) {
    if (!values.empty()) values.resize(720);
  });
  writeSample(sample);
  npz("assert npz['xyz'].shape == (8, 90, 3) and npz['xyz'][4, 0].tolist() == [1, 2, 3]\n");
}

TEST_F(NpzLayout, AMovingSensorHasTwoPoses) {
  ScanRecord& record = plan_.manifest.samples[0].scans[0];
  record.worldFromSensor = {{{}, {1, 2, 3}}, {fromYawPitchRoll(kPi / 2, 0, 0), {4, 5, 6}}};
  writeSample(sample(0, 0));
  npz(R"(
first, last = npz['world_from_sensor']
assert np.allclose(first, [[1, 0, 0, 1], [0, 1, 0, 2], [0, 0, 1, 3], [0, 0, 0, 1]])
assert np.allclose(last, [[0, -1, 0, 4], [1, 0, 0, 5], [0, 0, 1, 6], [0, 0, 0, 1]])
)");
}

TEST_F(NpzLayout, ScansWithoutColumnsOrPointsAreFiles) {
  ExportSample sample = this->sample(0, 0);
  Scan& scan = sample.scans[0].scan;
  visitTable(scan, [](auto, auto& values) { values.clear(); });
  writeSample(sample);
  npz("assert sorted(n for n in npz if not n.startswith('box')) == ['world_from_sensor', 'xyz']\n");
  scan.position.clear();
  writeSample(sample);
  npz("assert npz['xyz'].shape == (0, 3) and npz['label'].shape == (0,) and npz['label'].dtype == np.uint16\n");
}

TEST_F(NpzLayout, ClassesAreThoseOfTheOntologyThatIsExported) {
  use("cityscapes");
  write(*layout_);
  npz("assert set(npz['label']) == {26, 24, 11} and npz['box_class'].tolist() == [26, 24]\n");
}

}  // namespace
}  // namespace scanmill
