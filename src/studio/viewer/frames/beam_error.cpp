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
  const PointKey size = extentOf(reference);
  const std::uint64_t beams = std::uint64_t{size.ring} * size.column;
  if (beams * size.number > kMostBeams) {
    why =
        fmt::format("the noise-free reference's rings and columns reach {} x {}: no sensor has so many beams", size.ring, size.column);
    return {};
  }
  constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
  const auto placeOf = [&](const PointKey& key) {
    return (std::uint64_t{key.number} * size.ring + key.ring) * size.column + key.column;
  };
  std::vector<std::uint32_t> rowOf(beams * size.number, kNone);
  for (std::size_t i = reference.size(); i-- > 0;) {  // of two points with the same key the first stays
    rowOf[placeOf(keyOf(reference, i))] = static_cast<std::uint32_t>(i);
  }
  std::vector<float> errors(scan.size(), kUnknown);
  parallelFor(scan.size(), kGrain, [&](std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i) {
      const PointKey key = keyOf(scan, i);
      if (key.ring >= size.ring || key.column >= size.column || key.number >= size.number) continue;
      const std::uint32_t row = rowOf[placeOf(key)];
      if (row == kNone || !isFinite(scan.position[i]) || !isFinite(reference.position[row])) continue;
      errors[i] = static_cast<float>(length(Vec3d(scan.position[i]) - Vec3d(reference.position[row])));
    }
  });
  return errors;
}

std::vector<float> rangeErrors(const Scan& scan, const BeamTable* beams) {
  if (scan[kRangeTrue].empty()) return {};
  std::vector<float> errors(scan.size(), kUnknown);
  const bool offAxis = beams != nullptr && !beams->origin.empty() && knowsBeams(scan);
  parallelFor(scan.size(), kGrain, [&](std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i) {
      if (!isFinite(scan.position[i]) || !std::isfinite(scan[kRangeTrue][i])) continue;
      Vec3d origin;
      if (offAxis) {
        const PointKey beam = keyOf(scan, i);
        if (beam.ring >= beams->rings || beam.column >= beams->columns) continue;
        origin = Vec3d(beams->origin[beam.ring * beams->columns + beam.column]);
      }
      errors[i] = static_cast<float>(std::abs(length(Vec3d(scan.position[i]) - origin) - double{scan[kRangeTrue][i]}));
    }
  });
  return errors;
}

}  // namespace scanmill
