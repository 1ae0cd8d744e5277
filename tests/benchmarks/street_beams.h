#pragma once

// The paper's sensor with any number of rings.

#include <algorithm>
#include <cstdint>
#include <memory>

#include "sensors/beams.h"
#include "tests/support/street.h"

namespace scanmill {

// Rings spread evenly over the elevations of the preset paper_64, 2048 columns.
inline std::shared_ptr<const BeamTable> streetBeams(std::int64_t rings) {
  const auto preset = presetBeams("paper_64");
  auto beams = std::make_shared<BeamTable>(*preset);
  if (beams->rings == rings) return beams;
  const double top = *std::max_element(preset->elevation.begin(), preset->elevation.end());
  const double bottom = *std::min_element(preset->elevation.begin(), preset->elevation.end());
  beams->rings = static_cast<std::uint32_t>(rings);
  beams->elevation.clear();
  for (std::int64_t r = 0; r < rings; ++r) {
    beams->elevation.push_back(top + (bottom - top) * static_cast<double>(r) / static_cast<double>(rings - 1));
  }
  beams->azimuthOffset.assign(beams->rings, 0.0);
  beams->firingOffset.assign(beams->rings, 0.0);
  fillBeams(*beams);
  return beams;
}

}  // namespace scanmill
