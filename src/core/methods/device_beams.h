#pragma once

// The beams of a shot on a device, for shaders that make its rays there: a table stays, only poses travel.

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>

#include "gpu/compute.h"
#include "methods/world/resolve.h"
#include "sensors/shot.h"

namespace scanmill {

class DeviceBeams {
 public:
  explicit DeviceBeams(const ComputeDevice& device);

  // So many bytes of a ray are in the largest buffer, of directions.
  static constexpr std::uint64_t kBytesPerRay = 24;

  // Uploads the rays [first, first + count) of the shot's table, unless they are there, and its poses. `frame` is the
  // shot's (frameOf()). `duration`: s, of the revolution, where something moves; else 0.
  void hold(const Shot& shot, const ShotFrame& frame, std::size_t first, std::size_t count, double duration);

  // Bindings 0 to 4 of programs that use shader().
  const ComputeBuffer& directions() const { return directions_; }
  const ComputeBuffer& origins() const { return origins_; }
  const ComputeBuffer& parts() const { return parts_; }
  const ComputeBuffer& poses() const { return poses_; }
  const ComputeBuffer& steps() const { return steps_; }

  // GLSL that declares the buffers and
  //
  //     void rayOf(uint ray, uint column, bool withOrigins, out dvec3 o, out dvec3 d)
  //
  // which gives the origin (m, relative to the world's origin) and the unit direction of a ray, counted from `first`,
  // with the bits that setUp() in methods/world/resolve.h gives them; parts[ray] is when it fires, as part of the
  // revolution (partOf() there).
  static std::string shader();

 private:
  ComputeBuffer directions_, origins_, parts_, poses_, steps_;
  std::weak_ptr<const BeamTable> beams_;  // whose rays the buffers hold
  std::size_t first_ = 0;
  std::size_t count_ = 0;
  double duration_ = 0;
};

}  // namespace scanmill
