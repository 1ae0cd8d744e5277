#pragma once

// Particles of any kind through the program that takes steps on a device.

#include <memory>
#include <span>
#include <vector>

#include "methods/gpu/device_march.h"
#include "methods/particle/particles.h"
#include "tests/support/gl.h"

namespace scanmill {

class GlMarch {
 public:
  // `mostTexels`: of one table.
  explicit GlMarch(std::uint64_t mostTexels = std::numeric_limits<std::uint64_t>::max())
      : device_({"particles cannot march by OpenGL", "`backend: cpu` does not need it"}, {.tableTexels = mostTexels}) {}

  // Marches particles that have taken no step, as marchCpu() does.
  HitRecords march(const std::shared_ptr<const DistanceField>& field, const std::shared_ptr<const World>& world,
                   std::uint32_t steps, const Particles& p) {
    march_.ensureUploaded(field, world);
    HitRecords records;
    records.reset(p.size());
    if (p.size() == 0) return records;
    const bool lists = field->shape.lists;
    const std::size_t bytes = p.size() * sizeof(float);
    std::vector<const std::vector<float>*> columns;
    const auto addAll = [&](const Particles::Vectors& vectors) {
      for (const auto& column : vectors) columns.push_back(&column);
    };
    addAll(p.origin);
    addAll(p.direction);
    columns.insert(columns.end(), {&p.begin, &p.end});
    if (lists) addAll(p.worldOrigin);
    if (lists) addAll(p.inverse);
    march_.reserve(lists, p.size());
    for (std::size_t k = 0; k < columns.size(); ++k) {
      march_.particles().write(k * bytes, std::as_bytes(std::span(*columns[k])));
    }
    march_.run(*field, steps, p.size(), DeviceMarch::Marching::All);
    // The quotient of the last two is m, and lacks in the way.
    std::vector<float> numerator(p.size());
    std::vector<float> denominator(p.size());
    const auto made = copyOf<std::byte>(device_, march_.records(), (lists ? 5 : 3) * bytes);
    std::size_t taken = 0;
    const auto take = [&](auto& column) { std::memcpy(column.data(), &made[taken++ * bytes], bytes); };
    take(records.travelled);
    take(records.triangle);
    take(records.outcome);
    if (lists) take(numerator);
    if (lists) take(denominator);
    const auto metres = static_cast<float>(field->shape.voxel);
    for (std::size_t i = 0; i < p.size() && lists; ++i) {
      if (records.outcomeOf(i) == Outcome::Hit) records.travelled[i] += numerator[i] / (denominator[i] * metres);
    }
    return records;
  }

 private:
  ComputeDevice device_;
  DeviceMarch march_{device_};
};

}  // namespace scanmill
