#include "study/tradeoff/ring_timings.h"

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "study/linear_fit.h"

namespace scanmill {

std::shared_ptr<const BeamTable> withRings(const BeamTable& beams, std::uint32_t rings) {
  if (rings < 2) throw Error("a sensor with another number of rings needs at least two");
  auto made = std::make_shared<BeamTable>(beams);
  const auto [low, high] = std::minmax_element(beams.elevation.begin(), beams.elevation.end());
  const double first = beams.topDown ? *high : *low;
  const double last = beams.topDown ? *low : *high;
  made->rings = rings;
  made->elevation.clear();
  for (std::uint32_t r = 0; r < rings; ++r) made->elevation.push_back(first + (last - first) * r / (rings - 1));
  made->azimuthOffset.assign(rings, 0.0);
  made->firingOffset.assign(rings, 0.0);
  made->originLeft.clear();
  made->originUp.clear();
  fillBeams(*made);
  return made;
}

void fitRings(RingFit& fit) {
  std::vector<double> design, values;  // equations t = fixed + perRing * rings, each divided by the measured time t
  for (const RingTiming& t : fit.timings) {
    if (!(t.scanSeconds > 0)) throw Error("a time of 0 s per scan cannot be fitted");
    design.insert(design.end(), {1 / t.scanSeconds, t.rings / t.scanSeconds});
    values.push_back(1);
  }
  const LinearFit line = fitLinear(design, 2, values);
  if (line.rank < 2) throw Error("a fixed cost and a slope need at least two numbers of rings");
  fit.fixedSeconds = line.coefficients[0];
  fit.secondsPerRing = line.coefficients[1];
  fit.largestResidual = 0;
  for (const RingTiming& t : fit.timings) {
    const double modelled = fit.fixedSeconds + fit.secondsPerRing * t.rings;
    fit.largestResidual = std::max(fit.largestResidual, std::abs(modelled / t.scanSeconds - 1));
  }
}

}  // namespace scanmill
