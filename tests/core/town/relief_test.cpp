#include "town/relief.h"

#include <array>
#include <set>

namespace scanmill::town {
namespace {

// The gradients of two fields, or of a field at two seeds, are nowhere those of one lattice.
TEST(Relief, EachFieldHasALatticeOfItsOwnAtEachSeed) {
  std::set<std::array<double, 12>> values;
  std::size_t fields = 0;
  for (std::uint64_t seed = 0; seed < 64; ++seed) {
    for (std::uint32_t field = 1; field < static_cast<std::uint32_t>(Field::Count); ++field) {
      for (const std::uint32_t number : {0, 1, 2}) {
        std::array<double, 12> row{};
        for (std::size_t i = 0; i < row.size(); ++i) {
          row[i] = relief({seed, static_cast<Field>(field), number}, 0.3 + static_cast<double>(i), 0.6, 1);
        }
        values.insert(row);
        ++fields;
      }
    }
  }
  EXPECT_EQ(values.size(), fields);
}

}  // namespace
}  // namespace scanmill::town
