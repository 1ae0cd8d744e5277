#pragma once

// Marches particles on a device, through fields that stay there between calls.

#include <cstddef>
#include <cstdint>
#include <memory>

#include "gpu/compute.h"
#include "methods/field/distance_field.h"
#include "methods/gpu/device_fields.h"
#include "methods/gpu/march_gl.h"
#include "methods/world/world.h"

namespace scanmill {

class DeviceMarch {
 public:
  // `mostTableBytes`: largest size of a table (bytes).
  DeviceMarch(const ComputeDevice& device, std::uint64_t mostTableBytes);

  // Number of float32 columns of the particles, in fields with lists (most) and without lists (fewest).
  static constexpr std::uint64_t kMostColumns = 14;
  static constexpr std::uint64_t kFewestColumns = 8;

  // Uploads the parts of a field that are not on the device yet. If the field has lists, also uploads the world's
  // triangles, unless they are on the device. Throws an Error, worded by ComputeErrorWords, if something does not fit.
  void hold(const std::shared_ptr<const DistanceField>& field, const std::shared_ptr<const World>& world);

  // reserve() makes room for `particles` particles and their records; run() marches them through the field of the last
  // hold(). `again`: marches only the particles that continue behind a hole.
  void reserve(bool lists, std::size_t particles);
  void run(const DistanceField& field, std::uint32_t steps, std::size_t particles, bool again);

  // Return the buffers for the bindings 0 and 1 of marchShader() (shaders.h), and the fields on the device.
  ComputeBuffer& particles() { return particles_; }
  const ComputeBuffer& records() const { return records_; }
  const DeviceFields& fields() const { return fields_; }

 private:
  ComputeDevice device_;
  const std::uint64_t mostTableBytes_;
  MarchPrograms marchers_;
  ComputeBuffer particles_, records_, triangles_;
  DeviceFields fields_;
  std::weak_ptr<const World> world_;  // the world whose triangles are uploaded
};

}  // namespace scanmill
