#pragma once

// The beams of a shot on a device, for shaders that make its rays there: a table stays, only poses travel.

#include <cstddef>
#include <cstdint>
#include <list>
#include <memory>
#include <string>
#include <vector>

#include "gpu/compute.h"
#include "methods/world/resolve.h"
#include "sensors/shot.h"

namespace scanmill {

class DeviceBeams {
 public:
  explicit DeviceBeams(const ComputeDevice& device);

  // So many bytes of a ray are in the largest buffer, of directions.
  static constexpr std::uint64_t kBytesPerRay = 24;

  // Shots of one table that a device traces together, with as many poses each, and their frames (frameOf()).
  struct Shots {
    std::vector<const Shot*> shots;
    std::vector<const ShotFrame*> frames;
  };

  // Uploads the rays of the shots' table, unless they are there, and the shots' poses. Tables stay, those that were
  // last used: of the sensors of a vehicle.
  void hold(const Shots& shots);

  // Bindings 0 to 3 of programs that use shader(), of what was last held.
  const ComputeBuffer& directions() const { return tables_.front().directions; }
  const ComputeBuffer& origins() const { return tables_.front().origins; }
  const ComputeBuffer& poses() const { return poses_; }
  const ComputeBuffer& steps() const { return tables_.front().steps; }

  // GLSL that declares the buffers and
  //
  //     void rayOf(uint ray, uint column, uint firstPose, bool withOrigins, out dvec3 o, out dvec3 d)
  //
  // which gives the origin (m, relative to the world's origin) and the unit direction of a ray with the bits that
  // setUp() in methods/world/resolve.h gives them. `firstPose`: of the shot, counted from that of the first.
  //
  //     bool settled(double value, double doubt, out float rounded)
  //
  // tells whether a float32 has the same bits wherever within the doubt the value lies; kSlack is the share by which a
  // quotient or a root may err.
  static std::string shader();

 private:
  static constexpr std::size_t kTables = 8;

  struct Table {
    explicit Table(const ComputeDevice& device);

    std::weak_ptr<const BeamTable> beams;  // whose rays the buffers hold
    std::size_t poses = 0;                 // of a shot, for which `steps` is
    ComputeBuffer directions, origins, steps;
  };

  static void fill(Table& table, const Shot& shot);

  ComputeDevice device_;
  std::list<Table> tables_;  // the last used one first
  ComputeBuffer poses_;
};

}  // namespace scanmill
