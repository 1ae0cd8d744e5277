#include "methods/ray_tracing/held_world.h"

#include <span>
#include <string>
#include <utility>

#include "base/parallel.h"

namespace scanmill {

namespace {

constexpr std::size_t kHoles = 3;  // binding of the only table of single words

}  // namespace

HeldWorld::HeldWorld(const ComputeDevice& device, std::uint64_t most)
    : device_(device),
      most_(most),
      embree_(makeDevice()),
      nodes_(device),
      triangles_(device),
      cutouts_(device),
      holes_(device),
      placeNodes_(device),
      places_(device) {
  // Buffers without storage cannot be read from.
  for (ComputeBuffer* buffer : {&nodes_, &triangles_, &cutouts_, &holes_, &placeNodes_, &places_}) buffer->reserve(16);
}

std::shared_ptr<const WorldPlaces> HeldWorld::placesOf(const std::shared_ptr<const World>& world) const {
  std::shared_ptr<const DeviceBlocks> blocks;
  {
    const std::scoped_lock lock(mutex_);
    if (world->shared->number == shared_ && world_.lock() != world) blocks = blocks_;
  }
  return blocks != nullptr && world->baked.triangles.empty() ? makePlaces(*world, std::move(blocks)) : nullptr;
}

std::shared_ptr<const WorldPlaces> HeldWorld::makePlaces(const World& world,
                                                         std::shared_ptr<const DeviceBlocks> blocks) const {
  auto made = std::make_shared<WorldPlaces>();
  isolated([&] {
    made->places = devicePlaces(embree_.get(), world, *blocks);
    made->stands = standsOf(world);
  });
  made->blocks = std::move(blocks);
  return made;
}

void HeldWorld::hold(const std::shared_ptr<const World>& world, std::shared_ptr<const WorldPlaces> places,
                     DeviceResolver& resolver) {
  const bool baked = !world->baked.triangles.empty();
  std::shared_ptr<const DeviceBlocks> blocks;
  {
    const std::scoped_lock lock(mutex_);
    if (world_.lock() == world) return;
    world_.reset();
    if (!baked && world->shared->number == shared_) blocks = blocks_;
    if (blocks == nullptr) shared_ = 0;
  }
  if (blocks == nullptr) blocks = holdMeshes(*world, resolver);
  if (places == nullptr || places->blocks != blocks) places = makePlaces(*world, blocks);
  hold(placeNodes_, places->places.nodes, "hierarchy of placed meshes");
  hold(places_, places->places.places, "placed meshes");
  resolver.holdPlaces(places->stands);
  meshRoot_ = baked ? blocks->at(&world->baked).root : kNoRoot;
  placesRoot_ = places->places.nodes.empty() ? kNoRoot : 0;
  const std::scoped_lock lock(mutex_);
  world_ = world;
  shared_ = baked ? 0 : world->shared->number;
  blocks_ = std::move(blocks);
}

std::shared_ptr<const DeviceBlocks> HeldWorld::holdMeshes(const World& world, DeviceResolver& resolver) {
  DeviceMeshes meshes = deviceMeshes(embree_.get(), world);
  hold(nodes_, meshes.nodes, "hierarchies");
  hold(triangles_, meshes.triangles, "triangles");
  hold(cutouts_, meshes.cutouts, "cut-out triangles");
  hold(holes_, meshes.holes, "cut-outs");
  resolver.holdMeshes(world);
  device_.finish();
  return std::make_shared<const DeviceBlocks>(std::move(meshes.blocks));
}

template <class T>
void HeldWorld::hold(ComputeBuffer& buffer, const std::vector<T>& array, const char* what) {
  const bool words = &buffer != &holes_;
  holdTable(device_, buffer, words ? ComputeTable::Texel::Uint32x4 : ComputeTable::Texel::Uint32,
            std::as_bytes(std::span(array)), most_, std::string("scene's ") + what);
}

ComputeTable HeldWorld::table(std::size_t binding) const {
  const std::array<const ComputeBuffer*, 6> buffers{&nodes_, &triangles_, &cutouts_, &holes_, &placeNodes_, &places_};
  return {buffers[binding], binding == kHoles ? ComputeTable::Texel::Uint32 : ComputeTable::Texel::Uint32x4};
}

}  // namespace scanmill
