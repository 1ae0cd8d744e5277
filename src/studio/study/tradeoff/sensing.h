#pragma once

// Measures how much time is saved and how much error is caused by simplifying the sensor's physics (fewer rays per
// beam, no glass, no mirrors, clear air). The reference, called the truth, has the complete physics.

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "evaluate/spread.h"
#include "pipeline/plan/plan.h"
#include "scene/scene.h"
#include "sensors/shot.h"

namespace scanmill {

// A variation compared with the truth, by the nearest return of each beam.
struct SensingResult {
  std::string name;           // what the variation simplifies, such as "7 rays a beam"
  std::string failure;        // why the variation could not be measured; then the members below are empty
  double traceSeconds = 0;    // time to trace a scan with all threads (s)
  double effectsSeconds = 0;  // time to apply the effects to a scan with one thread (s)
  std::uint64_t beams = 0;
  std::uint64_t both = 0;       // number of beams with a return in both scans
  std::uint64_t missing = 0;    // number of beams with a return only in the truth
  std::uint64_t added = 0;      // number of beams with a return only in the variation
  std::uint64_t sameClass = 0;  // number of beams in `both` whose returns have the same class
  Spread distance;              // distance between the two returns of each beam in `both` (m)
  double intensity = 0;         // mean absolute difference of the intensities of beams in `both`
};

// In the truth a beam has kTrueRays rays, each of which is reflected by at most kTrueBounces mirrors and passes at most
// kTruePanes glass panes.
constexpr std::uint32_t kTrueRays = 127;
constexpr std::uint32_t kTrueBounces = 2;
constexpr std::uint32_t kTruePanes = 8;

// Measures the variations by ray tracing. The first result is the truth, compared with itself: it has 127 rays per beam
// if the pipeline has the effect footprint, passes 8 panes and 2 mirrors if the pipeline has light_paths, and has the
// pipeline's weather. The other results simplify one or several of these; if the pipeline has footprint or light_paths,
// the last result has the pipeline's settings. All omit the ego vehicle and the noise of ranges and angles, and use the
// same random numbers. Returns nothing if the pipeline has none of these effects. `say`: called with a text about the
// progress. `stop`: called between scans; if it returns true, throws Error.
std::vector<SensingResult> measureSensing(const Plan& plan, const Scene& scene, std::span<const Shot> shots,
                                          const std::function<void(const std::string&)>& say,
                                          const std::function<bool()>& stop);

}  // namespace scanmill
