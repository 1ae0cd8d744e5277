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

// Detects, applies the effects in their given order and keeps the columns asked for.
// `motions`: of a scene that moves. `returns` is reused between calls. Throws Error where the hits lack a channel or
// belong to another sensor.
void sense(const Hits& hits, const Shot& shot, EffectList effects, std::span<const Material> materials,
           const ScanLayout& layout, Returns& returns, Scan& scan, const ThingMotions* motions = nullptr);

}  // namespace scanmill
