#include "study/sensor/fit_sensor.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>

#include "base/error.h"
#include "evaluate/spread.h"

namespace scanmill {
namespace {

constexpr std::size_t kFewestInRing = 20;  // least number of points in a ring that is used
// Columns whose angle differs by at most this fraction from a full revolution count as a full revolution.
constexpr double kTurnTolerance = 0.015;
constexpr double kSpreadWanted = 1;    // least standard deviation (m) of a ring's axis distances, to find the origin
constexpr double kSignificant = 3;     // number of standard errors from which an offset counts as not zero
constexpr double kLeastOffset = 2e-3;  // smaller offsets (m) count as zero

struct Point {
  Vec3d position;  // in the sensor's frame (m)
  std::uint32_t column;
  std::optional<double> time;
};

using Rings = std::vector<std::vector<Point>>;

// Returns the median of angles (rad) around their circular mean.
double circularMedian(const std::vector<double>& angles) {
  double x = 0, y = 0;
  for (const double a : angles) x += std::cos(a), y += std::sin(a);
  const double mean = std::atan2(y, x);
  std::vector<double> off;
  off.reserve(angles.size());
  for (const double a : angles) off.push_back(wrapped(a - mean));
  return wrapped(mean + medianOf(off));
}

double azimuthOf(const Point& p) {
  return std::atan2(p.position.y, p.position.x);
}

double axisDistance(const Point& p) {
  return std::hypot(p.position.x, p.position.y);
}

// The line z = intercept + slope * rho through the points of a ring, where rho is the distance from the z axis (m).
struct RingLine {
  double slope = 0, intercept = 0, error = 0;  // `error`: standard error of the intercept (m)

  double residual(const Point& p) const { return p.position.z - intercept - slope * axisDistance(p); }
};

// Fits a line by least squares. Returns nothing if there are too few points, or if their distances from the axis differ
// too little.
std::optional<RingLine> fitLine(const std::vector<const Point*>& points) {
  const auto n = static_cast<double>(points.size());
  if (points.size() < kFewestInRing) return std::nullopt;
  double sumX = 0, sumY = 0, sumXX = 0, sumXY = 0;
  for (const Point* p : points) {
    const double x = axisDistance(*p), y = p->position.z;
    sumX += x, sumY += y, sumXX += x * x, sumXY += x * y;
  }
  const double variance = sumXX / n - sumX / n * (sumX / n);
  if (!(variance > kSpreadWanted * kSpreadWanted)) return std::nullopt;
  RingLine line;
  line.slope = (sumXY / n - sumX / n * (sumY / n)) / variance;
  line.intercept = (sumY - line.slope * sumX) / n;
  double squares = 0;
  for (const Point* p : points) squares += line.residual(*p) * line.residual(*p);
  line.error = std::sqrt(squares / n * (sumXX / n) / (n * variance)) + 1e-6;
  return line;
}

// Fits a line to the points of a ring, three times; after each fit, removes points that are far from the line.
std::optional<RingLine> lineOf(const std::vector<Point>& ring) {
  constexpr double kFar = 4;  // multiple of the median residual
  std::vector<const Point*> points;
  for (const Point& p : ring) points.push_back(&p);
  std::optional<RingLine> line;
  for (int round = 0; round < 3; ++round) {
    line = fitLine(points);
    if (!line) return line;
    std::vector<double> residuals;
    for (const Point* p : points) residuals.push_back(std::fabs(line->residual(*p)));
    const double most = kFar * medianOf(std::move(residuals)) + 1e-9;
    std::erase_if(points, [&](const Point* p) { return std::fabs(line->residual(*p)) > most; });
  }
  return line;
}

class SensorFitter {
 public:
  explicit SensorFitter(const std::vector<Scan>& scans) {
    if (scans.empty()) throw InputError("fit-sensor: no scans are given");
    PointKey extent{0, 0, 0};
    for (const Scan& scan : scans) {
      if (!knowsBeams(scan)) {
        throw InputError(
            "the beams of the scans' points are unknown: the scans must be organised (HEIGHT above 1), or have the "
            "columns ring and column");
      }
      const PointKey own = extentOf(scan);
      extent.ring = std::max(extent.ring, scan.organised ? scan.rings : own.ring);
      extent.column = std::max({extent.column, scan.columns, own.column});
    }
    fit_.rings = extent.ring;
    fit_.columns = extent.column;
    if (fit_.rings == 0 || fit_.columns < 2) throw InputError("the scans must have rings of at least two columns");
    rings_.resize(fit_.rings);
    for (const Scan& scan : scans) add(scan);
    if (fit_.points < kFewestInRing)
      throw InputError(fmt::format("the scans have only {} points, which are too few", fit_.points));
  }

  SensorFit fit() {
    findColumnStep();
    findOffsets(0);
    findOrigin();
    findOffsets(fit_.originOffset);
    findElevations();
    fillBareRings();
    findTimes();
    return std::move(fit_);
  }

 private:
  void add(const Scan& scan) {
    const auto& time = scan[kTime];
    for (std::size_t i = 0; i < scan.size(); ++i) {
      const Vec3d p(scan.position[i]);
      const double range = length(p);
      if (!isFinite(scan.position[i]) || range < 1e-3) continue;
      const PointKey key = keyOf(scan, i);
      if (key.number > 0) continue;
      rings_[key.ring].push_back({p, key.column, time.empty() ? std::nullopt : std::optional(double{time[i]})});
      fit_.nearest = fit_.points == 0 ? range : std::min(fit_.nearest, range);
      fit_.farthest = std::max(fit_.farthest, range);
      ++fit_.points;
    }
  }

  // Calls visit(a, b) for pairs of points in the same ring, where b is `apart` columns after a. If a column has several
  // points, only the last of them is used.
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
    const double turn = std::fabs(step_) * fit_.columns;
    if (turn > 2 * kPi * (1 + kTurnTolerance)) {
      throw InputError(
          fmt::format("{} columns of {:.4f} deg are more than a revolution: are these scans of several sensors, or are "
                      "their columns not in the order of the azimuths?",
                      fit_.columns, degrees(std::fabs(step_))));
    }
    const bool fullTurn = turn > 2 * kPi * (1 - kTurnTolerance);
    if (fullTurn) step_ = (fit_.clockwise ? -2 : 2) * kPi / fit_.columns;
    fit_.field = fullTurn ? 2 * kPi : std::fabs(step_) * (fit_.columns - 1);
  }

  // Returns the angle (rad) of a point's beam relative to the head's azimuth. `origin`: distance of the beam's origin
  // from the axis (m).
  double offsetOf(const Point& p, double origin) const {
    const double head = fit_.firstAzimuth + step_ * p.column;
    const double turned = azimuthOf(p) - head;
    const double far = axisDistance(p);
    return std::atan2(far * std::sin(turned), far * std::cos(turned) - origin);
  }

  // Finds the azimuth offset of each ring, and shifts the first azimuth so that their median is 0.
  void findOffsets(double origin) {
    std::vector<double> known;  // offsets of the rings with enough points (rad)
    fit_.azimuthOffset.assign(fit_.rings, 0);
    for (std::uint32_t ring = 0; ring < fit_.rings; ++ring) {
      if (rings_[ring].size() < kFewestInRing) continue;
      std::vector<double> offsets;
      for (const Point& p : rings_[ring]) offsets.push_back(offsetOf(p, origin));
      fit_.azimuthOffset[ring] = circularMedian(offsets);
      known.push_back(fit_.azimuthOffset[ring]);
    }
    if (known.empty()) throw InputError("no ring has enough points");
    const double middle = circularMedian(known);
    fit_.firstAzimuth = wrapped(fit_.firstAzimuth + middle);
    std::vector<double> off;
    for (std::uint32_t ring = 0; ring < fit_.rings; ++ring) {
      fit_.azimuthOffset[ring] = wrapped(fit_.azimuthOffset[ring] - middle);
      if (rings_[ring].size() < kFewestInRing) continue;
      for (const Point& p : rings_[ring])
        off.push_back(std::fabs(wrapped(offsetOf(p, origin) - fit_.azimuthOffset[ring])));
    }
    fit_.azimuthSpread = medianOf(off);
  }

  // Finds the beams' origin. In each ring, intercept = height - offset * cos(azimuth offset) * slope, a linear equation
  // for the height and the offset of the origin, which are fitted by weighted least squares.
  void findOrigin() {
    double w = 0, wx = 0, wy = 0, wxx = 0, wxy = 0;  // sums of weights, times x, times y and so on
    for (std::uint32_t ring = 0; ring < fit_.rings; ++ring) {
      const std::optional<RingLine> line = lineOf(rings_[ring]);
      if (!line) continue;
      const double weight = 1 / (line->error * line->error);
      const double x = -std::cos(fit_.azimuthOffset[ring]) * line->slope;
      w += weight, wx += weight * x, wy += weight * line->intercept;
      wxx += weight * x * x, wxy += weight * x * line->intercept;
    }
    const double det = w * wxx - wx * wx;
    if (!(w > 0)) return;
    if (det > 1e-12 * w * wxx) {
      const double offset = (w * wxy - wx * wy) / det;
      const double error = std::sqrt(w / det);
      if (offset > std::max(kLeastOffset, kSignificant * error)) fit_.originOffset = offset;
    }
    const double height = (wy - fit_.originOffset * wx) / w;
    if (std::fabs(height) > std::max(kLeastOffset, kSignificant * std::sqrt(1 / w))) fit_.originHeight = height;
  }

  void findElevations() {
    fit_.elevation.assign(fit_.rings, 0);
    std::vector<double> off;
    for (std::uint32_t ring = 0; ring < fit_.rings; ++ring) {
      if (rings_[ring].size() < kFewestInRing) {
        fit_.bareRings.push_back(ring);
        continue;
      }
      const double across = fit_.originOffset * std::sin(fit_.azimuthOffset[ring]);
      const double along = fit_.originOffset * std::cos(fit_.azimuthOffset[ring]);
      std::vector<double> angles;
      for (const Point& p : rings_[ring]) {
        const double far = axisDistance(p);
        const double level = std::sqrt(std::max(far * far - across * across, 0.0)) - along;
        angles.push_back(std::atan2(p.position.z - fit_.originHeight, level));
      }
      fit_.elevation[ring] = medianOf(angles);
      for (const double a : angles) off.push_back(std::fabs(a - fit_.elevation[ring]));
    }
    if (off.empty()) throw InputError("no ring has enough points");
    fit_.elevationSpread = medianOf(off);
  }

  // Sets the elevations of rings with too few points. Uses the line through the elevations of the two nearest rings
  // with enough points, over the ring number; if only one ring has enough, its elevation.
  void fillBareRings() {
    const auto known = [&](std::int64_t ring) {
      return ring >= 0 && ring < fit_.rings && rings_[static_cast<std::size_t>(ring)].size() >= kFewestInRing;
    };
    for (const std::uint32_t bare : fit_.bareRings) {
      std::vector<std::uint32_t> near;  // the nearest rings with enough points, at most two
      for (std::int64_t apart = 1; apart < fit_.rings && near.size() < 2; ++apart) {
        for (const std::int64_t ring : {bare - apart, bare + apart}) {
          if (known(ring) && near.size() < 2) near.push_back(static_cast<std::uint32_t>(ring));
        }
      }
      double elevation = fit_.elevation[near[0]];
      if (near.size() == 2) {
        const double part = (static_cast<double>(bare) - static_cast<double>(near[0])) /
                            (static_cast<double>(near[1]) - static_cast<double>(near[0]));
        elevation += (fit_.elevation[near[1]] - elevation) * part;
      }
      fit_.elevation[bare] = std::clamp(elevation, -kPi / 2, kPi / 2);
    }
  }

  // Finds the duration of a revolution, and when each ring fires after the first.
  void findTimes() {
    const auto stepsOver = [&](std::uint32_t apart) {
      std::vector<double> steps;
      forEachPair(apart, [&](const Point& a, const Point& b) {
        if (a.time && b.time) steps.push_back((*b.time - *a.time) / apart);
      });
      return steps;
    };
    const std::vector<double> near = stepsOver(1), far = stepsOver(fit_.columns / 2);
    if (near.size() < kFewestInRing) return;
    const double step = medianOf(far.size() >= kFewestInRing ? far : near);
    if (!(step > 0)) return;
    fit_.period = step * 2 * kPi / std::fabs(step_);
    std::map<std::uint32_t, double> firing;  // s, of the rings that have enough times; others keep 0
    double first = std::numeric_limits<double>::max();
    for (std::uint32_t ring = 0; ring < fit_.rings; ++ring) {
      std::vector<double> times;
      for (const Point& p : rings_[ring]) {
        if (p.time) times.push_back(*p.time - step * p.column);
      }
      if (times.size() >= kFewestInRing) first = std::min(first, firing[ring] = medianOf(times));
    }
    fit_.firing.assign(fit_.rings, 0);
    for (const auto& [ring, time] : firing) fit_.firing[ring] = time - first;
  }

  Rings rings_;
  double step_ = 0;  // rotation from column to column (rad)
  SensorFit fit_;
};

std::string listOf(const std::vector<double>& values, double unit, int digits) {
  std::string text = "[";
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double value = values[i] * unit;
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
  const bool down = std::ranges::is_sorted(fit.elevation, std::greater<>());
  const bool up = std::ranges::is_sorted(fit.elevation);
  std::string text = fmt::format("model: fitted\nsource: \"{}\"\ncolumns: {}\n", source, fit.columns);
  text += fit.period > 0 ? fmt::format("rate_hz: {:.5g}\n", 1 / fit.period)
                         : "rate_hz: 10   # the scans have no times: check\n";
  text += fmt::format("direction: {}\nfirst_azimuth_deg: {:.4f}   # if x is forward in the scans: check\n",
                      fit.clockwise ? "clockwise" : "counterclockwise", degrees(fit.firstAzimuth));
  if (fit.field < 2 * kPi - 1e-9) text += fmt::format("field_deg: {:.4f}\n", degrees(fit.field));
  text += fmt::format("ring_order: {}\nelevation_deg: {}\nazimuth_offset_deg: {}\n",
                      down ? "top_down"
                      : up ? "bottom_up"
                           : "unordered",
                      listOf(fit.elevation, degrees(1), 4), listOf(fit.azimuthOffset, degrees(1), 4));
  if (fit.originOffset > 0) text += fmt::format("origin_offset_m: {:.4f}\n", fit.originOffset);
  if (fit.originHeight != 0) text += fmt::format("origin_height_m: {:.4f}\n", fit.originHeight);
  const bool fires = std::ranges::any_of(fit.firing, [](double f) { return f > 1e-8; });
  if (fires) text += fmt::format("firing_time_us: {}\n", listOf(fit.firing, 1e6, 2));
  text += fmt::format("range_m: [{:.3g}, {:.4g}]   # the nearest and the farthest point: check with the data sheet\n",
                      fit.nearest, fit.farthest);
  return text;
}

}  // namespace scanmill
