#pragma once

// Detection: the rays of a beam add up to echoes.

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "scan/hits.h"

namespace scanmill {

// What a return comes from.
enum class Cause : std::uint8_t {
  None = 0,           // there is no return
  Surface = 1,        // a surface of the scene
  FalsePositive = 2,  // nothing: the receiver's own error
  ThroughGlass = 3,   // a surface behind glass
  Mirrored = 4,       // the mirror image of a surface
  OwnVehicle = 5,     // the vehicle that carries the sensor
  Weather = 6,        // rain, snow, fog or dust in the air
  StrayLight = 7,     // light that bloomed over from a bright target beside the beam, or of another sensor
};

Cause causeOf(RayPath path);

// What a beam's receiver can tell apart.
struct Echo {
  std::uint32_t beam = 0;
  std::uint32_t hit = 0;     // the strongest ray of the class that gives most of the power
  float range = 0;           // m
  float power = 0;           // of all rays together
  float spread = 0;          // m, standard deviation of the rays' ranges, weighted by power
  float share = 1;           // of the power, that comes from surfaces of the hit's class
  std::uint16_t label2 = 0;  // the class that gives most of the rest; 0 where there is none
  Cause cause = Cause::Surface;
};

// A beam has as many echoes as addresses of random numbers; of more the strongest are kept.
constexpr std::uint32_t kMostReturns = 16;

// The echoes of all beams, by beam and then by range. Rays that meet nothing give none. Neighbours in range that are at
// most `pulseLength` (m) apart belong to one echo; with 0 each ray is an echo of its own. The range of an echo is the
// mean of its rays', weighted by power: of an echo longer than the pulse, of those rays alone that lie in the stretch
// of a pulse's length that holds most power, as a receiver finds the peak. `power`: of each ray, in any unit; where it
// is empty the rays' weights stand for it. Classes are looked at where the hits have the channel Semantic.
std::vector<Echo> findEchoes(const Hits& hits, std::span<const float> power, double pulseLength);

}  // namespace scanmill
