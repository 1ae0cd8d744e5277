#pragma once

// Colours for values, instances and classes, and names of classes.

#include <cstdint>
#include <string>

#include "scene/ontology.h"
#include "viewer/image.h"

namespace scanmill {

constexpr Rgb kBackground{13, 15, 20};
constexpr Rgb kNoValue{105, 108, 116};  // colour of points without an instance or with an unknown value

// Returns the colour at t of the colour map viridis (S. van der Walt and N. Smith, matplotlib, 2015; CC0), which is
// perceptually uniform, also in grey and for colour-blind people. t is clamped to the range 0 to 1.
Rgb viridis(double t);

// Returns the colour of an instance. Consecutive ids have very different hues; 0 (no instance) is grey.
Rgb instanceColor(std::uint32_t instance);

// Returns the colour of a class in the ontology, lightened if it is too dark for the background. If there is no
// ontology or the class is not in it, the colour is computed from the id.
Rgb classColor(const Ontology* ontology, std::uint16_t id);

// Returns the name of a class, such as "car"; if the class is not in the ontology, its id, such as "class 10".
std::string className(const Ontology* ontology, std::uint16_t id);

}  // namespace scanmill
