#include "sensors/destagger.h"

#include <algorithm>
#include <cmath>

namespace scanmill {

Destagger destagger(std::span<const double> offset, double step, std::uint32_t columns, bool fullTurn) {
  // Added before rounding (columns), so that offsets halfway between two columns are rounded in the same direction in
  // all rings, despite floating-point errors.
  constexpr double kTie = 1e-6;
  std::vector<std::int64_t> shifts;
  shifts.reserve(offset.size());
  for (const double angle : offset) {
    shifts.push_back(step == 0 ? 0 : static_cast<std::int64_t>(std::floor(angle / step + 0.5 + kTie)));
  }
  Destagger image{{}, columns};
  if (shifts.empty()) return image;
  std::int64_t zero = 0;
  if (!fullTurn) {
    const auto [least, most] = std::ranges::minmax(shifts);
    zero = least;
    image.width += static_cast<std::uint32_t>(most - least);
  }
  const auto width = std::int64_t{image.width};
  for (const std::int64_t shift : shifts) {
    image.shift.push_back(static_cast<std::uint32_t>(((shift - zero) % width + width) % width));
  }
  return image;
}

Destagger destagger(const BeamTable& beams) {
  const std::uint32_t columns = beams.columns / beams.raysPerBeam;
  if (beams.listed != nullptr || beams.rosette || columns < 2)
    return {std::vector<std::uint32_t>(beams.rings), columns};
  const std::uint32_t steps = beams.fullTurn() ? columns : columns - 1;
  const double step = (beams.clockwise ? -beams.field : beams.field) / steps;
  return destagger(beams.azimuthOffset, step, columns, beams.fullTurn());
}

}  // namespace scanmill
