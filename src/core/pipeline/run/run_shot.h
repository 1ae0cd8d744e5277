#pragma once

// Runs one shot: traces its beams and makes its scan. Datasets, studies and measurements use it.

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

// Parameters for turning a sensor's shots into scans. The referenced objects must outlive the setup.
struct ShotSetup {
  const Method& method;
  Channels channels;                     // channels to trace
  Receiver receiver;                     // the receiver model, without `motions`, which senseShot() sets for each shot
  const Footprint* footprint = nullptr;  // the rays that sample a beam's width; null: each beam fires one ray
  const BlockedRays* vehicle = nullptr;  // the rays that hit the ego vehicle; null: no ego vehicle
  const LightPaths* paths = nullptr;     // how rays continue behind a hit; null: rays end at their first hit
  const Scene* moving = nullptr;         // the scene, if columns or classes of scans depend on motion; otherwise null
};

// Returns the setup of a sensor for a frame. `sensor`: index in Pipeline::sensors. `settings`: the frame's settings,
// which must outlive the setup.
ShotSetup setupOf(const Plan& plan, const FrameSettings& settings, const Scene& scene, const Method& method,
                  std::size_t sensor);

// Buffers that are reused from shot to shot.
struct ShotBuffers {
  Hits hits;
  Returns returns;
  Scan scan;
};

// Traces a shot into buffers.hits and makes buffers.scan from the hits. Adds the times of the stages "trace" and
// "effects" to the clock. Returns the method's account, which has the times of the method's own stages.
TraceAccount runShot(const ShotSetup& setup, const Shot& shot, ShotBuffers& buffers, StageClock& clock);
// Traces the hits of a shot, without making a scan.
TraceAccount traceShot(const ShotSetup& setup, const Shot& shot, Hits& hits);
// Makes the returns and the scan of a shot from existing hits.
void senseShot(const ShotSetup& setup, const Shot& shot, const Hits& hits, Returns& returns, Scan& scan);

}  // namespace scanmill
