#pragma once

// Finds out for every beam what its return comes from, or why it has none.

#include <cstdint>
#include <span>
#include <vector>

#include "scan/hits.h"
#include "scan/reasons.h"
#include "scene/material.h"
#include "sense/returns.h"

namespace scanmill {

// One value of Reason a beam, once all effects have run on a table that tells reasons (Returns::tellReasons()). Of a
// beam without a return that of its strongest echo. Mirrors, metals and glass are told from other surfaces that are too
// faint where the hits have the channel Material.
std::vector<std::uint8_t> reasonsOf(const Hits& hits, std::span<const Material> materials, const Returns& returns);

}  // namespace scanmill
