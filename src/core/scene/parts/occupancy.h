#pragma once

// Which rectangles of the ground are taken.

#include <cstdint>
#include <unordered_map>
#include <vector>

#include "scene/parts/parts.h"

namespace scanmill::parts {

// The rectangle on the ground that something stands on (m, rad).
struct Footprint {
  Point2 center;
  double halfX = 0, halfY = 0;
  double yaw = 0;
};

class Occupancy {
 public:
  bool isFree(const Footprint& f) const;
  void add(const Footprint& f);

 private:
  std::vector<Footprint> taken_;
  std::unordered_map<std::uint64_t, std::vector<std::uint32_t>> cells_;  // that each rectangle's circle reaches into
};

}  // namespace scanmill::parts
