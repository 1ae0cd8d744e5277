#pragma once

// Particles that march on a device, through fields that stay there between calls.

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
  // `mostTableBytes`: of one table.
  DeviceMarch(const ComputeDevice& device, std::uint64_t mostTableBytes);

  // So many columns of float32 have the particles of fields with lists, and without.
  static constexpr std::uint64_t kMostColumns = 14;
  static constexpr std::uint64_t kFewestColumns = 8;

  // Uploads what of a field and, for one with lists, of the world's triangles is not there. Fails in the device's words
  // where it does not fit.
  void hold(const std::shared_ptr<const DistanceField>& field, const std::shared_ptr<const World>& world);

  // Makes room for so many particles and their records, and lets them march through the field that is held. `again`:
  // those alone that go on behind a hole.
  void reserve(bool lists, std::size_t particles);
  void run(const DistanceField& field, std::uint32_t steps, std::size_t particles, bool again);

  // Storage buffers 0 and 1 of marchShader() (march_gl.h), and the field that is held.
  ComputeBuffer& particles() { return particles_; }
  const ComputeBuffer& records() const { return records_; }
  const DeviceFields& fields() const { return fields_; }

 private:
  ComputeDevice device_;
  const std::uint64_t mostTableBytes_;
  MarchPrograms marchers_;
  ComputeBuffer particles_, records_, triangles_;
  DeviceFields fields_;
  std::weak_ptr<const World> world_;  // whose triangles
};

}  // namespace scanmill
