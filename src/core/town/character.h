#pragma once

// The character of a town: the keys of a scene file, and the properties that the seed draws within them.

#include <cstdint>
#include <filesystem>
#include <string>

#include "config/fields.h"
#include "models/models.h"
#include "town/roads.h"

namespace scanmill::town {

using models::Draw;

enum class District { Rural, Suburban, Dense };
enum class Season { Summer, Autumn, Winter };

// The keys of `town:` in a scene file.
struct Parameters {
  std::string district = "any";   // or rural, suburban, dense
  std::string season = "summer";  // or any, autumn, winter
  std::filesystem::path map;      // an OpenStreetMap extract; empty: roads and buildings are random
  std::string road;               // name of the main road on the map; empty: random
  bool keepsLeft = false;         // left-hand traffic: the town is laid out and then mirrored
  double length = 300;            // m, of the main road between its first and last plot
  double slope = 1;               // this and those below: factors on what the seed draws
  double greenery = 1;
  double vehicles = 1;
  double traffic = 1;  // on driving vehicles, on top of `vehicles`
  double people = 1;
  double detail = 1;  // factor on the number of leaves
};

Parameters readParameters(Fields& fields);

// The properties of a town, drawn from the seed so that no two towns are alike.
struct Character {
  Character(const Parameters& parameters, std::uint64_t seed);

  std::string inWords() const;  // "dense, winter"

  District district = District::Suburban;
  Season season = Season::Summer;
  double foliage = 1;    // share of their leaves that trees have kept
  double snow = 0;       // m, depth where nobody clears it
  double snowBanks = 0;  // m, height of the banks that ploughs leave beside roads
  double wear = 0;       // wear of the roads' surface, 0 to 1: potholes and repairs
  CrossSection main, side;
  int sideRoads = 3;
  double bend = 0.4;                      // rad, how far the main road's heading varies
  double hills = 3;                       // m, amplitude of hills, which vary over about 260 m
  double banks = 3;                       // m, amplitude of banks away from roads, which vary over 45 m
  double undulation = 0.2;                // m, amplitude of the unevenness of lawns
  double setback = 4, setbackSpread = 2;  // m, from the plots' edge to the houses
  double built = 0.8;                     // share of the plots with a house
  double plotWidth = 18;                  // m, mean
  int floorsLow = 1, floorsHigh = 2;
  double hedges = 0.4, fences = 0.3;  // shares of the plots with a hedge or a fence towards the road
  double avenue = 0.4;                // share of the places along the road that have a tree
  double gardenTrees = 1;             // per plot
  double gardenBushes = 3;            // per plot
  double woods = 0.3;                 // share of the free land that is wooded
  double parked = 0.3;                // share of the parking bays or curbside places that are taken
  double traffic = 1;                 // vehicles on the lanes, per 100 m
  double people = 4;                  // per 100 m of road
  double clutter = 6;                 // benches, bins, boxes, bollards, ... per 100 m of road
};

}  // namespace scanmill::town
