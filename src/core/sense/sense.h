#pragma once

// The receiver model, which turns hits into a scan in three stages: it detects, applies the effects and gathers.
//
//   const ScanLayout layout{.columns = ColumnSet::byDefault()};
//   Returns returns;
//   Scan points;
//   sense({.materials = scene.materials, .layout = layout}, hits, shot, returns, points);

#include <cstdint>
#include <span>
#include <vector>

#include "scan/channels.h"
#include "scan/hits.h"
#include "scan/reasons.h"
#include "scan/scan.h"
#include "scene/material.h"
#include "sense/effect.h"
#include "sense/returns.h"
#include "sense/thing_motions.h"
#include "sensors/shot.h"

namespace scanmill {

// Returns the channels of Hits that the effects and the columns need.
Channels channelsFor(EffectList effects, ColumnSet columns);

// Starts the table of returns. If beams fire one ray, each ray becomes a row. If they fire several, each echo becomes a
// row (sense/echoes.h), with the power that the effects compute; if the sensor file gives no pulse length, each ray is
// a separate echo.
void detect(const Hits& hits, const Shot& shot, EffectList effects, std::span<const Material> materials,
            Returns& returns);

// The settings with which hits become a scan. All objects that they refer to must outlive the receiver.
struct Receiver {
  EffectList effects = {};                   // the effects, in the order in which they run
  std::span<const Material> materials = {};  // indexed by Hits::material
  ScanLayout layout = {};                    // the columns that the scan gets
  const ThingMotions* motions = nullptr;     // null: nothing moves, or no column or class depends on motion
};

// Makes a scan from hits: detects returns, applies the effects and gathers the columns. `returns` is a buffer, which
// later calls can reuse to avoid allocations. Throws Error if the hits lack a channel or belong to another sensor.
void sense(const Receiver& receiver, const Hits& hits, const Shot& shot, Returns& returns, Scan& scan);

// Returns one value of Reason per beam. All effects must have run, on a table that records reasons
// (Returns::tellReasons()). A beam without a return has the reason of its strongest echo. If the hits have the channel
// Material, echoes of mirrors, metals and glass that are too faint get reasons of their own instead of TooFaint.
std::vector<std::uint8_t> reasonsOf(const Hits& hits, std::span<const Material> materials, const Returns& returns);

// Fills the scan's columns that the layout asks for; intensity and power only if an effect has set them or the table
// of returns has no rows. Dense scans are ordered by column, then ring, then return, which is the order of firing. The
// nearest return of a beam is its first. `motions`: motions of the scene's objects; null if nothing moves.
void gather(const Hits& hits, const Shot& shot, const Returns& returns, const ScanLayout& layout,
            const ThingMotions* motions, Scan& scan);

}  // namespace scanmill
