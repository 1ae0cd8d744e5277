#pragma once

// Lines and polygons on the ground, in metres.

#include <vector>

#include "models/occupancy.h"

namespace scanmill::town {

using models::Point2;
using Line = std::vector<Point2>;     // two points or more
using Polygon = std::vector<Point2>;  // counter-clockwise, without its first point at the end

double distance(const Point2& a, const Point2& b);

double lengthOf(const Line& line);
Point2 pointAt(const Line& line, double along);  // its end, where it is shorter

// The place of a line that is nearest to a point.
struct Nearest {
  double distance = 1e9;
  double along = 0;  // the line
  Point2 heading;    // of the line there, of unit length
};
Nearest nearestOn(const Line& line, const Point2& p);

// Points on the line about `step` apart, both ends among them.
Line evenLine(const Line& line, double step);
// The same with its corners rounded, as vehicles drive: each point the mean of its neighbours. The ends stay.
Line smoothLine(const Line& line, double step);
// The points that lie in the square about the origin with sides of 2 * half, in runs without a gap.
std::vector<Line> runsWithin(const Line& line, double half);

// Even-odd over all rings.
bool isInside(const std::vector<const Polygon*>& rings, const Point2& p);
double distanceToRings(const std::vector<const Polygon*>& rings, const Point2& p);
// Its corners, and points between them that are at most `step` apart.
std::vector<Point2> pointsAlong(const Polygon& ring, double step);
double sizeOf(const Polygon& ring);  // m^2, negative where it goes round clockwise
// The smallest rectangle about a polygon, one of whose sides lies along one of the polygon's.
models::Footprint rectangleAbout(const Polygon& ring);
// The part of a polygon in a square about the origin: Sutherland and Hodgman, "Reentrant polygon clipping",
// Communications of the ACM 17 (1974). Parts that come apart stay joined along the square's sides.
Polygon clipped(Polygon ring, double half);

}  // namespace scanmill::town
