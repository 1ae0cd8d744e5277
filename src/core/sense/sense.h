#pragma once

// From hits to a scan: detect, apply the effects, gather.

#include <span>

#include "scan/channels.h"
#include "scan/hits.h"
#include "scan/scan.h"
#include "scene/material.h"
#include "sense/effect.h"
#include "sense/returns.h"
#include "sense/thing_motions.h"
#include "sensors/shot.h"

namespace scanmill {

// Channels of Hits that the effects and the columns need.
Channels channelsFor(EffectList effects, ColumnSet columns);

// Starts the table of returns: of one ray a beam as the rays are, of several from their echoes (sense/echoes.h), whose
// power is as the effects see it. Rays of a sensor whose file does not say how long its pulses are do not add up.
void detect(const Hits& hits, const Shot& shot, EffectList effects, std::span<const Material> materials,
            Returns& returns);

// How hits become a scan. What it refers to must outlive it.
struct Receiver {
  EffectList effects = {};                   // in the order in which they run
  std::span<const Material> materials = {};  // that Hits::material points into
  ScanLayout layout = {};                    // which columns are kept
  const ThingMotions* motions = nullptr;     // of a scene that moves, if points tell how
};

// Detects, applies the effects and keeps the columns asked for. `returns` is reused between calls. Throws Error where
// the hits lack a channel or belong to another sensor.
void sense(const Receiver& receiver, const Hits& hits, const Shot& shot, Returns& returns, Scan& scan);

}  // namespace scanmill
