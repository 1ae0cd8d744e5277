#pragma once

// Detection: combines the rays of a beam into echoes. This header is installed because sense/returns.h includes it.
//
//   const std::vector<Echo> echoes = findEchoes(hits, {}, 0.9);  // a pulse of 6 ns is 0.9 m long

#include <cstdint>
#include <span>
#include <vector>

#include "scan/hits.h"
#include "scan/reasons.h"

namespace scanmill {

// Returns the reason of a return by a ray of this path.
Reason causeOf(RayPath path);

// Rays of one beam whose ranges are too similar for the receiver to separate them.
struct Echo {
  std::uint32_t beam = 0;
  std::uint32_t hit = 0;     // index in Hits of the strongest ray of the class with the most power
  float range = 0;           // m, mean range in the interval of one pulse length with the most power
  float power = 0;           // sum of the powers of the echo's rays
  float spread = 0;          // m, standard deviation of the rays' ranges, weighted by power
  float share = 1;           // fraction of the power that comes from surfaces of the class of `hit`
  std::uint16_t label2 = 0;  // class with the second largest part of the power; 0: none
  Reason cause = Reason::Surface;
};

// Largest number of rows of a beam in the table of returns. Each beam has random numbers for this many rows. If a beam
// has more echoes, the strongest are kept.
constexpr std::uint32_t kMostReturns = 16;

// Returns the echoes of all beams, ordered by beam and then by range. Rays without a hit give none. Neighbouring rays
// of a beam, sorted by range, belong to the same echo if their ranges differ by at most `pulseLength` (m); with 0 each
// ray is an echo. The range of an echo is the mean of its rays' ranges, weighted by power. If an echo is longer than
// the pulse, the mean is only over the interval of one pulse length that contains most power, because a receiver finds
// the peak. `power`: power of each ray, in any unit; if it is empty, the rays' weights are used. Classes are read only
// if the hits have the channel Semantic.
std::vector<Echo> findEchoes(const Hits& hits, std::span<const float> power, double pulseLength);

}  // namespace scanmill
