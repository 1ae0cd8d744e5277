#include <fmt/core.h>

#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <utility>

#include "base/parallel.h"
#include "sense/returns.h"
#include "viewer/frames/stored_frames.h"

namespace scanmill {

namespace {

constexpr float kUnknown = std::numeric_limits<float>::quiet_NaN();
constexpr std::size_t kGrain = 16384;
// Maximum number of beams in the table for the join, which takes 4 bytes per beam.
constexpr std::uint64_t kMostBeams = std::uint64_t{1} << 26;

// Maximum number of points per beam that are read; in damaged scans a beam may have thousands.
constexpr int kMostReturns = 16;
constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

bool isFalsePositive(const Scan& scan, std::size_t point) {
  return !scan[kCause].empty() && scan[kCause][point] == static_cast<std::uint8_t>(Reason::FalsePositive);
}

bool numbersReturns(const Scan& scan) {
  return scan.organised || !scan[kReturn].empty();
}

// For each beam, the points with a finite position in the order of the scan. Beams outside of `extent` have no points.
class PointsOfBeams {
 public:
  PointsOfBeams(const Scan& scan, const PointKey& extent)
      : extent_(extent), first_(std::size_t{extent.ring} * extent.column, kNone), next_(scan.size(), kNone) {
    for (std::size_t i = scan.size(); i-- > 0;) {
      if (!isFinite(scan.position[i])) continue;
      const PointKey key = keyOf(scan, i);
      if (key.ring >= extent.ring || key.column >= extent.column) continue;
      std::uint32_t& first = first_[std::size_t{key.ring} * extent.column + key.column];
      next_[i] = first;
      first = static_cast<std::uint32_t>(i);
      several_ = several_ || next_[i] != kNone;
    }
  }

  // True if at least one beam has several points.
  bool several() const { return several_; }
  // Returns the index of the beam's first point; kNone if it has none.
  std::uint32_t first(const PointKey& key) const {
    const bool within = key.ring < extent_.ring && key.column < extent_.column;
    return within ? first_[std::size_t{key.ring} * extent_.column + key.column] : kNone;
  }
  // Calls use(point) with the index of each point of a beam, up to kMostReturns.
  void each(const PointKey& key, const auto& use) const {
    std::uint32_t point = first(key);
    for (int count = 0; point != kNone && count < kMostReturns; ++count, point = next_[point]) use(point);
  }

 private:
  PointKey extent_;
  std::vector<std::uint32_t> first_;  // first point of each beam, or kNone
  std::vector<std::uint32_t> next_;   // for each point, the next point of the same beam, or kNone
  bool several_ = false;
};

// Finds the point in the reference that corresponds to a point of the scan.
class Join {
 public:
  Join(const Scan& scan, const Scan& reference, const PointKey& extent)
      : scan_(scan), reference_(reference), ofReference_(reference, extent) {
    // If no beam of the reference has several points, the numbers of returns are not needed.
    if (ofReference_.several() && numbersReturns(scan) && numbersReturns(reference)) {
      ofScan_.emplace(scan, extent);
    }
  }

  // Returns the index of the corresponding point in the reference; kNone if there is none.
  std::uint32_t partnerOf(std::size_t point) const {
    const PointKey key = keyOf(scan_, point);
    const std::uint32_t first = ofReference_.first(key);
    if (!ofReference_.several() || first == kNone) return first;
    const bool numbered = ofScan_ && sameReturns(key);
    std::uint32_t partner = kNone;
    double least = std::numeric_limits<double>::infinity();
    ofReference_.each(key, [&](std::uint32_t p) {
      if (numbered && keyOf(reference_, p).number != key.number) return;
      const double distance = length(Vec3d(reference_.position[p]) - Vec3d(scan_.position[point]));
      if (distance >= least) return;
      least = distance;
      partner = p;
    });
    return partner;
  }

 private:
  // True if the beam has as many returns in the scan as in the reference, and none of them is a false positive.
  bool sameReturns(const PointKey& key) const {
    int more = 0;
    bool surfaces = true;
    ofReference_.each(key, [&](std::uint32_t) { --more; });
    ofScan_->each(key, [&](std::uint32_t p) {
      ++more;
      surfaces = surfaces && !isFalsePositive(scan_, p);
    });
    return surfaces && more == 0;
  }

  const Scan& scan_;
  const Scan& reference_;
  PointsOfBeams ofReference_;
  std::optional<PointsOfBeams> ofScan_;
};

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
  const PointKey extent = extentOf(reference);
  if (std::uint64_t{extent.ring} * extent.column > kMostBeams) {
    why = fmt::format("the noise-free reference's rings and columns reach {} x {}: no sensor has so many beams",
                      extent.ring, extent.column);
    return {};
  }
  const Join join(scan, reference, extent);
  std::vector<float> errors(scan.size(), kUnknown);
  parallelFor(scan.size(), kGrain, [&](std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i) {
      if (!isFinite(scan.position[i]) || isFalsePositive(scan, i)) continue;
      const std::uint32_t partner = join.partnerOf(i);
      if (partner == kNone) continue;
      errors[i] = static_cast<float>(length(Vec3d(scan.position[i]) - Vec3d(reference.position[partner])));
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
