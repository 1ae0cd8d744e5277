#pragma once

// Beams on a device, for shaders that compute rays. Beam tables stay on the device; each shot's poses are uploaded.

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <list>
#include <memory>
#include <span>
#include <vector>

#include "gpu/compute.h"
#include "methods/world/resolve.h"
#include "sensors/shot.h"

namespace scanmill {

class DeviceBeams {
 public:
  explicit DeviceBeams(const ComputeDevice& device) : device_(device), poses_(device) {}

  // Bytes per ray in the buffer of directions, which is the largest buffer.
  static constexpr std::uint64_t kBytesPerRay = 24;

  // Shots that a device traces together, and each shot's frameOf(). All shots have the same table and number of poses.
  struct Shots {
    std::vector<const Shot*> shots;
    std::vector<const ShotFrame*> frames;
  };

  // Uploads the shots' poses and, unless the device has them already, the rays of their table. The kTables most
  // recently used tables stay on the device, because the sensors of a vehicle take turns.
  void ensureUploaded(const Shots& shots) {
    std::vector<double> poses;  // per pose 12 numbers: for x, y and z, the rotation's row and the position's component
    for (const ShotFrame* frame : shots.frames) {
      for (std::size_t step = 0; step < frame->rotation.size(); ++step) {
        const std::array<double, 16> rows = matrixRows({frame->rotation[step], frame->position[step]});
        poses.insert(poses.end(), rows.begin(), rows.begin() + 12);
      }
    }
    poses_.upload(std::span<const double>(poses));
    const Shot& shot = *shots.shots.front();
    auto table = std::ranges::find_if(tables_, [&](const Table& t) {
      return t.beams.lock() == shot.beams && t.poses == shot.worldFromSensor.size();
    });
    const bool isUploaded = table != tables_.end();
    if (!isUploaded) {  // replace a table that no longer exists, add one, or replace the least recently used
      table = std::ranges::find_if(tables_, [](const Table& t) { return t.beams.expired(); });
      if (table == tables_.end() && tables_.size() < kTables) table = tables_.emplace(tables_.end(), device_);
      if (table == tables_.end()) --table;
    }
    tables_.splice(tables_.begin(), tables_, table);
    if (!isUploaded) upload(tables_.front(), shot);
  }

  // Return the buffers for the bindings 0 to 3 of programs that include rays.glsl, for the shots of ensureUploaded().
  const ComputeBuffer& directions() const { return tables_.front().directions; }
  const ComputeBuffer& origins() const { return tables_.front().origins; }
  const ComputeBuffer& poses() const { return poses_; }
  const ComputeBuffer& steps() const { return tables_.front().steps; }

 private:
  static constexpr std::size_t kTables = 8;

  struct Table {
    explicit Table(const ComputeDevice& device) : directions(device), origins(device), steps(device) {}

    std::weak_ptr<const BeamTable> beams;  // the table whose rays are in the buffers
    std::size_t poses = 0;                 // poses per shot for which `steps` is computed
    ComputeBuffer directions, origins, steps;
  };

  // Uploads the rays of the shot's beam table, and for each column the index of its pose (Shot::stepOf()).
  static void upload(Table& table, const Shot& shot) {
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

  ComputeDevice device_;
  std::list<Table> tables_;  // most recently used first
  ComputeBuffer poses_;
};

}  // namespace scanmill
