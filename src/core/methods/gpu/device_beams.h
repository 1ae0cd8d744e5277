#pragma once

// The beams of a shot on a device, for shaders that compute its rays there. Beam tables stay on the device; only poses
// are uploaded for each shot.

#include <cstddef>
#include <cstdint>
#include <list>
#include <memory>
#include <vector>

#include "gpu/compute.h"
#include "methods/world/resolve.h"
#include "sensors/shot.h"

namespace scanmill {

class DeviceBeams {
 public:
  explicit DeviceBeams(const ComputeDevice& device);

  // Bytes per ray in the largest buffer, that of directions.
  static constexpr std::uint64_t kBytesPerRay = 24;

  // Shots that a device traces together, and their frames (frameOf()). The shots have the same beam table and equally
  // many poses.
  struct Shots {
    std::vector<const Shot*> shots;
    std::vector<const ShotFrame*> frames;
  };

  // Uploads the shots' poses and, unless the device has them already, the rays of their table. The kTables most
  // recently used tables stay on the device, for the sensors of a vehicle.
  void ensureUploaded(const Shots& shots);

  // Buffers for the bindings 0 to 3 of programs that include rays.glsl, with the shots of the last ensureUploaded().
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

  static void upload(Table& table, const Shot& shot);

  ComputeDevice device_;
  std::list<Table> tables_;  // most recently used first
  ComputeBuffer poses_;
};

}  // namespace scanmill
