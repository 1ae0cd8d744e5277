#include "methods/gpu/device_beams.h"

#include <algorithm>
#include <span>
#include <vector>

namespace scanmill {

namespace {

// Adds rows of rotation and position, pose after pose.
void appendPoses(const ShotFrame& frame, std::vector<double>& rows) {
  for (std::size_t step = 0; step < frame.rotation.size(); ++step) {
    const Mat3& r = frame.rotation[step];
    const Vec3d& p = frame.position[step];
    rows.insert(rows.end(), {r.x.x, r.y.x, r.z.x, p.x, r.x.y, r.y.y, r.z.y, p.y, r.x.z, r.y.z, r.z.z, p.z});
  }
}

std::vector<std::uint32_t> stepsOf(const Shot& shot) {
  std::vector<std::uint32_t> steps(shot.beams->columns);
  for (std::uint32_t c = 0; c < steps.size(); ++c) steps[c] = static_cast<std::uint32_t>(shot.stepOf(c));
  return steps;
}

}  // namespace

DeviceBeams::Table::Table(const ComputeDevice& device) : directions(device), origins(device), steps(device) {
  origins.reserve(16);  // a buffer without storage cannot be bound
}

DeviceBeams::DeviceBeams(const ComputeDevice& device) : device_(device), poses_(device) {}

void DeviceBeams::hold(const Shots& shots) {
  std::vector<double> poses;
  for (const ShotFrame* frame : shots.frames) appendPoses(*frame, poses);
  poses_.hold(std::span<const double>(poses));
  const Shot& shot = *shots.shots.front();
  const auto holds = [&](const Table& table) {
    return table.beams.lock() == shot.beams && table.poses == shot.worldFromSensor.size();
  };
  auto table = std::find_if(tables_.begin(), tables_.end(), holds);
  const bool known = table != tables_.end();
  if (!known) {
    table = std::find_if(tables_.begin(), tables_.end(), [](const Table& t) { return t.beams.expired(); });
    if (table == tables_.end() && tables_.size() < kTables) table = tables_.emplace(tables_.end(), device_);
    if (table == tables_.end()) --table;
  }
  tables_.splice(tables_.begin(), tables_, table);
  if (!known) fill(tables_.front(), shot);
}

void DeviceBeams::fill(Table& table, const Shot& shot) {
  const BeamTable& beams = *shot.beams;
  table.beams.reset();  // the buffers belong to no table until all are filled
  table.directions.hold(std::span(beams.direction));
  if (!beams.origin.empty()) table.origins.hold(std::span(beams.origin));
  const std::vector<std::uint32_t> steps = stepsOf(shot);
  table.steps.hold(std::span(steps));
  table.beams = shot.beams;
  table.poses = shot.worldFromSensor.size();
}

std::string DeviceBeams::shader() {
  return R"(
layout(std430, binding = 0) readonly restrict buffer Directions { double directions[]; };
layout(std430, binding = 1) readonly restrict buffer Origins { float origins[]; };
layout(std430, binding = 2) readonly restrict buffer Poses { double poses[]; };  // rows of rotation and position
layout(std430, binding = 3) readonly restrict buffer Steps { uint stepOfColumn[]; };

// Relative error assumed of quotients and roots: 2^-48, 16 units in the last place. OpenGL allows 2.5 units for
// quotients and 4.5 for roots.
const double kSlack = 3.5527136788005009e-15LF;

bool settled(double value, double doubt, out float rounded) {
  rounded = float(value);
  if (doubt == 0.0LF) return value == 0.0LF || abs(value) > 1e-37LF;  // devices may flush smaller values to 0
  return float(value - doubt) == rounded && float(value + doubt) == rounded && abs(rounded) > 1e-30;
}

double turned(uint row, dvec3 v) {
  precise double x = poses[row] * v.x + poses[row + 1u] * v.y + poses[row + 2u] * v.z;
  return x;
}

void rayOf(uint ray, uint column, uint firstPose, bool withOrigins, out dvec3 o, out dvec3 d) {
  uint pose = 12u * (firstPose + stepOfColumn[column]);
  dvec3 along = dvec3(directions[3u * ray], directions[3u * ray + 1u], directions[3u * ray + 2u]);
  d = dvec3(turned(pose, along), turned(pose + 4u, along), turned(pose + 8u, along));
  o = dvec3(poses[pose + 3u], poses[pose + 7u], poses[pose + 11u]);
  if (withOrigins) {
    dvec3 shift = dvec3(origins[3u * ray], origins[3u * ray + 1u], origins[3u * ray + 2u]);
    precise dvec3 moved = o + dvec3(turned(pose, shift), turned(pose + 4u, shift), turned(pose + 8u, shift));
    o = moved;
  }
}
)";
}

}  // namespace scanmill
