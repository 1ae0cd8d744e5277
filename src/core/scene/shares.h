#pragma once

// Bounds on the share of a class among a sensor's hits: the key `shares` of a town. This header is installed because
// scene/scene.h includes it.
//
//   for (const ShareBound& bound : scene.shares) {
//     if (!bound.met()) std::puts(bound.name.c_str());
//   }

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "config/value.h"
#include "scene/ontology.h"

namespace scanmill {

// Groups of objects whose numbers can change while the roads, plots and houses of a town stay the same.
enum class Supply : std::uint8_t { Greenery, Vehicles, People };
constexpr std::size_t kSupplies = 3;

// Factors on the numbers of objects that the seed gives, indexed by Supply.
using SupplyFactors = std::array<double, kSupplies>;

// Bounds on the share of some classes in the hits of a sensor above the lane.
struct ShareBound {
  std::string name;                    // name of a class or of a supply
  std::vector<std::uint16_t> classes;  // ids of the class, or of all classes of the supply
  Supply supply = Supply::Vehicles;    // the supply that influences the share
  double least = 0, most = 1;
  double found = 0;  // the measured share; 0 before the measurement

  bool met() const { return found >= least && found <= most; }
};

std::string_view nameOf(Supply supply);  // returns the name in YAML: "greenery", "vehicles" or "people"

// Reads a map of bounds, such as {car: [0, 0.02], greenery: [0.2, 0.4]}. Throws InputError with the place in the file,
// also for classes that belong to no supply.
std::vector<ShareBound> readShares(const Value& value, const Ontology& ontology);

}  // namespace scanmill
