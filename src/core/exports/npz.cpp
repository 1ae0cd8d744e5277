// Writes a NumPy archive for each scan (numpy.org/doc/stable/reference/generated/numpy.lib.format.html), which
// numpy.load() reads without pickle. N is the number of points; in an organised scan N stands for (rings * planes,
// columns), and misses are kept as NaN. P is the number of poses: one pose; or, if the sensor moves during the
// revolution, two poses, at its first and its last column. M is the number of boxes.
//
//   xyz                float32 (N, 3)    in the sensor's frame (m)
//   a column's name    (N,)              each of the scan's columns, in its own type; classes of the exported ontology
//   world_from_sensor  float64 (P, 4, 4) world point = matrix * sensor point
//
// If the dataset lists objects, the boxes of all objects that reach into the sensor's range, even without points:
//
//   boxes              float32 (M, 7)    x, y, z of the centre, length, width, height (m), yaw (rad); frame of xyz
//   box_pose           float64 (M, 4, 4) sensor point = matrix * point from the box's centre; with pitch and roll
//   box_class          uint16 (M,)
//   box_instance       uint32 (M,)       as in the column `instance`
//   box_velocity       float32 (M, 3)    over ground, along the sensor's axes at the start of the revolution (m/s)
//   box_points         uint32 (M,)       number of the scan's points on the object
//   box_visibility     float32 (M,)      visible fraction of the beams at the object; NaN if no beam would hit it

#include <fmt/core.h>

#include <algorithm>
#include <limits>
#include <string_view>
#include <type_traits>
#include <utility>

#include "exports/layout.h"
#include "formats/little_endian.h"
#include "formats/npy.h"

namespace scanmill {

namespace {

using Shape = std::vector<std::size_t>;
using Files = std::vector<std::pair<std::string, std::string>>;

// Adds the file of an array to `files`. `bytes`: the array's elements, which have the type T.
template <class T>
void add(std::string_view name, const Shape& shape, std::string_view bytes, Files& files) {
  // NumPy's name of the type, such as "<f4".
  const auto type =
      fmt::format("{}{}{}", sizeof(T) == 1 ? '|' : '<', std::is_floating_point_v<T> ? 'f' : 'u', sizeof(T));
  files.emplace_back(std::string(name) + ".npy", npyOf(type, shape, bytes));
}

void addPoints(const ExportPlan& plan, const Scan& scan, Files& files) {
  Shape shape{scan.size()};
  if (scan.organised) shape = {scan.height(), scan.width()};
  Shape positionShape = shape;
  positionShape.push_back(3);
  std::string bytes;
  for (const Vec3f& p : scan.position) {
    for (const float coordinate : {p.x, p.y, p.z}) putNumber(coordinate, bytes);
  }
  add<float>("xyz", positionShape, bytes, files);
  const ColumnSet columns = exportedColumns(plan, scan);
  visitTable(scan, [&]<class T>(auto key, const std::vector<T>& values) {
    if (!columns.has(key)) return;
    bytes.clear();
    for (const T value : values) putNumber(exported(plan.classes, key, value), bytes);
    add<T>(key.row.name, shape, bytes, files);
  });
}

// Appends the 4 x 4 matrix of a pose, row by row.
void putPose(const Pose& pose, std::string& bytes) {
  for (const double value : matrixRows(toAffine(pose))) putNumber(value, bytes);
}

// Adds the arrays of the boxes that have a view by the scan's sensor.
void addBoxes(const ExportPlan& plan, const SampleObjects& objects, const ExportScan& scan, Files& files) {
  const Mat3 sensorFromWorld = transposed(toMatrix(scan.record->worldFromSensor.front().rotation));
  std::size_t count = 0;
  std::string boxes, poses, classes, instances, velocities, points, visibilities;  // bytes of the arrays
  const auto putFloats = [](std::initializer_list<double> values, std::string& bytes) {
    for (const double value : values) putNumber(static_cast<float>(value), bytes);
  };
  for (const ObjectRecord& object : objects.objects) {
    const auto view = std::ranges::find(object.views, scan.sensor->name, &ObjectView::sensor);
    if (view == object.views.end()) continue;
    ++count;
    const Vec3d& center = view->sensorFromBox.translation;
    const Vec3d& size = object.size;
    const Vec3d velocity = sensorFromWorld * object.velocity;
    putFloats({center.x, center.y, center.z, size.x, size.y, size.z, headingOf(view->sensorFromBox.rotation)}, boxes);
    putPose(view->sensorFromBox, poses);
    putNumber(plan.classes.targetId(object.semantic), classes);
    putNumber(object.id, instances);
    putFloats({velocity.x, velocity.y, velocity.z}, velocities);
    putNumber(static_cast<std::uint32_t>(view->points), points);
    putFloats({view->visibility().value_or(std::numeric_limits<double>::quiet_NaN())}, visibilities);
  }
  add<float>("boxes", {count, 7}, boxes, files);
  add<double>("box_pose", {count, 4, 4}, poses, files);
  add<std::uint16_t>("box_class", {count}, classes, files);
  add<std::uint32_t>("box_instance", {count}, instances, files);
  add<float>("box_velocity", {count, 3}, velocities, files);
  add<std::uint32_t>("box_points", {count}, points, files);
  add<float>("box_visibility", {count}, visibilities, files);
}

std::string npzBytes(const ExportPlan& plan, const ExportSample& sample, const ExportScan& scan) {
  Files files;
  addPoints(plan, scan.scan, files);
  std::string poses;
  for (const Pose& pose : scan.record->worldFromSensor) putPose(pose, poses);
  add<double>("world_from_sensor", {scan.record->worldFromSensor.size(), 4, 4}, poses, files);
  if (sample.objects) addBoxes(plan, *sample.objects, scan, files);
  return zipOf(files);
}

}  // namespace

std::unique_ptr<ExportLayout> makeNpz() {
  return std::make_unique<ScanFiles>("npz", npzBytes);
}

}  // namespace scanmill
