#pragma once

// Samples a beam of finite width with several rays. This header is installed because pipeline/plan/plan.h includes it.
//
//   const Footprint footprint = makeFootprint(*beams, 7);  // seven rays for each beam

#include <cstdint>
#include <memory>
#include <vector>

#include "scan/hits.h"
#include "sensors/beams.h"

namespace scanmill {

// Numbers of rays that can sample a beam: one along the beam's axis, or a hexagonal grid about the axis.
constexpr std::uint32_t kFootprintRays[] = {1, 7, 19, 37, 61, 91, 127};

// The speed of light (m/s).
constexpr double kLightSpeed = 299792458.0;

// Returns the distance (m) along a beam between two surfaces whose echoes are `width` (s) apart: c * width / 2.
constexpr double pulseLength(double width) {
  return kLightSpeed * width / 2;
}

// Returns the effective area that a beam illuminates at a range (m^2): the beam's power divided by the power density on
// its axis. This is the full cross-section of a uniform beam. For a Gaussian beam it is half of the area in which the
// power density exceeds 1/e^2 of the density on the axis. Returns 0 if the sensor file gives no beam width.
double beamArea(const BeamTable& beams, double range);

struct Footprint {
  // A table whose beams are the rays, for methods to trace. Each column of the sensor's table becomes
  // BeamTable::raysPerBeam neighbouring columns; the rings stay the same.
  std::shared_ptr<const BeamTable> rays;
  std::vector<float> weight;  // by ray of a beam: fraction of the beam's power; the sum is 1
};

// Returns rays through the points of a hexagonal grid across each beam; the first ray is the beam's axis. The weight of
// a ray is the beam's power at the ray's point. Each beam's grid is rotated about the axis by a random angle, which is
// the same in all revolutions. The grid is scaled to the second moment of the beam, so that the echo of a slanted plane
// has the right width for any number of rays above 1. Throws Error if `raysPerBeam` is not in kFootprintRays.
Footprint makeFootprint(const BeamTable& beams, std::uint32_t raysPerBeam);

// Assigns the hits of the footprint's rays to the sensor's beams: sets Hits::columns, beamOfRay and weightOfRay.
void joinRays(const Footprint& footprint, Hits& hits);

}  // namespace scanmill
