#pragma once

// Detection: combines the rays of a beam into echoes.

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "scan/hits.h"

namespace scanmill {

// The origin of a return.
enum class Cause : std::uint8_t {
  None = 0,           // there is no return
  Surface = 1,        // a surface of the scene
  FalsePositive = 2,  // only noise of the receiver
  ThroughGlass = 3,   // a surface behind glass
  Mirrored = 4,       // the mirror image of a surface
  OwnVehicle = 5,     // the vehicle that carries the sensor
  Weather = 6,        // rain, snow, fog or dust in the air
  StrayLight = 7,     // light from a bright target beside the beam, or from another sensor
};

Cause causeOf(RayPath path);

// Rays of one beam that are too close in range for the receiver to separate them.
struct Echo {
  std::uint32_t beam = 0;
  std::uint32_t hit = 0;     // the strongest ray of the class that contributes most power
  float range = 0;           // m
  float power = 0;           // power of all rays together
  float spread = 0;          // m, standard deviation of the rays' ranges, weighted by power
  float share = 1;           // part of the power that comes from surfaces of the hit's class
  std::uint16_t label2 = 0;  // the class that contributes most of the remaining power; 0: none
  Cause cause = Cause::Surface;
};

// The most rows of a beam in the table of returns: there are this many addresses of random numbers per beam. If a beam
// has more echoes, the strongest are kept.
constexpr std::uint32_t kMostReturns = 16;

// Returns the echoes of all beams, ordered by beam, then by range. Rays that miss give none. A beam's rays, sorted by
// range, belong to one echo as long as neighbours are at most `pulseLength` (m) apart; with 0 each ray is an echo of
// its own. The range of an echo is the mean of its rays' ranges, weighted by power. If the echo is longer than the
// pulse, only the rays within the interval of one pulse length that holds most power count, as a receiver finds the
// peak. `power`: of each ray, in any unit; if it is empty, the rays' weights are used. Classes are read only if the
// hits have the channel Semantic.
std::vector<Echo> findEchoes(const Hits& hits, std::span<const float> power, double pulseLength);

}  // namespace scanmill
