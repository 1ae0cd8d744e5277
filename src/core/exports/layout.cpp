#include "exports/layout.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "base/file.h"
#include "base/own_folder.h"
#include "config/fields.h"
#include "formats/little_endian.h"

namespace scanmill {

namespace {

constexpr std::array<LayoutEntry, 6> kLayouts{{
    {.name = "semantic_kitti",
     .summary = "sequences/NN with velodyne, labels, calib, poses and times",
     .labels = "semantic_kitti",
     .oneSensor = true,
     .revolutions = false,
     .voxels = true,
     .make = makeSemanticKitti},
    {.name = "kitti",
     .summary = "KITTI's object benchmark: velodyne, label_2, calib, image_2, ImageSets",
     .labels = "kitti",
     .oneSensor = true,
     .boxesAlone = true,
     .revolutions = false,
     .make = makeKitti},
    {.name = "nuscenes",
     .summary = "nuScenes' tables, boxes, lidarseg and panoptic",
     .labels = "nuscenes",
     .make = makeNuScenes},
    {.name = "las", .summary = "LAS 1.4, a file for each sequence; all columns as extra bytes", .make = makeLas},
    {.name = "ply", .summary = "PLY, a file for each scan, with labels and the classes' colours", .make = makePly},
    {.name = "mcap",
     .summary = "MCAP of ROS 2, a file for each sequence: PointCloud2, tf, markers of boxes",
     .make = makeMcap},
}};

}  // namespace

std::span<const LayoutEntry> layouts() {
  return kLayouts;
}

const LayoutEntry& requireLayout(std::string_view name) {
  return requireNamed(kLayouts, "layout", name);
}

bool listsObjects(const ExportPlan& plan) {
  const auto listed = [&](std::size_t number) { return plan.manifest.samples[number].objects.has_value(); };
  return std::ranges::all_of(
      plan.sequences, [&](const ExportSequence& sequence) { return std::ranges::all_of(sequence.samples, listed); });
}

std::vector<std::size_t> velodyneOrder(const ExportScan& exportScan) {
  const Scan& scan = exportScan.scan;
  struct OrderedPoint {
    std::int64_t ringFromTop;  // grows from the top ring down; its start does not matter
    double azimuth;            // rad, at least 0, counter-clockwise from straight ahead
    std::size_t index;
  };
  const bool hasRings = knowsBeams(scan) || !scan[kRing].empty();
  std::vector<OrderedPoint> points;
  points.reserve(scan.size());
  for (std::size_t i = 0; i < scan.size(); ++i) {
    const Vec3f& p = scan.position[i];
    if (!isFinite(p)) continue;
    const std::int64_t ring = !hasRings ? 0 : scan.organised ? keyOf(scan, i).ring : scan[kRing][i];
    const double azimuth = hasRings ? std::atan2(static_cast<double>(p.y), static_cast<double>(p.x)) : 0;
    points.push_back({exportScan.sensor->beams.topDown ? ring : -ring, azimuth < 0 ? azimuth + 2 * kPi : azimuth, i});
  }
  std::ranges::stable_sort(points, {},
                           [](const OrderedPoint& point) { return std::pair(point.ringFromTop, point.azimuth); });
  std::vector<std::size_t> order;
  order.reserve(points.size());
  for (const OrderedPoint& point : points) order.push_back(point.index);
  return order;
}

std::string velodynePoints(const ExportScan& exportScan, std::span<const std::size_t> order) {
  std::string bytes;
  bytes.reserve(order.size() * 16);
  for (const std::size_t i : order) {
    const Vec3f& p = exportScan.scan.position[i];
    for (const float value : {p.x, p.y, p.z, std::min(unitIntensity(exportScan, i), 1.0f)}) putNumber(value, bytes);
  }
  return bytes;
}

std::vector<std::string> skewWarnings(const ExportPlan& plan, std::string_view layout) {
  const auto moves = [](const SampleRecord& sample) {
    return std::ranges::any_of(sample.scans, [](const ScanRecord& scan) { return scan.worldFromSensor.size() > 1; });
  };
  if (plan.manifest.deskewed || std::ranges::none_of(plan.manifest.samples, moves)) return {};
  return {
      fmt::format("the sensors move during a revolution, and each point is in the sensor's frame at its own time, "
                  "which {} does not "
                  "store: for points that one pose places, generate with `motion: {{steps: per_column, deskew: true}}`",
                  layout)};
}

std::vector<const ScanRecord*> revolutionsOf(const ExportPlan& plan, const SampleRecord& sample, std::size_t sensor) {
  std::vector<const ScanRecord*> scans;
  for (const ScanRecord& scan : sample.scans) {
    const bool isOfSensor = scan.sensor == plan.sensors[sensor]->name;
    if (isOfSensor && (scans.empty() || scan.method == scans.front()->method)) scans.push_back(&scan);
  }
  return scans;
}

void requireDistinct(const ExportPlan& plan, std::string_view what,
                     const std::function<std::string(std::size_t)>& nameOf) {
  std::map<std::string, std::string> sensors;  // names of the sensors, by their names in the layout
  for (std::size_t i = 0; i < plan.sensors.size(); ++i) {
    const auto [other, isNew] = sensors.emplace(nameOf(i), plan.sensors[i]->name);
    if (isNew) continue;
    refuse(plan,
           "the sensors '{}' and '{}' would share the {} {}: export them one by one with "
           "--sensor, or give one another name",
           other->second, plan.sensors[i]->name, what, other->first);
  }
}

const ScanRecord& scanOf(const ExportPlan& plan, const SampleRecord& sample, std::size_t sensor) {
  const std::vector<const ScanRecord*> scans = revolutionsOf(plan, sample, sensor);
  if (!scans.empty()) return *scans.front();
  refuse(plan,
         "the sample {} has no scan of the sensor '{}': name another sensor with --sensor, or "
         "generate with the period of the slowest sensor as `every_s`",
         sample.key, plan.sensors[sensor]->name);
}

void ExportFolder::write(const std::filesystem::path& name, std::string_view bytes) const {
  writeFile(folder_, prepareFile(name), bytes);
}

std::filesystem::path ExportFolder::prepareFile(const std::filesystem::path& name) const {
  const std::filesystem::path path = folder_ / name;
  std::error_code failure;
  std::filesystem::create_directories(folder_, failure);
  if (failure) throw Error("{}: cannot be made: {}", folder_.string(), failure.message());
  makeFolders(folder_, path.parent_path());
  return path;
}

void ScanFiles::write(const ExportPlan& plan, std::size_t sequence, std::size_t frame, const ReadSample& read,
                      const ExportFolder& folder) const {
  const ExportSample sample = read(sequence, frame);
  for (const ExportScan& scan : sample.scans) {
    requireConsistent(scan.scan);
    const std::string file = fmt::format("{}.{}.{}", sample.record->key, revolutionName(*scan.record), suffix_);
    folder.write(std::filesystem::path(sample.record->split) / file, bytesOf_(plan, sample, scan));
  }
}

ColumnSet exportedColumns(const ExportPlan& plan, const Scan& scan) {
  if (scan.size() > 0) return columnsOf(scan);
  ColumnSet columns;
  for (const std::string& name : plan.manifest.columns) {
    const std::size_t index = columnIndex(name);
    if (index < kColumnCount) columns.add(index);  // x, y and z are not in the table
  }
  return columns;
}

}  // namespace scanmill
