#include <fmt/core.h>

#include "base/parallel.h"
#include "sense/returns.h"
#include "viewer/frames/stored_frames.h"

namespace scanmill {

namespace {

constexpr float kUnknown = std::numeric_limits<float>::quiet_NaN();
constexpr std::size_t kGrain = 16384;  // points that a thread handles at a time

bool isFalsePositive(const Scan& scan, std::size_t point) {
  return !scan[kCause].empty() && scan[kCause][point] == static_cast<std::uint8_t>(Reason::FalsePositive);
}

bool numbersReturns(const Scan& scan) {
  return scan.organised || !scan[kReturn].empty();
}

struct BeamPoint {
  std::uint64_t beam = 0;  // ring and column
  std::uint32_t point = 0;
  auto operator<=>(const BeamPoint&) const = default;
};

std::uint64_t beamOf(const PointKey& key) {
  return std::uint64_t{key.ring} << 32 | key.column;
}

// Returns the points with a finite position, sorted by beam. Points of the same beam are in the order of the scan.
std::vector<BeamPoint> sortedByBeam(const Scan& scan) {
  std::vector<BeamPoint> points;
  points.reserve(scan.size());
  for (std::size_t i = 0; i < scan.size(); ++i) {
    if (isFinite(scan.position[i])) points.push_back({beamOf(keyOf(scan, i)), static_cast<std::uint32_t>(i)});
  }
  std::ranges::sort(points);
  return points;
}

// Returns the points of the key's beam, at most the first 16: damaged scans may have thousands. `sorted`: by beam.
std::span<const BeamPoint> pointsOf(const std::vector<BeamPoint>& sorted, const PointKey& key) {
  constexpr std::size_t kMostReturns = 16;
  const auto points = std::ranges::equal_range(sorted, beamOf(key), {}, &BeamPoint::beam);
  return {points.begin(), std::min(points.size(), kMostReturns)};
}

// Returns why the points of the scans cannot be compared, as a text for the user; empty if they can.
std::string whyNotComparable(const Scan& scan, const Scan& reference) {
  for (const auto& [checked, name] :
       {std::pair{&scan, "the scan"}, std::pair{&reference, "the noise-free reference"}}) {
    if (knowsBeams(*checked)) continue;
    return fmt::format(
        "{} does not say which beam its points belong to: name ring and column in output.columns of its "
        "pipeline",
        name);
  }
  if (scan.rings != 0 && reference.rings != 0 && (scan.rings != reference.rings || scan.columns != reference.columns)) {
    return fmt::format("the noise-free reference's sensor has {} x {} beams, not {} x {}", reference.rings,
                       reference.columns, scan.rings, scan.columns);
  }
  return {};
}

}  // namespace

std::vector<float> referenceErrors(const Scan& scan, const Scan& reference, std::string& why) {
  why = whyNotComparable(scan, reference);
  if (!why.empty()) return {};
  const bool areNumbered = numbersReturns(scan) && numbersReturns(reference);
  const std::vector<BeamPoint> referencePoints = sortedByBeam(reference);
  const std::vector<BeamPoint> scanPoints = areNumbered ? sortedByBeam(scan) : std::vector<BeamPoint>();
  // True if return numbers identify surfaces: the beam has equally many returns in the scan and the reference, and no
  // false positive.
  const auto numbersMatch = [&](const PointKey& key, std::size_t referenceReturns) {
    const std::span<const BeamPoint> returns = pointsOf(scanPoints, key);
    return returns.size() == referenceReturns &&
           std::ranges::none_of(returns, [&](const BeamPoint& p) { return isFalsePositive(scan, p.point); });
  };
  std::vector<float> errors(scan.size(), kUnknown);
  parallelForEach(scan.size(), kGrain, [&](std::size_t i) {
    if (!isFinite(scan.position[i]) || isFalsePositive(scan, i)) return;
    const PointKey key = keyOf(scan, i);
    const std::span<const BeamPoint> candidates = pointsOf(referencePoints, key);
    const bool byNumber = areNumbered && candidates.size() > 1 && numbersMatch(key, candidates.size());
    double least = std::numeric_limits<double>::infinity();
    for (const BeamPoint& candidate : candidates) {
      if (byNumber && keyOf(reference, candidate.point).number != key.number) continue;
      least = std::min(least, length(Vec3d(scan.position[i]) - Vec3d(reference.position[candidate.point])));
    }
    if (std::isfinite(least)) errors[i] = static_cast<float>(least);
  });
  return errors;
}

std::vector<float> rangeErrors(const Scan& scan, const BeamTable* beams) {
  if (scan[kRangeTrue].empty()) return {};
  std::vector<float> errors(scan.size(), kUnknown);
  const bool offAxis = beams != nullptr && !beams->origin.empty() && knowsBeams(scan);
  parallelForEach(scan.size(), kGrain, [&](std::size_t i) {
    if (!isFinite(scan.position[i]) || !std::isfinite(scan[kRangeTrue][i])) return;
    Vec3d origin;
    if (offAxis) {
      const PointKey beam = keyOf(scan, i);
      if (beam.ring >= beams->rings || beam.column >= beams->columns) return;
      origin = Vec3d(beams->origin[beam.ring * beams->columns + beam.column]);
    }
    errors[i] = static_cast<float>(std::abs(length(Vec3d(scan.position[i]) - origin) - double{scan[kRangeTrue][i]}));
  });
  return errors;
}

}  // namespace scanmill
