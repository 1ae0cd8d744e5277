#pragma once

// How much of what a sensor sees shall be of a class: the key `shares` of a town.

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "config/value.h"
#include "scene/ontology.h"

namespace scanmill {

// What a town can have more or less of without being another place: its roads, plots and houses stay.
enum class Supply : std::uint8_t { Greenery, Vehicles, People };
constexpr std::size_t kSupplies = 3;

// Factors on what the seed has drawn, indexed by Supply.
using SupplyFactors = std::array<double, kSupplies>;

// Bounds on the share of some classes in what the beams of a sensor above the lane meet.
struct ShareBound {
  std::string name;                    // of a class, or of the supply whose classes all count
  std::vector<std::uint16_t> classes;  // ids
  Supply supply = Supply::Vehicles;    // that it depends on
  double least = 0, most = 1;
  double found = 0;  // once it was measured

  bool met() const { return found >= least && found <= most; }
};

std::string_view nameOf(Supply supply);  // as in YAML: greenery, vehicles, people

// Reads {car: [0, 0.02], greenery: [0.2, 0.4]}. Throws InputError with the place, for classes too that no supply has.
std::vector<ShareBound> readShares(const Value& value, const Ontology& ontology);

}  // namespace scanmill
