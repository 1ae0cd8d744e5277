#pragma once

// The world that a device holds for tracing rays.

#include <cstdint>
#include <memory>
#include <mutex>
#include <vector>

#include "gpu/compute.h"
#include "methods/device/device_resolver.h"
#include "methods/device/device_tables.h"
#include "methods/ray_tracing/device_world.h"
#include "methods/world/world.h"

namespace scanmill {

// How a world's meshes stand.
struct WorldPlaces {
  std::shared_ptr<const DeviceBlocks> blocks;  // of the meshes on the device, which the places name
  DevicePlaces places;
  std::vector<Stand> stands;
};

class HeldWorld {
 public:
  // `most`: bytes of a table.
  HeldWorld(const ComputeDevice& device, std::uint64_t most);

  // Of a world all of whose meshes are shared, where they were held before and the world is not. Else null. Any thread
  // may call it, while others hold worlds: where something moves, it is the only work for a revolution that grows with
  // the scene.
  std::shared_ptr<const WorldPlaces> placesOf(const std::shared_ptr<const World>& world) const;

  // Uploads what of the world is not there, its planes and labels to the resolver. Meshes that revolutions share stay;
  // where they stand is told anew for each, without waiting for the one before. `places`: of placesOf(), or null. One
  // thread at a time. Throws Error where it does not fit.
  void hold(const std::shared_ptr<const World>& world, std::shared_ptr<const WorldPlaces> places,
            DeviceResolver& resolver);

  // Of what was last held: tables 0 to 5 of traceShader() (gl_tracer.h).
  ComputeTable table(std::size_t binding) const;
  std::uint32_t meshRoot() const { return meshRoot_; }
  std::uint32_t placesRoot() const { return placesRoot_; }

 private:
  std::shared_ptr<const DeviceBlocks> holdMeshes(const World& world, DeviceResolver& resolver);
  std::shared_ptr<const WorldPlaces> makePlaces(const World& world, std::shared_ptr<const DeviceBlocks> blocks) const;
  template <class T>
  void hold(ComputeBuffer& buffer, const std::vector<T>& array, const char* what);

  ComputeDevice device_;
  const std::uint64_t most_;
  DeviceHandle embree_;
  ComputeBuffer nodes_, triangles_, cutouts_, holes_, placeNodes_, places_;
  std::uint32_t meshRoot_ = kNoRoot;
  std::uint32_t placesRoot_ = kNoRoot;

  mutable std::mutex mutex_;          // of what follows
  std::weak_ptr<const World> world_;  // whose data the buffers hold
  std::uint64_t shared_ = 0;          // likewise: the number of the shared meshes, if nothing is baked besides
  std::shared_ptr<const DeviceBlocks> blocks_;  // of these meshes
};

}  // namespace scanmill
