#include "methods/gpu/device_beams.h"

#include <algorithm>
#include <span>

namespace scanmill {

namespace {

// Appends 12 numbers per pose: each row of the rotation, followed by a component of the position.
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

DeviceBeams::DeviceBeams(const ComputeDevice& device) : device_(device), poses_(device) {}

void DeviceBeams::ensureUploaded(const Shots& shots) {
  std::vector<double> poses;
  for (const ShotFrame* frame : shots.frames) appendPoses(*frame, poses);
  poses_.upload(std::span<const double>(poses));
  const Shot& shot = *shots.shots.front();
  const auto hasRays = [&](const Table& table) {
    return table.beams.lock() == shot.beams && table.poses == shot.worldFromSensor.size();
  };
  auto table = std::find_if(tables_.begin(), tables_.end(), hasRays);
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
  table.beams.reset();  // until all buffers are filled, they belong to no beam table
  table.directions.upload(std::span(beams.direction));
  if (!beams.origin.empty()) table.origins.upload(std::span(beams.origin));
  const std::vector<std::uint32_t> steps = stepsOf(shot);
  table.steps.upload(std::span(steps));
  table.beams = shot.beams;
  table.poses = shot.worldFromSensor.size();
}

}  // namespace scanmill
