#pragma once

// Measures what it costs to leave out parts of the sensor's physics (fewer rays a beam, no glass, no mirrors, clear
// air), compared with a truth that has them all.

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "evaluate/spread.h"
#include "pipeline/plan/plan.h"
#include "scene/scene.h"
#include "sensors/shot.h"

namespace scanmill {

// One setting compared with the truth, by the nearest returns of all beams.
struct SensingResult {
  std::string name;           // "7 rays a beam"
  std::string failure;        // why it could not be measured; then all other members are empty
  double traceSeconds = 0;    // s per scan, on all threads
  double effectsSeconds = 0;  // s per scan, on one thread
  std::uint64_t beams = 0;
  std::uint64_t both = 0;       // beams that return in both
  std::uint64_t missing = 0;    // beams that return only in the truth
  std::uint64_t added = 0;      // beams that return only in the setting
  std::uint64_t sameClass = 0;  // beams that return the same class in both
  Spread distance;              // m, between the two points of a beam that returns in both
  double intensity = 0;         // mean difference of the intensity of these beams
};

// Rays a beam, mirror bounces and panes of glass in the truth.
constexpr std::uint32_t kTrueRays = 127;
constexpr std::uint32_t kTrueBounces = 2;
constexpr std::uint32_t kTruePanes = 8;

// Measures by ray tracing; the truth comes first and is compared with itself. In the truth, beams have 127 rays if the
// pipeline has a footprint, rays pass 8 panes and 2 mirrors if the pipeline has light paths, and the weather is the
// pipeline's. Every other setting leaves out or reduces one of these; the last one is the pipeline's own. All settings
// omit the noise of ranges and angles and the own vehicle, and use the same random values. Returns an empty list if the
// pipeline has none of the three. `stop` is called between scans; true ends the study with an Error.
std::vector<SensingResult> measureSensing(const Plan& plan, const Scene& scene, std::span<const Shot> shots,
                                          const std::function<void(const std::string&)>& say,
                                          const std::function<bool()>& stop);

}  // namespace scanmill
