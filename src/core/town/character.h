#pragma once

// The character of a town: its keys in a scene file, and the properties that the seed selects within limits.

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

#include "config/fields.h"
#include "models/models.h"
#include "town/roads.h"

namespace scanmill::town {

using models::Draw;

enum class Season { Summer, Autumn, Winter };

// The keys of `town:` in a scene file. The numbers from `slope` to `detail` are factors.
struct Parameters {
  std::string district = "any";   // "rural", "suburban", "dense", ...; "any": follows from the seed
  std::string season = "summer";  // "summer", "autumn" or "winter"; "any": random
  std::filesystem::path map;      // an OpenStreetMap extract; empty: roads and buildings are random
  std::string road;               // name of the main road on the map; empty: random
  bool keepsLeft = false;         // true: left-hand traffic, for which a right-hand town is mirrored
  double length = 300;            // m, length of the main road from its first to its last plot
  double slope = 1;               // factor on the heights of hills and banks
  double greenery = 1;
  double vehicles = 1;
  double traffic = 1;  // factor on the number of driving vehicles, besides the factor `vehicles`
  double people = 1;
  double detail = 1;  // factor on the number of leaves
};

Parameters readParameters(Fields& fields);

// The traits of a district, which the key `district` or the seed selects. character.cpp lists all districts.
struct DistrictTraits {
  std::string_view name;    // value of the key
  bool country = false;     // outside of towns, with few lamps, without crossings and shelters
  bool farmland = false;    // with herds and many wires
  bool motorway = false;    // without people, standing vehicles and roadworks, with guard rails
  bool terraced = false;    // houses stand wall to wall at the pavement, with shops; the ground around them is paved
  bool cobbled = false;     // roads are paved with stones
  bool commercial = false;  // halls with flat roofs, large parking lots, fences of wire
  // true: every tracing method can trace the town: straight road, flat ground, mown grass, no wires, nothing moves.
  bool plain = false;
};

// The properties of a town. Properties that the parameters do not set depend on the seed.
struct Character : DistrictTraits {
  Character(const Parameters& parameters, std::uint64_t seed);

  std::string inWords() const;  // describes the town: "dense, winter"

  Season season = Season::Summer;
  double foliage = 1;    // fraction of the leaves that are still on the trees
  double snow = 0;       // m, depth of snow on ground that is not cleared
  double snowBanks = 0;  // m, height of the snow banks that ploughs leave beside roads
  double wear = 0;       // wear of the roads, 0 to 1: more wear, more potholes and repairs
  CrossSection main, side;
  int sideRoads = 3;
  double bend = 0.4;                      // rad, amplitude of the variation of the main road's heading
  double hills = 3;                       // m, amplitude of hills about 260 m wide
  double banks = 3;                       // m, amplitude of banks about 45 m wide, away from roads
  double undulation = 0.2;                // m, amplitude of the unevenness of lawns
  double setback = 4, setbackSpread = 2;  // m from the plot's edge to the house: mean and spread
  double built = 0.8;                     // fraction of the plots that have a house
  double plotWidth = 18;                  // m, mean width of a plot
  int floorsLow = 1, floorsHigh = 2;
  double hedges = 0.4, fences = 0.3;  // fractions of the plots with a hedge and with a fence or wall at the road
  double avenue = 0.4;                // fraction of the places for trees along the road that have a tree
  double gardenTrees = 1;             // trees per garden
  double gardenBushes = 3;            // bushes per garden
  double woods = 0.3;                 // fraction of the free land that is wooded
  double forecourts = 0;              // fraction of the houses with paved ground between house and sidewalk
  double parked = 0.3;                // fraction of the parking bays and curbside places that are occupied
  double traffic = 1;                 // vehicles per 100 m of each lane
  double speed = 12;                  // m/s, speed limit of the main road
  double people = 4;                  // people per 100 m of road
  double clutter = 6;                 // benches, bins, boxes, bollards, ... per 100 m of road
  double lights = 0.3;                // fraction of the junctions that have traffic lights

 private:
  void drawSeason(const Parameters& p, std::uint64_t seed);
};

}  // namespace scanmill::town
