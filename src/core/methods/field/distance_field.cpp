#include "methods/field/distance_field.h"

namespace scanmill {

std::uint64_t DistanceField::bytes() const {
  const auto of = [](const auto& array) { return std::uint64_t{array.size()} * sizeof array[0]; };
  return of(levels) + of(table) + of(distance) + of(word) + of(lists);
}

}  // namespace scanmill
