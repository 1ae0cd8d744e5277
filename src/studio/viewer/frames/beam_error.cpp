#include "viewer/frames/beam_error.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>

#include "base/parallel.h"

namespace scanmill {

namespace {

constexpr float kUnknown = std::numeric_limits<float>::quiet_NaN();
constexpr std::size_t kGrain = 16384;
constexpr std::uint64_t kMostBeams = std::uint64_t{1} << 26;  // of a table to join by; 4 bytes each

struct RingColumn {
  std::uint64_t ring = 0;
  std::uint64_t column = 0;
};

bool knowsBeams(const Scan& scan) {
  if (scan.organised) return scan.size() == std::size_t{scan.rings} * scan.columns;
  return scan.size() == 0 || (!scan.ring.empty() && !scan.column.empty());
}

// The order tells more than the columns, which are zero where a beam missed.
RingColumn beamOfPoint(const Scan& scan, std::size_t point) {
  if (scan.organised) return {point / scan.columns, point % scan.columns};
  return {scan.ring[point], scan.column[point]};
}

RingColumn extent(const Scan& scan) {
  if (scan.organised) return {scan.rings, scan.columns};
  RingColumn extent;
  for (const std::uint16_t ring : scan.ring) extent.ring = std::max<std::uint64_t>(extent.ring, ring + 1u);
  for (const std::uint16_t column : scan.column) extent.column = std::max<std::uint64_t>(extent.column, column + 1u);
  return extent;
}

}  // namespace

std::vector<float> referenceErrors(const Scan& scan, const Scan& reference, std::string& why) {
  for (const auto& [known, whose] :
       {std::pair{knowsBeams(scan), "the scan"}, std::pair{knowsBeams(reference), "the noise-free reference"}}) {
    if (known) continue;
    why = fmt::format(
        "{} does not say which beam its points belong to: name ring and column in output.columns of its "
        "pipeline",
        whose);
    return {};
  }
  if (scan.rings != 0 && reference.rings != 0 && (scan.rings != reference.rings || scan.columns != reference.columns)) {
    why = fmt::format("the noise-free reference's sensor has {} x {} beams, not {} x {}", reference.rings,
                      reference.columns, scan.rings, scan.columns);
    return {};
  }
  const RingColumn size = extent(reference);
  if (size.ring * size.column > kMostBeams) {
    why = fmt::format("the noise-free reference's rings and columns reach {} x {}: no sensor has so many beams",
                      size.ring, size.column);
    return {};
  }
  constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
  std::vector<std::uint32_t> rowOf(size.ring * size.column, kNone);
  for (std::size_t i = reference.size(); i-- > 0;) {  // of two points of a beam the first stays
    const RingColumn beam = beamOfPoint(reference, i);
    rowOf[beam.ring * size.column + beam.column] = static_cast<std::uint32_t>(i);
  }
  std::vector<float> errors(scan.size(), kUnknown);
  parallelFor(scan.size(), kGrain, [&](std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i) {
      const RingColumn beam = beamOfPoint(scan, i);
      if (beam.ring >= size.ring || beam.column >= size.column) continue;
      const std::uint32_t row = rowOf[beam.ring * size.column + beam.column];
      if (row == kNone || !isFinite(scan.position[i]) || !isFinite(reference.position[row])) continue;
      errors[i] = static_cast<float>(length(Vec3d(scan.position[i]) - Vec3d(reference.position[row])));
    }
  });
  return errors;
}

std::vector<float> rangeErrors(const Scan& scan, const BeamTable* beams) {
  if (scan.rangeTrue.empty()) return {};
  std::vector<float> errors(scan.size(), kUnknown);
  const bool offAxis = beams != nullptr && !beams->origin.empty() && knowsBeams(scan);
  parallelFor(scan.size(), kGrain, [&](std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i) {
      if (!isFinite(scan.position[i]) || !std::isfinite(scan.rangeTrue[i])) continue;
      Vec3d origin;
      if (offAxis) {
        const RingColumn beam = beamOfPoint(scan, i);
        if (beam.ring >= beams->rings || beam.column >= beams->columns) continue;
        origin = Vec3d(beams->origin[beam.ring * beams->columns + beam.column]);
      }
      errors[i] = static_cast<float>(std::abs(length(Vec3d(scan.position[i]) - origin) - double{scan.rangeTrue[i]}));
    }
  });
  return errors;
}

}  // namespace scanmill
