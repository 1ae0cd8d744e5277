#pragma once

// A beam of finite width, as rays that sample it.

#include <cstdint>
#include <memory>
#include <vector>

#include "scan/hits.h"
#include "sensors/beams.h"

namespace scanmill {

// How many rays may sample a beam: one along its axis, or a hexagon of them about it.
constexpr std::uint32_t kFootprintRays[] = {1, 7, 19, 37, 61, 91, 127};

// The speed of light (m/s).
constexpr double kLightSpeed = 299792458.0;

// The distance between two surfaces whose echoes of a pulse of this width (s) no longer overlap by half: c t / 2 (m).
constexpr double pulseLength(double width) {
  return kLightSpeed * width / 2;
}

// The area that a beam lights at a range (m^2): of a uniform one all of it, of a Gaussian one that of a uniform beam as
// bright as its middle, which is half of the area within 1/e^2. 0 where the sensor's file does not say how wide it is.
double beamArea(const BeamTable& beams, double range);

struct Footprint {
  // A row of the sensor's table has the same ring here, each of its columns as many neighbouring ones as a beam has
  // rays: BeamTable::raysPerBeam. Methods trace it as any other table.
  std::shared_ptr<const BeamTable> rays;
  std::vector<float> weight;  // of a beam's rays, the power that each stands for; their sum is 1
};

// Rays at the points of a hexagonal grid across the beam, its axis first, with the power that the beam has there. The
// grid is turned about the axis by an angle of its own for every beam, drawn from a counter, the same in all frames;
// and it is scaled so that it has the beam's own second moment, by which an echo from a slanted plane is as wide as a
// real one, whatever the number of rays. Throws Error where `raysPerBeam` is none of kFootprintRays.
Footprint makeFootprint(const BeamTable& beams, std::uint32_t raysPerBeam);

// Turns the hits of the footprint's table, one a ray, into hits of the sensor's: Hits::columns, beamOfRay and
// weightOfRay.
void joinRays(const Footprint& footprint, Hits& hits);

}  // namespace scanmill
