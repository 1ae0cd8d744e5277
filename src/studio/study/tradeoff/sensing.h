#pragma once

// What leaving parts of the sensor's physics out costs: fewer rays a beam, no glass, no mirrors, clear air, against a
// truth that has all of it.

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "evaluate/spread.h"
#include "pipeline/plan/plan.h"
#include "scene/scene.h"
#include "sensors/shot.h"

namespace scanmill {

// One setting against the truth, of the nearest returns of all beams.
struct SensingResult {
  std::string name;           // "7 rays a beam"
  std::string failure;        // why it could not be measured; then the rest is empty
  double traceSeconds = 0;    // a scan, on all threads
  double effectsSeconds = 0;  // a scan, on one thread
  std::uint64_t beams = 0;
  std::uint64_t both = 0;       // that return in both
  std::uint64_t missing = 0;    // that return in truth alone
  std::uint64_t added = 0;      // that return in the setting alone
  std::uint64_t sameClass = 0;  // of those that return in both
  Spread distance;              // m, between the two points of a beam that returns in both
  double intensity = 0;         // mean difference of the intensity, likewise
};

// Rays a beam, bounces and panes of the truth.
constexpr std::uint32_t kTrueRays = 127;
constexpr std::uint32_t kTrueBounces = 2;
constexpr std::uint32_t kTruePanes = 8;

// Measures by ray tracing; the truth comes first and is compared with itself. Its beams have 127 rays where the
// pipeline asks for a footprint, its rays pass 8 panes and 2 mirrors where that asks for light paths, and the weather
// is the pipeline's. Every setting leaves one of these out, or takes less of it; the last one is the pipeline's own.
// Noise of ranges and angles is left out of all, as is the own vehicle; what is drawn at random is the same in all.
// Empty where the pipeline asks for none of the three. `stop` is asked between scans; true ends the study with an
// Error.
std::vector<SensingResult> measureSensing(const Plan& plan, const Scene& scene, std::span<const Shot> shots,
                                          const std::function<void(const std::string&)>& say,
                                          const std::function<bool()>& stop);

}  // namespace scanmill
