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

}  // namespace

DeviceBeams::DeviceBeams(const ComputeDevice& device) : device_(device), poses_(device) {}

void DeviceBeams::ensureUploaded(const Shots& shots) {
  std::vector<double> poses;
  for (const ShotFrame* frame : shots.frames) appendPoses(*frame, poses);
  poses_.upload(std::span<const double>(poses));
  const Shot& shot = *shots.shots.front();
  auto table = std::ranges::find_if(
      tables_, [&](const Table& t) { return t.beams.lock() == shot.beams && t.poses == shot.worldFromSensor.size(); });
  const bool isUploaded = table != tables_.end();
  if (!isUploaded) {  // use a table that no longer exists, a new one or the least recently used one
    table = std::ranges::find_if(tables_, [](const Table& t) { return t.beams.expired(); });
    if (table == tables_.end() && tables_.size() < kTables) table = tables_.emplace(tables_.end(), device_);
    if (table == tables_.end()) --table;
  }
  tables_.splice(tables_.begin(), tables_, table);
  if (!isUploaded) upload(tables_.front(), shot);
}

// Uploads the rays of the shot's beam table, and the pose of each column.
void DeviceBeams::upload(Table& table, const Shot& shot) {
  const BeamTable& beams = *shot.beams;
  table.beams.reset();  // until all buffers are filled, they belong to no beam table
  table.directions.upload(std::span(beams.direction));
  if (!beams.origin.empty()) table.origins.upload(std::span(beams.origin));
  std::vector<std::uint32_t> steps(beams.columns);
  for (std::uint32_t c = 0; c < steps.size(); ++c) steps[c] = static_cast<std::uint32_t>(shot.stepOf(c));
  table.steps.upload(std::span<const std::uint32_t>(steps));
  table.beams = shot.beams;
  table.poses = shot.worldFromSensor.size();
}

}  // namespace scanmill
