#pragma once

// Colours for numbers, instances and classes, and the names of classes.

#include <cstdint>
#include <string>

#include "scene/ontology.h"
#include "viewer/image.h"

namespace scanmill {

constexpr Rgb kBackground{13, 15, 20};
constexpr Rgb kPanel{24, 27, 34};
constexpr Rgb kText{225, 228, 235};
constexpr Rgb kNoValue{105, 108, 116};  // for points without an instance or with an unknown value

// Returns the colour at t of the map viridis (S. van der Walt and N. Smith, matplotlib, 2015; CC0), which is
// perceptually uniform, also in grey and for the colour-blind. t is clamped to 0 to 1.
Rgb viridis(double t);

// Returns the colour of an instance. Neighbouring ids get hues far apart; 0 (no instance) is grey.
Rgb instanceColor(std::uint32_t instance);

// Returns the ontology's colour of the class, lightened if it is too dark to be seen on the background. Without an
// ontology, or for a class that the ontology does not list, the colour follows from the id.
Rgb classColor(const Ontology* ontology, std::uint16_t id);

// Returns the name of the class: "car", or "class 10" if the ontology does not list it.
std::string className(const Ontology* ontology, std::uint16_t id);

}  // namespace scanmill
