#include "town/geometry.h"

#include <algorithm>
#include <cmath>

namespace scanmill::town {

using models::forSides;

double distance(const Point2& a, const Point2& b) {
  return std::hypot(a.x - b.x, a.y - b.y);
}

std::vector<Point2> relativeTo(const Point2& origin, std::vector<Point2> points) {
  for (Point2& p : points) p = {p.x - origin.x, p.y - origin.y};
  return points;
}

Extent extentOf(const std::vector<Point2>& points) {
  Extent extent{points.front(), points.front()};
  for (const Point2& p : points) {
    extent.low = {std::min(extent.low.x, p.x), std::min(extent.low.y, p.y)};
    extent.high = {std::max(extent.high.x, p.x), std::max(extent.high.y, p.y)};
  }
  return extent;
}

double lengthOf(const Line& line) {
  double length = 0;
  for (std::size_t i = 1; i < line.size(); ++i) length += distance(line[i - 1], line[i]);
  return length;
}

Point2 pointAt(const Line& line, double along) {
  double remaining = along;
  for (std::size_t i = 1; i < line.size(); ++i) {
    const double length = distance(line[i - 1], line[i]);
    if (remaining <= length && length > 0) return models::lerp(line[i - 1], line[i], remaining / length);
    remaining -= length;
  }
  return line.back();
}

Point2 directionOf(const Point2& a, const Point2& b) {
  const double length = distance(a, b);
  return {(b.x - a.x) / length, (b.y - a.y) / length};
}

Nearest nearestOn(const Line& line, const Point2& p) {
  Nearest nearest;
  double travelled = 0;  // m from the start of the line to the segment
  for (std::size_t i = 1; i < line.size(); ++i) {
    const Point2& start = line[i - 1];
    const double length = distance(start, line[i]);
    const Point2 heading = directionOf(start, line[i]);
    const double t = std::clamp((p.x - start.x) * heading.x + (p.y - start.y) * heading.y, 0.0, length);
    const double d = distance(p, {start.x + heading.x * t, start.y + heading.y * t});
    if (d < nearest.distance) nearest = {d, travelled + t, heading};
    travelled += length;
  }
  return nearest;
}

Line evenLine(const Line& line, double step) {
  const double length = lengthOf(line);
  const auto count = std::max(1, static_cast<int>(std::lround(length / step)));
  Line points;
  std::size_t segment = 1;  // index of the end point of the current segment of the line
  double travelled = 0;     // m from the start of the line to the start of the segment
  for (int k = 0; k <= count; ++k) {
    const double target = length * k / count;
    while (segment + 1 < line.size() && travelled + distance(line[segment - 1], line[segment]) < target) {
      travelled += distance(line[segment - 1], line[segment]);
      ++segment;
    }
    const double segmentLength = distance(line[segment - 1], line[segment]);
    const double t = segmentLength > 0 ? std::clamp((target - travelled) / segmentLength, 0.0, 1.0) : 0;
    points.push_back(models::lerp(line[segment - 1], line[segment], t));
  }
  return points;
}

Line denseLine(const Line& line, double step) {
  constexpr double kLeastDistance = 0.02;  // m between two points of the result
  Line points{line.front()};
  for (const Point2& p : line) {
    if (distance(p, points.back()) < kLeastDistance) continue;
    const Line piece = evenLine({points.back(), p}, step);
    points.insert(points.end(), piece.begin() + 1, piece.end());
  }
  return points;
}

Line smoothLine(const Line& line, double step) {
  Line points = evenLine(line, step);
  constexpr int kPasses = 8;  // all passes together average over about two points on each side
  for (int pass = 0; pass < kPasses; ++pass) {
    Line averaged = points;
    for (std::size_t i = 1; i + 1 < points.size(); ++i) {
      averaged[i] = {(points[i - 1].x + 2 * points[i].x + points[i + 1].x) / 4,
                     (points[i - 1].y + 2 * points[i].y + points[i + 1].y) / 4};
    }
    points = std::move(averaged);
  }
  // Remove points that nearly coincide: where the line turns back, smoothing moves points together.
  constexpr double kLeastDistance = 0.1;  // m between two points of the result
  Line apart;
  for (const Point2& p : points) {
    if (apart.empty() || distance(apart.back(), p) > kLeastDistance) apart.push_back(p);
  }
  if (apart.size() > 1) apart.back() = points.back();
  return apart;
}

std::vector<Line> runsWithin(const Line& line, double half) {
  std::vector<Line> runs(1);
  for (const Point2& p : line) {
    if (std::max(std::abs(p.x), std::abs(p.y)) < half) {
      runs.back().push_back(p);
    } else if (!runs.back().empty()) {
      runs.emplace_back();
    }
  }
  if (runs.back().empty()) runs.pop_back();
  return runs;
}

bool isInside(const std::vector<const Polygon*>& rings, const Point2& p) {
  bool inside = false;
  for (const Polygon* ring : rings) {
    forSides(*ring, [&](const Point2& a, const Point2& b) {
      if ((a.y > p.y) != (b.y > p.y) && p.x < a.x + (b.x - a.x) * (p.y - a.y) / (b.y - a.y)) inside = !inside;
    });
  }
  return inside;
}

double distanceToRings(const std::vector<const Polygon*>& rings, const Point2& p) {
  double least = 1e9;
  for (const Polygon* ring : rings) {
    forSides(*ring, [&](const Point2& a, const Point2& b) {
      const double dx = b.x - a.x;
      const double dy = b.y - a.y;
      const double square = dx * dx + dy * dy;
      const double t = square > 0 ? std::clamp(((p.x - a.x) * dx + (p.y - a.y) * dy) / square, 0.0, 1.0) : 0;
      least = std::min(least, std::hypot(p.x - a.x - t * dx, p.y - a.y - t * dy));
    });
  }
  return least;
}

std::vector<Point2> pointsAlong(const Polygon& ring, double step) {
  std::vector<Point2> points;
  forSides(ring, [&](const Point2& a, const Point2& b) {
    const auto count = std::max(1, static_cast<int>(std::ceil(distance(a, b) / step)));
    for (int k = 0; k < count; ++k) points.push_back(models::lerp(a, b, static_cast<double>(k) / count));
  });
  return points;
}

double areaOf(const Polygon& ring) {
  double area = 0;
  forSides(ring, [&](const Point2& p, const Point2& q) { area += (p.x * q.y - q.x * p.y) / 2; });
  return area;
}

models::Footprint rectangleAbout(const Polygon& ring) {
  models::Footprint smallest;
  double smallestArea = 1e18;
  forSides(ring, [&](const Point2& a, const Point2& b) {
    const double yaw = std::atan2(b.y - a.y, b.x - a.x);
    const double c = std::cos(yaw);
    const double s = std::sin(yaw);
    Polygon rotated;  // coordinates along and across this side
    for (const Point2& p : ring) rotated.push_back({p.x * c + p.y * s, p.y * c - p.x * s});
    const auto [low, high] = extentOf(rotated);
    const double area = (high.x - low.x) * (high.y - low.y);
    if (area >= smallestArea) return;
    smallestArea = area;
    const double u = (low.x + high.x) / 2;
    const double v = (low.y + high.y) / 2;
    smallest = {{u * c - v * s, u * s + v * c}, (high.x - low.x) / 2, (high.y - low.y) / 2, yaw};
  });
  return smallest;
}

Polygon cornersOf(const models::Footprint& f) {
  return {f.at(-f.halfX, -f.halfY), f.at(f.halfX, -f.halfY), f.at(f.halfX, f.halfY), f.at(-f.halfX, f.halfY)};
}

Polygon clipped(Polygon ring, double half) {
  for (int side = 0; side < 4; ++side) {
    // Returns the signed distance (m) of a point from the line through this side of the square; positive inside.
    const auto inside = [&](const Point2& p) {
      return (side == 0 ? p.x : side == 1 ? -p.x : side == 2 ? p.y : -p.y) + half;
    };
    Polygon clippedRing;
    forSides(ring, [&](const Point2& a, const Point2& b) {
      const double insideA = inside(a);
      const double insideB = inside(b);
      if (insideA >= 0) clippedRing.push_back(a);
      if ((insideA >= 0) != (insideB >= 0)) {
        clippedRing.push_back(models::lerp(a, b, insideA / (insideA - insideB)));
      }
    });
    ring = std::move(clippedRing);
  }
  return ring;
}

}  // namespace scanmill::town
