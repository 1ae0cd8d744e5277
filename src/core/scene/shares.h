#pragma once

// Bounds on the share that a class shall have of a sensor's hits: the key `shares` of a town.

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

// Factors on the numbers of objects that follow from the seed, indexed by Supply.
using SupplyFactors = std::array<double, kSupplies>;

// Bounds on the share of some classes in the hits of a sensor above the lane.
struct ShareBound {
  std::string name;                    // the name of a class, or of a supply: all its classes together
  std::vector<std::uint16_t> classes;  // ids
  Supply supply = Supply::Vehicles;    // the supply that the share depends on
  double least = 0, most = 1;
  double found = 0;  // the share that was measured; 0 before

  bool met() const { return found >= least && found <= most; }
};

std::string_view nameOf(Supply supply);  // as in YAML: greenery, vehicles, people

// Reads {car: [0, 0.02], greenery: [0.2, 0.4]}. Throws InputError with the place in the file, also for classes that
// belong to no supply.
std::vector<ShareBound> readShares(const Value& value, const Ontology& ontology);

}  // namespace scanmill
