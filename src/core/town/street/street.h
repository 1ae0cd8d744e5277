#pragma once

// The procedural street, a scene that needs no download. It depends only on its parameters and the seed.

#include <cstdint>

#include "base/vec.h"
#include "config/fields.h"
#include "scene/builder.h"

namespace scanmill {

// Adds a street along x, centred at the origin of its frame, with the road's surface at z = 0 and right-hand traffic.
// `fields` are the keys of `street:` in a scene file: lengths, widths, and densities of objects. Calls fields.finish().
// Throws InputError with the place in the file.
void addStreet(SceneBuilder& builder, Fields& fields, std::uint64_t seed, const Affine& worldFromStreet);

}  // namespace scanmill
