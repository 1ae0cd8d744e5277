#pragma once

// Lines and polygons on the ground (m).

#include <vector>

#include "models/occupancy.h"

namespace scanmill::town {

using models::Point2;
using Line = std::vector<Point2>;     // at least two points
using Polygon = std::vector<Point2>;  // counter-clockwise; the first point is not repeated

double distance(const Point2& a, const Point2& b);
// Returns the coordinates of points relative to `origin`.
std::vector<Point2> relativeTo(const Point2& origin, std::vector<Point2> points);

// The bounding box of points.
struct Extent {
  Point2 low, high;
};
Extent extentOf(const std::vector<Point2>& points);  // `points`: at least one

double lengthOf(const Line& line);
Point2 pointAt(const Line& line, double along);        // returns the line's end if `along` exceeds its length
Point2 directionOf(const Point2& a, const Point2& b);  // unit vector from a to b

// The point of a line that is nearest to a given point.
struct Nearest {
  double distance = 1e9;
  double along = 0;  // m along the line
  Point2 heading;    // direction of the line at the nearest point, a unit vector
};
Nearest nearestOn(const Line& line, const Point2& p);

// Returns points on the line about `step` apart, including both ends.
[[nodiscard]] Line evenLine(const Line& line, double step);
// Returns the line's points and further points about `step` apart; omits points less than 2 cm from the previous point.
[[nodiscard]] Line denseLine(const Line& line, double step);
// Returns points on the line about `step` apart, averaged with their neighbours to round corners; end points are kept.
[[nodiscard]] Line smoothLine(const Line& line, double step);
// Returns the runs of successive points that are in the square from -half to half (m) in x and y.
std::vector<Line> runsWithin(const Line& line, double half);

// True if the point is inside the rings by the even-odd rule.
bool isInside(const std::vector<const Polygon*>& rings, const Point2& p);
// Returns the distance (m) between a point and the nearest side of any ring.
double distanceToRings(const std::vector<const Polygon*>& rings, const Point2& p);
// Returns the ring's corners and points between them, at most `step` apart.
std::vector<Point2> pointsAlong(const Polygon& ring, double step);
double areaOf(const Polygon& ring);  // m^2; negative if the ring is clockwise
// Returns the smallest rectangle that contains a polygon and is parallel to one of the polygon's sides.
models::Footprint rectangleAbout(const Polygon& ring);
Polygon cornersOf(const models::Footprint& f);
// Returns the part of a polygon in the square from -half to half (m) in x and y, by Sutherland and Hodgman, "Reentrant
// polygon clipping", Communications of the ACM 17 (1974). Edges along the square's sides connect separate parts.
[[nodiscard]] Polygon clipped(Polygon ring, double half);

}  // namespace scanmill::town
