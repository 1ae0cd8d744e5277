#pragma once

// The procedural street: the scene that needs no download. Everything follows from the seed.

#include <cstdint>

#include "base/vec.h"
#include "config/fields.h"
#include "scene/builder.h"

namespace scanmill {

// Adds a street along x, centred at the origin, its road's surface at z = 0. `fields` is the street's map in the scene
// YAML: length, widths, and densities per class; finish() is called here. The vehicle drives on the right lane.
void addStreet(SceneBuilder& builder, Fields& fields, std::uint64_t seed, const Affine& worldFromStreet);

}  // namespace scanmill
