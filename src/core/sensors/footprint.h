#pragma once

// Samples a beam of finite width with several rays.

#include <cstdint>
#include <memory>
#include <vector>

#include "scan/hits.h"
#include "sensors/beams.h"

namespace scanmill {

// The numbers of rays that can sample a beam: one along its axis, or a hexagon of them about it.
constexpr std::uint32_t kFootprintRays[] = {1, 7, 19, 37, 61, 91, 127};

// The speed of light (m/s).
constexpr double kLightSpeed = 299792458.0;

// Returns the distance c t / 2 (m) from which the echoes of two surfaces no longer overlap by half, for a pulse of
// width t (s).
constexpr double pulseLength(double width) {
  return kLightSpeed * width / 2;
}

// Returns the area that a beam lights at a range (m^2). A uniform beam counts in full. A Gaussian beam counts with half
// of the area within 1/e^2, which is the area of a uniform beam as bright as its middle. 0 if the sensor file gives no
// width.
double beamArea(const BeamTable& beams, double range);

struct Footprint {
  // The rays as a table that methods trace like any other. Each column of the sensor's table becomes
  // BeamTable::raysPerBeam neighbouring columns; the rings stay the same.
  std::shared_ptr<const BeamTable> rays;
  std::vector<float> weight;  // by ray of a beam: its share of the beam's power; their sum is 1
};

// Returns rays through the points of a hexagonal grid across each beam, its axis first, weighted with the beam's power
// there. Each beam's grid is turned about the axis by a random angle, which is the same in all frames. The grid is
// scaled to the beam's second moment, so that the echo of a slanted plane has the right width for any number of rays.
// Throws Error if `raysPerBeam` is none of kFootprintRays.
Footprint makeFootprint(const BeamTable& beams, std::uint32_t raysPerBeam);

// Turns hits of the footprint's rays into hits of the sensor's beams: sets Hits::columns, beamOfRay and weightOfRay.
void joinRays(const Footprint& footprint, Hits& hits);

}  // namespace scanmill
