#pragma once

// The procedural street, a scene that needs no download. All of it follows from its parameters and the seed.

#include <cstdint>

#include "base/vec.h"
#include "config/fields.h"
#include "scene/builder.h"

namespace scanmill {

// Adds a street along x, centred at the origin of its frame, with the road's surface at z = 0. Traffic keeps to the
// right. `fields` is the street's map in a scene file: lengths, widths, and densities of things; finish() is called
// here. Throws InputError with the place.
void addStreet(SceneBuilder& builder, Fields& fields, std::uint64_t seed, const Affine& worldFromStreet);

}  // namespace scanmill
