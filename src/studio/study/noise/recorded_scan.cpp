#include <algorithm>
#include <cmath>
#include <limits>

#include "base/error.h"
#include "evaluate/spread.h"
#include "study/linear_fit.h"
#include "study/noise/flat_patches.h"

namespace scanmill {

namespace {

constexpr double kNoReturn = std::numeric_limits<double>::quiet_NaN();
constexpr std::size_t kFewestReturns = 100;  // least number of returns to find the sensor's pose in the scan's frame

struct BeamPoint {
  std::size_t beam;   // index in the beam table
  Vec3d position;     // in the scan's frame (m)
  std::size_t index;  // index in the scan
};

// Returns the sensor's ring for each ring of a scan. The scan may number rings in the opposite order, or skip rings
// without points. If scan and sensor have equally many rings, these are matched in the order of their elevations;
// otherwise each ring is matched to the sensor's ring of the nearest elevation.
std::vector<std::uint16_t> ringsByElevation(const Scan& scan, const BeamTable& beams) {
  std::vector<std::vector<double>> elevations;
  for (std::size_t i = 0; i < scan.size(); ++i) {
    const std::uint16_t ring = scan[kRing][i];
    if (ring >= elevations.size()) elevations.resize(ring + std::size_t{1});
    const Vec3d p(scan.position[i]);
    if (isFinite(p) && length(p) > 0) elevations[ring].push_back(std::asin(p.z / length(p)));
  }
  std::vector<std::pair<double, std::uint16_t>> scanRings, sensorRings;  // pairs of elevation (rad) and ring
  for (std::size_t r = 0; r < elevations.size(); ++r) {
    if (!elevations[r].empty()) scanRings.emplace_back(medianOf(elevations[r]), static_cast<std::uint16_t>(r));
  }
  for (std::uint32_t r = 0; r < beams.rings; ++r) {
    sensorRings.emplace_back(beams.elevation[r], static_cast<std::uint16_t>(r));
  }
  std::ranges::sort(scanRings);
  std::ranges::sort(sensorRings);
  std::vector<std::uint16_t> sensorRingOf(elevations.size(), 0);
  for (std::size_t i = 0; i < scanRings.size(); ++i) {
    const auto [elevation, ring] = scanRings[i];
    const auto distance = [elevation](const auto& sensorRing) { return std::fabs(sensorRing.first - elevation); };
    sensorRingOf[ring] = scanRings.size() == sensorRings.size()
                             ? sensorRings[i].second
                             : std::ranges::min_element(sensorRings, {}, distance)->second;
  }
  return sensorRingOf;
}

// Returns the scan with the sensor's ring numbers and a column number for each point, which follows from the point's
// azimuth about the z axis of the scan's frame. This frame may be rotated relative to the sensor's frame;
// alignedFrame() finds the rotation later. The scan must have the point attribute `ring`, but not `column`.
Scan withColumns(const Scan& scan, const BeamTable& beams) {
  Scan assigned = scan;
  const std::vector<std::uint16_t> sensorRingOf = ringsByElevation(scan, beams);
  const double step = beams.field / (beams.fullTurn() ? beams.columns : std::max(beams.columns, 2u) - 1);  // rad
  // For full turns, use the exact number of columns: the quotient 2 pi / step has a rounding error.
  const double columnsPerTurn = beams.fullTurn() ? beams.columns : 2 * kPi / step;
  for (std::size_t i = 0; i < scan.size(); ++i) {
    const std::uint16_t ring = sensorRingOf[scan[kRing][i]];
    assigned[kRing][i] = ring;
    const double offset = ring < beams.azimuthOffset.size() ? beams.azimuthOffset[ring] : 0;
    const Vec3f& p = scan.position[i];
    const double azimuth = std::atan2(static_cast<double>(p.y), static_cast<double>(p.x)) - offset;
    double column = std::round((azimuth - beams.firstAzimuth) / (beams.clockwise ? -step : step));
    column -= std::floor(column / columnsPerTurn) * columnsPerTurn;
    assigned[kColumn].push_back(static_cast<std::uint16_t>(std::min<double>(column, beams.columns - 1)));
  }
  return assigned;
}

// Returns the first return of each beam; omits positions that are not finite, and (0, 0, 0), which means no return.
// Throws InputError if beams of points are unknown (the scan is not organised and lacks `ring`) or not the sensor's.
std::vector<BeamPoint> firstReturns(const Scan& scan, const BeamTable& beams, const Location& where) {
  if (!knowsBeams(scan)) {
    throw InputError(where,
                     "is neither organised (width columns x height rings) nor has the column ring, so that the beams "
                     "of its points are unknown");
  }
  if (scan.organised && (scan.rings != beams.rings || scan.columns != beams.columns)) {
    throw InputError(where,
                     "has {} x {} beams, but the sensor {} has {} rings x {} columns: give the "
                     "sensor, in the mode, that made the recording",
                     scan.rings, scan.columns, beams.model, beams.rings, beams.columns);
  }
  std::vector<BeamPoint> points;
  // True for beams with an entry in `points`. If returns are not numbered, a beam's first point in the file counts.
  std::vector<bool> hasPoint(beams.size());
  for (std::size_t i = 0; i < scan.size(); ++i) {
    const PointKey key = keyOf(scan, i);
    if (key.ring >= beams.rings || key.column >= beams.columns) {
      throw InputError(where, "point {} has the ring {} and the column {}, but the sensor {} has {} x {} beams", i,
                       key.ring, key.column, beams.model, beams.rings, beams.columns);
    }
    if (!isFinite(scan.position[i]) || scan.position[i] == Vec3f{}) continue;  // some recordings store misses as zeros
    const std::size_t beam = std::size_t{key.ring} * beams.columns + key.column;
    if (key.number != 0 || hasPoint[beam]) continue;
    hasPoint[beam] = true;
    points.push_back({beam, static_cast<Vec3d>(scan.position[i]), i});
  }
  return points;
}

// Returns the rotation of the points about the z axis relative to their beams (rad): the circular mean of the points'
// rotations, weighted by the distances from the axis.
double startingYaw(const std::vector<BeamPoint>& points, const BeamTable& beams) {
  double sine = 0, cosine = 0;
  for (const BeamPoint& p : points) {
    const Vec3d& u = beams.direction[p.beam];
    sine += u.x * p.position.y - u.y * p.position.x;
    cosine += u.x * p.position.x + u.y * p.position.y;
  }
  return std::atan2(sine, cosine);
}

// Returns the median of the angles between the points' directions and the directions of their beams (rad).
double medianAngle(const std::vector<BeamPoint>& points, const BeamTable& beams, const Pose& scanFromSensor) {
  const Pose sensorFromScan = inverse(scanFromSensor);
  std::vector<double> angles;
  angles.reserve(points.size());
  for (const BeamPoint& p : points) {
    const Vec3d ray = sensorFromScan * p.position - beams.originOf(p.beam);
    const Vec3d& u = beams.direction[p.beam];
    angles.push_back(std::atan2(length(cross(ray, u)), dot(ray, u)));
  }
  return medianOf(std::move(angles));
}

// Returns a step of alignedFrame(): the pose, in the sensor's present frame, of the frame in which the angles between
// the points' directions and their beams are smallest, by least squares over every `stride`-th point.
Pose alignmentStep(const std::vector<BeamPoint>& points, const BeamTable& beams, const Pose& sensorFromScan,
                   std::size_t stride) {
  std::vector<double> design, values;
  for (std::size_t i = 0; i < points.size(); i += stride) {
    const Vec3d position = sensorFromScan * points[i].position;
    const Vec3d& direction = beams.direction[points[i].beam];
    const Vec3d ray = position - beams.originOf(points[i].beam);
    const double range = std::max(length(ray), 1e-3);
    // The angle has two components, along axes across the beam.
    const Vec3d across = normalized(cross(direction, std::abs(direction.z) < 0.9 ? Vec3d{0, 0, 1} : Vec3d{1, 0, 0}));
    for (const Vec3d& axis : {across, cross(across, direction)}) {
      // If the frame is rotated by a small w and moved by t, the position in it becomes position - w x position - t.
      // The component of `ray` along `axis` thereby decreases by dot(w, position x axis) + dot(t, axis).
      const Vec3d lever = cross(position, axis);
      for (const double term : {lever.x, lever.y, lever.z, axis.x, axis.y, axis.z}) design.push_back(term / range);
      values.push_back(dot(axis, ray) / range);
    }
  }
  const std::vector<double> c = fitLinear(design, 6, values).coefficients;
  const Vec3d rotation{c[0], c[1], c[2]};  // axis times angle (rad)
  const double angle = length(rotation);
  const Vec3d vectorPart = angle > 0 ? rotation * (std::sin(angle / 2) / angle) : Vec3d{};
  return {{std::cos(angle / 2), vectorPart.x, vectorPart.y, vectorPart.z}, {c[3], c[4], c[5]}};
}

// Returns the pose of the sensor in the scan's frame. Gauss-Newton steps over the six degrees of freedom minimise the
// angles between the points' directions and their beams.
Pose alignedFrame(const std::vector<BeamPoint>& points, const BeamTable& beams) {
  constexpr std::size_t kUsedPoints = 3000;  // approximate number of points used; limits the time
  constexpr int kMostSteps = 8;
  constexpr double kConvergedAngle = 1e-12, kConvergedMove = 1e-10;  // rad, m
  const std::size_t stride = std::max<std::size_t>(1, points.size() / kUsedPoints);
  Pose scanFromSensor{fromYawPitchRoll(startingYaw(points, beams), 0, 0), {}};
  for (int i = 0; i < kMostSteps; ++i) {
    const Pose step = alignmentStep(points, beams, inverse(scanFromSensor), stride);
    scanFromSensor = scanFromSensor * step;
    const double angle = 2 * std::hypot(step.rotation.x, step.rotation.y, step.rotation.z);
    if (angle < kConvergedAngle && length(step.translation) < kConvergedMove) break;
  }
  return scanFromSensor;
}

// Returns half of the least angle between neighbouring beams (rad), the largest angle of a point to its own beam.
double halfBeamSpacing(const BeamTable& beams) {
  double least = beams.field / std::max(beams.columns, 2u);
  std::vector<double> elevation = beams.elevation;
  std::ranges::sort(elevation);
  for (std::size_t ring = 1; ring < elevation.size(); ++ring) {
    const double step = elevation[ring] - elevation[ring - 1];
    if (step > 1e-6) least = std::min(least, step);
  }
  return least / 2;
}

constexpr double kSameRange = 2e-5;  // assumed error of ranges that are computed from float32 coordinates (m)

// Returns a first estimate of the step (m), from the smallest gaps between sorted ranges; 0 if the step is too small to
// be distinguished from rounding errors.
double smallestGap(const std::vector<double>& sorted) {
  constexpr double kSmallestStep = 5e-4;  // m; smaller steps cannot be distinguished from rounding errors
  constexpr std::size_t kFewestGaps = 10;
  std::vector<double> gaps;
  for (std::size_t i = 1; i < sorted.size(); ++i) {
    if (sorted[i] - sorted[i - 1] > 2 * kSameRange) gaps.push_back(sorted[i] - sorted[i - 1]);
  }
  if (gaps.size() < kFewestGaps) return 0;
  std::ranges::sort(gaps);
  const double gap = gaps[gaps.size() / 20];  // not the smallest, which rounding may have shortened
  return gap < kSmallestStep ? 0 : gap;
}

// Returns the step (m) more exactly than `step`, from the distances of sorted ranges to the first range, which are many
// steps long. Considers distances up to four steps, then up to sixteen and so on; each time, the previous step is exact
// enough to count the steps in a distance, and the new step is the least-squares solution of distance = count * step.
double refineStep(const std::vector<double>& sortedRanges, double step) {
  const double longestDistance = sortedRanges.back() - sortedRanges.front();
  for (double limit = step; limit < longestDistance;) {
    limit *= 4;
    double products = 0, squares = 0;  // sums of distance * count and of count^2
    for (const double range : sortedRanges) {
      const double distance = range - sortedRanges.front();
      if (distance > limit) break;
      const double count = std::round(distance / step);
      if (std::abs(distance - count * step) > step / 4) continue;  // not a multiple of the step
      products += distance * count;
      squares += count * count;
    }
    if (squares > 0) step = products / squares;
  }
  return step;
}

// Returns the number of ranges that are multiples of the step plus a constant. The constant is the circular mean of the
// ranges modulo the step.
std::ptrdiff_t countMultiples(const std::vector<double>& ranges, double step) {
  const double phase = circularMean(ranges, [&](double r) { return 2 * kPi * r / step; }) / (2 * kPi);  // in steps
  return std::ranges::count_if(ranges, [&](double r) {
    const double steps = r / step - phase;
    return std::abs(steps - std::round(steps)) * step < 5 * kSameRange;
  });
}

}  // namespace

RecordedScan rangesAlong(const Scan& scan, const BeamTable& beams, const std::string& name) {
  const Location where{name};
  if (scan.size() == 0) throw InputError(where, "has no points to measure noise on");
  const bool hasOnlyRings = !knowsBeams(scan) && !scan[kRing].empty() && beams.onCones();
  const std::vector<BeamPoint> points = firstReturns(hasOnlyRings ? withColumns(scan, beams) : scan, beams, where);
  if (points.size() < kFewestReturns) {
    throw InputError(where, "has {} returns, but noise is measured on at least {}", points.size(), kFewestReturns);
  }
  RecordedScan recorded;
  recorded.name = name;
  recorded.scanFromSensor = alignedFrame(points, beams);
  const double error = medianAngle(points, beams, recorded.scanFromSensor);
  if (!(error < halfBeamSpacing(beams))) {
    throw InputError(where,
                     "its points do not lie on the beams of {}: half of them are off by more than {:.3g} deg; give the "
                     "sensor that made the recording, and scans in its frame (not deskewed, not in world coordinates)",
                     beams.model, degrees(error));
  }
  recorded.range.assign(beams.size(), kNoReturn);
  recorded.raised.assign(beams.size(), 0.0f);
  const bool hasIntensities = scan[kIntensity].size() == scan.size();
  if (hasIntensities) recorded.intensity.assign(beams.size(), 0.0f);
  const Pose sensorFromScan = inverse(recorded.scanFromSensor);
  for (const BeamPoint& p : points) {
    const Vec3d ray = sensorFromScan * p.position - beams.originOf(p.beam);
    const double range = dot(ray, beams.direction[p.beam]);
    if (!(range > 0)) continue;
    recorded.raised[p.beam] = static_cast<float>(dot(ray, upwardsFrom(beams.direction[p.beam])) / range);
    ++recorded.returns;
    recorded.range[p.beam] = range;
    if (hasIntensities) recorded.intensity[p.beam] = scan[kIntensity][p.index];
  }
  return recorded;
}

double rangeStep(const std::vector<RecordedScan>& scans) {
  constexpr double kShare = 0.99;  // least fraction of the ranges that must be multiples of the step
  std::vector<double> sorted;
  for (const RecordedScan& scan : scans) {
    std::ranges::copy_if(scan.range, std::back_inserter(sorted), [](double r) { return !std::isnan(r); });
  }
  std::ranges::sort(sorted);
  double step = smallestGap(sorted);
  if (step == 0) return 0;
  step = refineStep(sorted, step);
  const auto multiples = static_cast<double>(countMultiples(sorted, step));
  return multiples >= kShare * static_cast<double>(sorted.size()) ? step : 0;
}

}  // namespace scanmill
