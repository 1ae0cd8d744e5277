#pragma once

// Colours for numbers, instances and classes, and the names of these.

#include <cstdint>
#include <string>

#include "scene/ontology.h"
#include "viewer/image.h"

namespace scanmill {

constexpr Rgb kBackground{13, 15, 20};
constexpr Rgb kPanel{24, 27, 34};
constexpr Rgb kText{225, 228, 235};
constexpr Rgb kNoValue{105, 108, 116};  // points without an instance, or whose value is not a number

// The colour map viridis (S. van der Walt and N. Smith, matplotlib, 2015; CC0): perceptually even, also in grey and for
// the colour-blind. t from 0 to 1; beyond, its ends.
Rgb viridis(double t);

// Neighbouring ids get hues far apart; 0 (no instance) is grey.
Rgb instanceColor(std::uint32_t instance);

// The ontology's colour, lifted where it is too dark to be seen on the background. Without an ontology, or for a class
// that it does not know, a colour that follows from the id.
Rgb classColor(const Ontology* ontology, std::uint16_t id);

// "car", or "class 10" where nobody knows its name.
std::string className(const Ontology* ontology, std::uint16_t id);

}  // namespace scanmill
