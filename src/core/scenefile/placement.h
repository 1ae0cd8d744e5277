#pragma once

// The placement of an object of a scene file: position, rotation, scale and copies.

#include <array>
#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "base/vec.h"
#include "config/fields.h"

namespace scanmill {

// Position and rotation define the object's frame. A copy's position in that frame is the position of its grid
// cell plus its own position; its scale is multiplied by the object's. Scales act only on the geometry, not on the
// distances between copies. The grid is not centred: its first cell is at the object's position. Copies are ordered by
// grid cell (x fastest, then y, then z), and within each cell as in `at`.
struct Placement {
  struct Copy {
    Pose pose;
    Vec3d scale{1, 1, 1};
  };
  Copy object;
  std::vector<Copy> at{Copy{}};  // the copies of each grid cell
  std::array<std::int64_t, 3> gridCount{1, 1, 1};
  Vec3d gridSpacing;

  // Returns how many copies a scene may have: ten million, or fewer if they would take more than half of the memory
  // that is allowed (base/memory.h).
  static std::uint64_t mostCopies();
  // Returns the end of a message that refuses more: "at most 10,000,000 are possible".
  static std::string mostCopiesText();

  // Returns the number of copies; 1 if the object has no key `copies`.
  std::uint64_t count() const;
  // Calls visit(worldFromMesh) for each copy, in order.
  void forEach(const std::function<void(const Affine&)>& visit) const;
};

// Reads the keys `position`, of rotations, `scale`, `copies.at` and `copies.grid` from an object's map (docs/keys.md).
// Throws InputError with the place; for more than mostCopies() the message gives the number of copies and the factors
// that it is the product of.
Placement readPlacement(Fields& object);

// Reads [[x, y], [x, y]], two corners of a rectangle; returns the least x and y, then the greatest. Throws InputError.
std::array<double, 4> readRectangle(const Value& value, std::string_view key);

}  // namespace scanmill
