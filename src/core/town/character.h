#pragma once

// What kind of place a town is: its keys, and what the seed draws within them.

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
  std::filesystem::path map;      // an OpenStreetMap extract; empty: all is drawn
  std::string road;               // of the map, that the main road is; empty: drawn
  bool keepsLeft = false;         // traffic: then the town is laid out as its own mirror image
  double length = 300;            // m, of the main road between its first and last plot
  double slope = 1;               // factors of what the seed draws
  double greenery = 1;
  double vehicles = 1;
  double traffic = 1;  // those of the vehicles that drive, over and above
  double people = 1;
  double detail = 1;  // factor on the number of leaves
};

Parameters readParameters(Fields& fields);

// What kind of place it is: drawn once for each seed, so that no two are alike.
struct Character {
  Character(const Parameters& parameters, std::uint64_t seed);

  std::string inWords() const;  // "dense, winter"

  District district = District::Suburban;
  Season season = Season::Summer;
  double foliage = 1;    // part of their leaves that trees have kept
  double snow = 0;       // m, where nobody clears it
  double snowBanks = 0;  // m, beside the roads, where ploughs leave them
  double wear = 0;       // of the roads' surface, 0 to 1: potholes and repairs
  CrossSection main, side;
  int sideRoads = 3;
  double bend = 0.4;                      // rad, by how much the main road's heading wanders
  double hills = 3;                       // m, amplitude of what varies over 200 m
  double banks = 3;                       // m, amplitude of what varies over 45 m, away from the roads
  double undulation = 0.2;                // m, of lawns
  double setback = 4, setbackSpread = 2;  // m, from the plots' edge to the houses
  double built = 0.8;                     // share of the plots with a house
  double plotWidth = 18;                  // m, mean
  int floorsLow = 1, floorsHigh = 2;
  double hedges = 0.4, fences = 0.3;  // shares of the plots with one towards the road
  double avenue = 0.4;                // share of the places along the verge or the gardens' front with a tree
  double gardenTrees = 1;             // per plot
  double gardenBushes = 3;            // per plot
  double woods = 0.3;                 // share of the free land that is wooded
  double parked = 0.3;                // share of the parking bays, or of the places along the curb, that is taken
  double traffic = 1;                 // vehicles on the lanes, per 100 m
  double people = 4;                  // per 100 m of road
  double clutter = 6;                 // benches, bins, boxes, bollards, ... per 100 m of road
};

}  // namespace scanmill::town
