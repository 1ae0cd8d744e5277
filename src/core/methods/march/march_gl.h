#pragma once

// What a GlMarcher asks of its device at a time, for tests to make it smaller.

#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>

#include "methods/march/march.h"

namespace scanmill {

struct GlMarcherLimits {
  std::size_t particles = std::size_t{1} << 20;  // that march at once
  // Of a table; the device's own limit holds too.
  std::uint64_t tableBytes = std::numeric_limits<std::uint64_t>::max();
};

std::unique_ptr<GlMarcher> makeGlMarcher(const GlMarcherLimits& limits);

}  // namespace scanmill
