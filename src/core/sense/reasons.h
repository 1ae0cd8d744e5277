#pragma once

// Determines for every beam the origin of its return, or the reason why it has no return.

#include <cstdint>
#include <span>
#include <vector>

#include "scan/hits.h"
#include "scan/reasons.h"
#include "scene/material.h"
#include "sense/returns.h"

namespace scanmill {

// Returns one value of Reason per beam. All effects must have run, on a table that records reasons
// (Returns::tellReasons()). A beam without a return has the reason of its strongest echo. If the hits have the channel
// Material, echoes of mirrors, metals and glass that are too faint get reasons of their own instead of TooFaint.
std::vector<std::uint8_t> reasonsOf(const Hits& hits, std::span<const Material> materials, const Returns& returns);

}  // namespace scanmill
