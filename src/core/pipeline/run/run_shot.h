#pragma once

// Runs one shot, from its beams to its scan. Datasets, studies and measurements all use it.

#include "base/stage_clock.h"
#include "methods/interface/light_paths.h"
#include "methods/method.h"
#include "pipeline/scenes/shot_source.h"
#include "scan/hits.h"
#include "scan/scan.h"
#include "scene/scene.h"
#include "sense/sense.h"
#include "sensors/footprint.h"
#include "sensors/shot.h"

namespace scanmill {

// All that turns the shots of a sensor into scans. The objects that it refers to must outlive it.
struct ShotSetup {
  const Method& method;
  Channels channels;                     // channels to trace
  Receiver receiver;                     // without its `motions`, which are set for each shot
  const Footprint* footprint = nullptr;  // the rays of beams that fire several; null: each fires one
  const Hits* vehicle = nullptr;         // hits of the rays on the own vehicle; null: no own vehicle
  const LightPaths* paths = nullptr;     // how rays continue behind a hit; null: they end there
  const Scene* moving = nullptr;         // the scene, if the scan says how its objects move; else null
};

// Returns the setup of a sensor for a frame. `settings`: those of the frame, which must outlive the setup; the overload
// without them uses ShotSource::settings().
ShotSetup setupOf(const ShotSource& source, const Scene& scene, const Method& method, std::size_t sensor);
ShotSetup setupOf(const Plan& plan, const FrameSettings& settings, const Scene& scene, const Method& method,
                  std::size_t sensor);

// Buffers that are reused from shot to shot.
struct ShotBuffers {
  Hits hits;
  Returns returns;
  Scan scan;
};

// Fills buffers.hits and then, from the hits, buffers.scan. Adds the times of the stages "trace" and "effects" to the
// clock, and returns the account of the method, which has the times of its own stages.
TraceAccount runShot(const ShotSetup& setup, const Shot& shot, ShotBuffers& buffers, StageClock& clock);
// Does the first half alone: traces the hits.
TraceAccount traceShot(const ShotSetup& setup, const Shot& shot, Hits& hits);
// Does the second half alone: makes the scan from existing hits.
void senseShot(const ShotSetup& setup, const Shot& shot, const Hits& hits, Returns& returns, Scan& scan);

}  // namespace scanmill
