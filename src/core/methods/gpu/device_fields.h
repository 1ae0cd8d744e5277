#pragma once

// Distance fields on a device. When a field moves with its sensor, the field at the new position shares a pool of
// bricks with the field at the previous position (methods/field/brick_pool.h). Only bricks that are not on the device
// yet are uploaded.

#include <cstdint>
#include <list>
#include <memory>
#include <span>

#include "gpu/compute.h"
#include "methods/field/distance_field.h"

namespace scanmill {

class DeviceFields {
 public:
  // `mostTableBytes`: largest size of a table (bytes).
  DeviceFields(const ComputeDevice& device, std::uint64_t mostTableBytes);

  // Uploads the parts of the field that are not on the device yet. The pools of earlier fields stay on the device, for
  // threads that work on other trajectories. If a new pool would probably bring the total above kMostBytes, it replaces
  // the least recently used one; if memory runs out, all other pools are dropped. Throws an Error with the device's
  // ComputeErrorWords if the field does not fit even then.
  void hold(const std::shared_ptr<const DistanceField>& field);

  // The tables of the field of the last hold(). levels() has two words of 16 bytes per level: the bits of the level's
  // offset (float32) with the index of its first entry in the table, then its numbers of bricks along x, y and z.
  ComputeTable levels() const { return {&pools_.front().levels, ComputeTable::Texel::Uint32x4}; }
  ComputeTable table() const { return {&pools_.front().table, ComputeTable::Texel::Uint32}; }
  ComputeTable distances() const { return {&pools_.front().distances.buffer, ComputeTable::Texel::Uint16}; }
  ComputeTable words() const { return {&pools_.front().words.buffer, ComputeTable::Texel::Uint32}; }
  ComputeTable lists() const { return {&pools_.front().lists.buffer, ComputeTable::Texel::Uint32}; }

 private:
  static constexpr std::uint64_t kMostBytes = std::uint64_t{2} << 30;

  // An array of a pool, whose first `there` bytes are uploaded.
  struct Array {
    ComputeBuffer buffer;
    std::uint64_t there = 0;  // number of uploaded bytes
  };

  // A pool on the device. `field`: the pool's field that was uploaded last.
  struct HeldPool {
    explicit HeldPool(const ComputeDevice& device);
    std::uint64_t bytes() const;

    std::weak_ptr<const BrickPool> pool;
    std::weak_ptr<const DistanceField> field;
    ComputeBuffer levels, table;
    Array distances, words, lists;
  };

  void take(const std::shared_ptr<const BrickPool>& pool);
  void upload(const std::shared_ptr<const DistanceField>& field);
  template <class T>
  void append(Array& array, ComputeTable::Texel texel, std::span<const T> all, std::size_t room, const char* what);

  ComputeDevice device_;
  std::uint64_t mostTableBytes_;
  std::list<HeldPool> pools_;  // most recently used first
};

}  // namespace scanmill
