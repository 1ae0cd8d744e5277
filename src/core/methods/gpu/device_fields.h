#pragma once

// Distance fields on a device. A field that has moved shares its bricks with the one before (field/brick_pool.h): only
// those that the device has not are uploaded.

#include <cstdint>
#include <list>
#include <memory>
#include <span>

#include "gpu/compute.h"
#include "methods/field/distance_field.h"

namespace scanmill {

class DeviceFields {
 public:
  // `mostTableBytes`: of one table.
  DeviceFields(const ComputeDevice& device, std::uint64_t mostTableBytes);

  // Uploads what of the field is not there. Bricks of other pools stay, those that were last used, up to kMostBytes: of
  // threads that work on drives of their own. Where memory is out, those go. Fails in the device's words where it does
  // not fit.
  void hold(const std::shared_ptr<const DistanceField>& field);

  // Of what was last held. Of each level two words of 16 bytes: the bits of its offset (float32), the first entry of
  // the table; the bricks along x, y and z.
  ComputeTable levels() const { return {&pools_.front().levels, ComputeTable::Texel::Uint32x4}; }
  ComputeTable table() const { return {&pools_.front().table, ComputeTable::Texel::Uint32}; }
  ComputeTable distances() const { return {&pools_.front().distances.buffer, ComputeTable::Texel::Uint16}; }
  ComputeTable words() const { return {&pools_.front().words.buffer, ComputeTable::Texel::Uint32}; }
  ComputeTable lists() const { return {&pools_.front().lists.buffer, ComputeTable::Texel::Uint32}; }

 private:
  static constexpr std::uint64_t kMostBytes = std::uint64_t{2} << 30;

  // An array of a pool, of which the beginning is there.
  struct Array {
    ComputeBuffer buffer;
    std::uint64_t there = 0;  // bytes
  };

  // A pool, and the last field of it that was held.
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
  std::list<HeldPool> pools_;  // the last used one first
};

}  // namespace scanmill
