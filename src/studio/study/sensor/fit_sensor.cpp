#include "study/sensor/fit_sensor.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <optional>

#include "base/error.h"
#include "evaluate/spread.h"
#include "study/linear_fit.h"

namespace scanmill {
namespace {

constexpr std::size_t kFewestInRing = 20;  // least number of points in a ring that is used
// Columns that together span 2 pi to within this fraction of 2 pi are taken as a full revolution.
constexpr double kTurnTolerance = 0.015;
constexpr double kLeastSpread = 1;     // least standard deviation (m) of the axis distances in a fitted ring
constexpr double kSignificant = 3;     // an offset of fewer standard errors counts as zero
constexpr double kLeastOffset = 2e-3;  // smaller offsets (m) count as zero

struct Point {
  Vec3d position;  // in the sensor's frame (m)
  std::uint32_t column;
  std::optional<double> time;  // s
};

// Returns the median of angles (rad) around their circular mean.
double circularMedian(const std::vector<double>& angles) {
  const double mean = circularMean(angles, std::identity());
  std::vector<double> differences;
  for (const double a : angles) differences.push_back(wrapped(a - mean));
  return wrapped(mean + medianOf(differences));
}

double azimuthOf(const Point& p) {
  return std::atan2(p.position.y, p.position.x);
}

double axisDistance(const Point& p) {
  return std::hypot(p.position.x, p.position.y);
}

// The line z = intercept + slope * rho through the points of a ring, where rho is the distance from the z axis (m).
struct RingLine {
  double slope = 0, intercept = 0;
  double interceptError = 0;  // standard error (m)

  double residual(const Point& p) const { return p.position.z - intercept - slope * axisDistance(p); }
};

// Fits the line by least squares. Returns nothing if the points are too few or their axis distances vary too little.
std::optional<RingLine> fitRingLine(const std::vector<const Point*>& points) {
  if (points.size() < kFewestInRing) return std::nullopt;
  std::vector<double> design, distances, heights;
  for (const Point* p : points) {
    distances.push_back(axisDistance(*p));
    heights.push_back(p->position.z);
    design.insert(design.end(), {1, distances.back()});
  }
  const double deviation = deviationOf(distances), mean = meanOf(distances);
  if (!(deviation > kLeastSpread)) return std::nullopt;
  const LinearFit fit = fitLinear(design, 2, heights);
  const double error = std::sqrt(fit.squares) / static_cast<double>(points.size()) * std::hypot(1, mean / deviation);
  return RingLine{.slope = fit.coefficients[1], .intercept = fit.coefficients[0], .interceptError = error + 1e-6};
}

// Fits a line to the points of a ring, three times; after each fit, removes points that are far from the line. Returns
// nothing if a fit is not possible.
std::optional<RingLine> robustRingLine(const std::vector<Point>& ring) {
  constexpr double kOutlierRatio = 4;  // multiple of the median residual
  std::vector<const Point*> points;
  for (const Point& p : ring) points.push_back(&p);
  std::optional<RingLine> line;
  for (int round = 0; round < 3; ++round) {
    line = fitRingLine(points);
    if (!line) return line;
    std::vector<double> residuals;
    for (const Point* p : points) residuals.push_back(std::fabs(line->residual(*p)));
    const double largest = kOutlierRatio * medianOf(std::move(residuals)) + 1e-9;
    std::erase_if(points, [&](const Point* p) { return std::fabs(line->residual(*p)) > largest; });
  }
  return line;
}

// Estimates a sensor. Each find function uses results of other find functions; fit() calls them in the right order.
class SensorFitter {
 public:
  // Collects the points of all scans by ring.
  explicit SensorFitter(const std::vector<Scan>& scans) {
    if (scans.empty()) throw InputError("fit-sensor: no scans are given");
    PointKey extent{0, 0, 0};
    for (const Scan& scan : scans) {
      if (!knowsBeams(scan)) {
        throw InputError(
            "the beams of the scans' points are unknown: the scans must be organised (HEIGHT above 1), or have the "
            "columns ring and column");
      }
      const PointKey ofScan = extentOf(scan);  // numbers of rings and columns
      extent.ring = std::max(extent.ring, scan.organised ? scan.rings : ofScan.ring);
      extent.column = std::max({extent.column, scan.columns, ofScan.column});
    }
    fit_.rings = extent.ring;
    fit_.columns = extent.column;
    if (fit_.rings == 0 || fit_.columns < 2) throw InputError("the scans must have rings of at least two columns");
    rings_.resize(fit_.rings);
    for (const Scan& scan : scans) addPoints(scan);
    if (fit_.points < kFewestInRing)
      throw InputError(fmt::format("the scans have only {} points, which are too few", fit_.points));
  }

  SensorFit fit() {
    findColumnStep();
    findAzimuthOffsets(0);
    findOrigin();
    findAzimuthOffsets(fit_.originOffset);
    findElevations();
    fillBareRings();
    findTimes();
    return std::move(fit_);
  }

 private:
  // Adds the finite first returns of a scan. Ignores points at the origin, which in some formats mean no return.
  void addPoints(const Scan& scan) {
    const auto& time = scan[kTime];
    for (std::size_t i = 0; i < scan.size(); ++i) {
      const Vec3d p(scan.position[i]);
      const double range = length(p);
      const PointKey key = keyOf(scan, i);
      if (!isFinite(scan.position[i]) || range < 1e-3 || key.number > 0) continue;
      rings_[key.ring].push_back({p, key.column, time.empty() ? std::nullopt : std::optional(double{time[i]})});
      fit_.nearest = fit_.points == 0 ? range : std::min(fit_.nearest, range);
      fit_.farthest = std::max(fit_.farthest, range);
      ++fit_.points;
    }
  }

  // Calls visit(a, b) for all pairs of points in a ring where b is `apart` columns after a. If a column of the ring has
  // several points, only its last point is used.
  void forEachPair(std::uint32_t apart, const auto& visit) const {
    std::vector<const Point*> byColumn(fit_.columns);
    for (const std::vector<Point>& ring : rings_) {
      std::ranges::fill(byColumn, nullptr);
      for (const Point& p : ring) byColumn[p.column] = &p;
      for (std::uint32_t c = 0; c + apart < fit_.columns; ++c) {
        if (byColumn[c] != nullptr && byColumn[c + apart] != nullptr) visit(*byColumn[c], *byColumn[c + apart]);
      }
    }
  }

  // Finds the rotation of the sensor's head from column to column (rad); negative if clockwise.
  void findColumnStep() {
    std::vector<double> steps;
    forEachPair(1, [&](const Point& a, const Point& b) { steps.push_back(wrapped(azimuthOf(b) - azimuthOf(a))); });
    if (steps.size() < kFewestInRing)
      throw InputError("the scans have too few pairs of points in neighbouring columns: give scans with more returns");
    step_ = medianOf(steps);
    // Columns that are farther apart determine the step more exactly. The number of full turns between them follows
    // from the previous, less exact step.
    for (std::uint32_t apart = 4; apart < fit_.columns; apart *= 4) {
      steps.clear();
      forEachPair(apart, [&](const Point& a, const Point& b) {
        steps.push_back(step_ + wrapped(azimuthOf(b) - azimuthOf(a) - step_ * apart) / apart);
      });
      if (steps.size() >= kFewestInRing) step_ = medianOf(steps);
    }
    fit_.clockwise = step_ < 0;
    const double allColumns = std::fabs(step_) * fit_.columns;  // angle (rad)
    if (allColumns > 2 * kPi * (1 + kTurnTolerance)) {
      throw InputError(
          fmt::format("{} columns of {:.4f} deg are more than a revolution: are these scans of several sensors, or are "
                      "their columns not in the order of the azimuths?",
                      fit_.columns, degrees(std::fabs(step_))));
    }
    const bool fullTurn = allColumns > 2 * kPi * (1 - kTurnTolerance);
    if (fullTurn) step_ = (fit_.clockwise ? -2 : 2) * kPi / fit_.columns;
    fit_.field = fullTurn ? 2 * kPi : std::fabs(step_) * (fit_.columns - 1);
  }

  bool hasEnoughPoints(std::uint32_t ring) const { return rings_[ring].size() >= kFewestInRing; }

  // Returns the angle (rad) from the head's azimuth to a point's beam, whose origin is `originOffset` m from the axis.
  double azimuthOffsetOf(const Point& p, double originOffset) const {
    const double headAzimuth = fit_.firstAzimuth + step_ * p.column;
    const double angle = azimuthOf(p) - headAzimuth;
    const double distance = axisDistance(p);
    return std::atan2(distance * std::sin(angle), distance * std::cos(angle) - originOffset);
  }

  // Finds the azimuth offset of each ring, and shifts the first azimuth so that the median of the offsets is 0.
  void findAzimuthOffsets(double originOffset) {
    std::vector<double> ringOffsets;  // offsets of the rings with enough points (rad)
    fit_.azimuthOffset.assign(fit_.rings, 0);
    for (std::uint32_t ring = 0; ring < fit_.rings; ++ring) {
      if (!hasEnoughPoints(ring)) continue;
      std::vector<double> offsets;
      for (const Point& p : rings_[ring]) offsets.push_back(azimuthOffsetOf(p, originOffset));
      fit_.azimuthOffset[ring] = circularMedian(offsets);
      ringOffsets.push_back(fit_.azimuthOffset[ring]);
    }
    if (ringOffsets.empty()) throw InputError("no ring has enough points");
    const double median = circularMedian(ringOffsets);
    fit_.firstAzimuth = wrapped(fit_.firstAzimuth + median);
    std::vector<double> deviations;  // deviations of all points from their rings (rad)
    for (std::uint32_t ring = 0; ring < fit_.rings; ++ring) {
      fit_.azimuthOffset[ring] = wrapped(fit_.azimuthOffset[ring] - median);
      if (!hasEnoughPoints(ring)) continue;
      for (const Point& p : rings_[ring])
        deviations.push_back(std::fabs(wrapped(azimuthOffsetOf(p, originOffset) - fit_.azimuthOffset[ring])));
    }
    fit_.azimuthSpread = medianOf(deviations);
  }

  // Finds the height and the offset of the beams' origin by weighted least squares. Each ring's line gives a linear
  // equation: intercept = height + offset * x, where x = -cos(azimuth offset) * slope.
  void findOrigin() {
    double w = 0, wx = 0, wy = 0, wxx = 0, wxy = 0;  // sums of weights, times x, times y = intercept and so on
    for (std::uint32_t ring = 0; ring < fit_.rings; ++ring) {
      const std::optional<RingLine> line = robustRingLine(rings_[ring]);
      if (!line) continue;
      const double weight = 1 / (line->interceptError * line->interceptError);
      const double x = -std::cos(fit_.azimuthOffset[ring]) * line->slope;
      w += weight;
      wx += weight * x;
      wy += weight * line->intercept;
      wxx += weight * x * x;
      wxy += weight * x * line->intercept;
    }
    const double determinant = w * wxx - wx * wx;
    if (!(w > 0)) return;
    if (determinant > 1e-12 * w * wxx) {  // else all rings have the same x, which does not determine the offset
      const double offset = (w * wxy - wx * wy) / determinant;
      const double error = std::sqrt(w / determinant);
      if (offset > std::max(kLeastOffset, kSignificant * error)) fit_.originOffset = offset;
    }
    const double height = (wy - fit_.originOffset * wx) / w;
    if (std::fabs(height) > std::max(kLeastOffset, kSignificant * std::sqrt(1 / w))) fit_.originHeight = height;
  }

  // Finds the elevation of each ring with enough points, and lists the other rings in `bareRings`.
  void findElevations() {
    fit_.elevation.assign(fit_.rings, 0);
    std::vector<double> deviations;  // deviations of all points from their rings (rad)
    for (std::uint32_t ring = 0; ring < fit_.rings; ++ring) {
      if (!hasEnoughPoints(ring)) {
        fit_.bareRings.push_back(ring);
        continue;
      }
      // The beam's origin relative to the axis, across the beam and along it (m).
      const double across = fit_.originOffset * std::sin(fit_.azimuthOffset[ring]);
      const double along = fit_.originOffset * std::cos(fit_.azimuthOffset[ring]);
      std::vector<double> angles;
      for (const Point& p : rings_[ring]) {
        const double distance = axisDistance(p);
        const double fromOrigin = std::sqrt(std::max(distance * distance - across * across, 0.0)) - along;
        angles.push_back(std::atan2(p.position.z - fit_.originHeight, fromOrigin));
      }
      fit_.elevation[ring] = medianOf(angles);
      for (const double a : angles) deviations.push_back(std::fabs(a - fit_.elevation[ring]));
    }
    if (deviations.empty()) throw InputError("no ring has enough points");
    fit_.elevationSpread = medianOf(deviations);
  }

  // Sets the elevation of each ring with too few points from the line (elevation over ring number) through the two
  // nearest rings with enough points. If only one ring has enough points, uses this ring's elevation.
  void fillBareRings() {
    for (const std::uint32_t bareRing : fit_.bareRings) {
      std::vector<std::uint32_t> nearest;  // rings with enough points, by distance from the bare ring
      for (std::uint32_t ring = 0; ring < fit_.rings; ++ring) {
        if (hasEnoughPoints(ring)) nearest.push_back(ring);
      }
      std::ranges::stable_sort(nearest, {},
                               [&](std::uint32_t ring) { return ring < bareRing ? bareRing - ring : ring - bareRing; });
      double elevation = fit_.elevation[nearest[0]];
      if (nearest.size() > 1) {
        elevation += (fit_.elevation[nearest[1]] - elevation) *
                     (static_cast<double>(bareRing) - static_cast<double>(nearest[0])) /
                     (static_cast<double>(nearest[1]) - static_cast<double>(nearest[0]));
      }
      fit_.elevation[bareRing] = std::clamp(elevation, -kPi / 2, kPi / 2);
    }
  }

  // Returns the time difference per column (s) for each pair of points with times in one ring, `apart` columns apart.
  std::vector<double> timeSteps(std::uint32_t apart) const {
    std::vector<double> steps;
    forEachPair(apart, [&](const Point& a, const Point& b) {
      if (a.time && b.time) steps.push_back((*b.time - *a.time) / apart);
    });
    return steps;
  }

  // Finds the period of revolution and each ring's firing time after the first ring; sets nothing if times are too few.
  void findTimes() {
    // Points that are far apart determine the time per column more exactly.
    const std::vector<double> nearSteps = timeSteps(1), farSteps = timeSteps(fit_.columns / 2);
    if (nearSteps.size() < kFewestInRing) return;
    const double timeStep = medianOf(farSteps.size() >= kFewestInRing ? farSteps : nearSteps);
    if (!(timeStep > 0)) return;
    fit_.period = timeStep * 2 * kPi / std::fabs(step_);
    fit_.firing.assign(fit_.rings, std::numeric_limits<double>::quiet_NaN());  // NaN: too few times
    for (std::uint32_t ring = 0; ring < fit_.rings; ++ring) {
      std::vector<double> times;  // time of column 0, extrapolated from each point
      for (const Point& p : rings_[ring]) {
        if (p.time) times.push_back(*p.time - timeStep * p.column);
      }
      if (times.size() >= kFewestInRing) fit_.firing[ring] = medianOf(times);
    }
    double first = std::numeric_limits<double>::max();
    for (const double time : fit_.firing) first = std::fmin(first, time);
    for (double& time : fit_.firing) time = std::isnan(time) ? 0 : time - first;
  }

  std::vector<std::vector<Point>> rings_;  // points by ring
  double step_ = 0;                        // rotation from column to column (rad)
  SensorFit fit_;
};

// Returns the values times `factor` as a YAML list, 12 to a line. `digits`: number of decimals.
std::string yamlList(const std::vector<double>& values, double factor, int digits) {
  std::string text = "[";
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double value = values[i] * factor;
    const std::string number =
        fmt::format("{:.{}f}", std::fabs(value) < 0.5 * std::pow(10, -digits) ? 0.0 : value, digits);
    text += fmt::format("{}{}", i == 0 ? "" : i % 12 == 0 ? ",\n  " : ", ", number);
  }
  return text + "]";
}

}  // namespace

SensorFit fitSensor(const std::vector<Scan>& scans) {
  return SensorFitter(scans).fit();
}

std::string sensorYaml(const SensorFit& fit, const std::string& source) {
  const char* ringOrder = std::ranges::is_sorted(fit.elevation, std::greater<>()) ? "top_down"
                          : std::ranges::is_sorted(fit.elevation)                 ? "bottom_up"
                                                                                  : "unordered";
  std::string text = fmt::format("model: fitted\nsource: \"{}\"\ncolumns: {}\n", source, fit.columns);
  text += fit.period > 0 ? fmt::format("rate_hz: {:.5g}\n", 1 / fit.period)
                         : "rate_hz: 10   # the scans have no times: check\n";
  text += fmt::format("direction: {}\nfirst_azimuth_deg: {:.4f}   # if x is forward in the scans: check\n",
                      fit.clockwise ? "clockwise" : "counterclockwise", degrees(fit.firstAzimuth));
  if (fit.field < 2 * kPi - 1e-9) text += fmt::format("field_deg: {:.4f}\n", degrees(fit.field));
  text += fmt::format("ring_order: {}\nelevation_deg: {}\nazimuth_offset_deg: {}\n", ringOrder,
                      yamlList(fit.elevation, degrees(1), 4), yamlList(fit.azimuthOffset, degrees(1), 4));
  if (fit.originOffset > 0) text += fmt::format("origin_offset_m: {:.4f}\n", fit.originOffset);
  if (fit.originHeight != 0) text += fmt::format("origin_height_m: {:.4f}\n", fit.originHeight);
  const bool ringsFireApart = std::ranges::any_of(fit.firing, [](double time) { return time > 1e-8; });
  if (ringsFireApart) text += fmt::format("firing_time_us: {}\n", yamlList(fit.firing, 1e6, 2));
  text += fmt::format("range_m: [{:.3g}, {:.4g}]   # the nearest and the farthest point: check with the data sheet\n",
                      fit.nearest, fit.farthest);
  return text;
}

}  // namespace scanmill
