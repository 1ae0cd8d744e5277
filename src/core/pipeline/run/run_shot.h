#pragma once

// One shot, from its beams to its scan: what datasets, studies and measurements have in common.

#include <span>

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

// How the shots of a sensor become scans. What it refers to must outlive it.
struct ShotSetup {
  const Method& method;
  Channels channels;                     // that are traced
  Receiver receiver;                     // but for its motions, which follow from the scene
  const Footprint* footprint = nullptr;  // of beams that fire several rays
  const Hits* vehicle = nullptr;         // what the rays meet of the own vehicle
  const LightPaths* paths = nullptr;     // of rays that go on
  const Scene* moving = nullptr;         // the scene, if points tell how objects of it move
};

// Returns what the plan says of this sensor with its settings in a certain frame, which must outlive the setup; without
// settings: with those of ShotSource::settings().
ShotSetup setupOf(const ShotSource& source, const Scene& scene, const Method& method, std::size_t sensor);
ShotSetup setupOf(const Plan& plan, const FrameSettings& settings, const Scene& scene, const Method& method,
                  std::size_t sensor);

// Memory that goes from shot to shot.
struct ShotBuffers {
  Hits hits;
  Returns returns;
  Scan scan;
};

// Fills buffers.hits and then, from them, buffers.scan. The clock adds up the stages "trace" and "effects"; what
// tracing took by the method's own stages is in the account.
TraceAccount runShot(const ShotSetup& setup, const Shot& shot, ShotBuffers& buffers, StageClock& clock);
// The first half alone.
TraceAccount traceShot(const ShotSetup& setup, const Shot& shot, Hits& hits);
// The second half alone, of hits that are there already.
void senseShot(const ShotSetup& setup, const Shot& shot, const Hits& hits, Returns& returns, Scan& scan);

}  // namespace scanmill
