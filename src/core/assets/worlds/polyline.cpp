#include "assets/worlds/polyline.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "assets/meshes/polygon.h"
#include "scene/primitives.h"

namespace scanmill {
namespace {

using Loop = std::vector<Vec3d>;  // corners of an outline in the plane z = 0, the last one not repeated

// Largest product of the number of corners squared and the number of holes plus one: some seconds of work.
constexpr double kMostSteps = 1e9;

// Returns twice the area of a triangle, which is above 0 if its corners turn counter-clockwise.
double turn(const Vec3d& a, const Vec3d& b, const Vec3d& c) {
  return cross(b - a, c - a).z;
}

double areaOf(const Loop& loop) {
  double area = 0;
  for (std::size_t i = 1; i + 1 < loop.size(); ++i) area += turn(loop[0], loop[i], loop[i + 1]);
  return area;
}

Loop loopOf(const XmlNode& polyline) {
  constexpr double kSame = 1e-4;  // m, distance between points that Gazebo takes for one
  Loop loop;
  for (const XmlNode& point : polyline.children) {
    if (point.name != "point") continue;
    const std::vector<double> n = numbersIn(point, point.text, 2);
    const Vec3d corner{n[0], n[1], 0};
    if (loop.empty() || length(corner - loop.back()) > kSame) loop.push_back(corner);
  }
  while (loop.size() > 1 && length(loop.back() - loop.front()) <= kSame) loop.pop_back();
  if (loop.size() < 3 || areaOf(loop) == 0) polyline.fail("encloses no area: it needs three points that differ");
  return loop;
}

bool contains(const Loop& loop, const Vec3d& p) {
  bool inside = false;
  for (std::size_t i = 0; i < loop.size(); ++i) {
    const Vec3d& a = loop[i];
    const Vec3d& b = loop[(i + 1) % loop.size()];
    if ((a.y > p.y) != (b.y > p.y) && p.x < a.x + (b.x - a.x) * (p.y - a.y) / (b.y - a.y)) inside = !inside;
  }
  return inside;
}

// True if p lies between a and b on the segment from a to b.
bool isBetween(const Vec3d& a, const Vec3d& b, const Vec3d& p) {
  return turn(a, b, p) == 0 && dot(p - a, p - b) < 0;
}

// True if an edge of the loop crosses the segment from a to b, or a corner of the loop lies between them.
bool blocks(const Loop& loop, const Vec3d& a, const Vec3d& b) {
  for (std::size_t i = 0; i < loop.size(); ++i) {
    const Vec3d& c = loop[i];
    const Vec3d& d = loop[(i + 1) % loop.size()];
    if (isBetween(a, b, c)) return true;
    if (turn(a, b, c) * turn(a, b, d) < 0 && turn(c, d, a) * turn(c, d, b) < 0) return true;
  }
  return false;
}

// True if p is seen from corner `at` of a counter-clockwise loop between the two edges there.
bool isInCorner(const Loop& loop, std::size_t at, const Vec3d& p) {
  const Vec3d& corner = loop[at];
  const Vec3d& next = loop[(at + 1) % loop.size()];
  const Vec3d& before = loop[(at + loop.size() - 1) % loop.size()];
  const bool leftOfNext = turn(corner, next, p) > 0, leftOfBefore = turn(before, corner, p) > 0;
  return turn(before, corner, next) > 0 ? leftOfNext && leftOfBefore : leftOfNext || leftOfBefore;
}

// Joins a hole to the outline around it by an edge that the outline passes twice (D. Eberly, "Triangulation by ear
// clipping", 2002). False if no corner of the outline can be seen from the hole's greatest x.
bool join(Loop& outline, const Loop& hole, const std::vector<Loop>& holes) {
  const auto greatest =
      std::max_element(hole.begin(), hole.end(), [](const Vec3d& a, const Vec3d& b) { return a.x < b.x; });
  std::optional<std::size_t> nearest;
  for (std::size_t i = 0; i < outline.size(); ++i) {
    if (nearest && length(outline[i] - *greatest) >= length(outline[*nearest] - *greatest)) continue;
    if (!isInCorner(outline, i, *greatest) || blocks(outline, *greatest, outline[i])) continue;
    if (std::any_of(holes.begin(), holes.end(), [&](const Loop& h) { return blocks(h, *greatest, outline[i]); })) {
      continue;
    }
    nearest = i;
  }
  if (!nearest) return false;
  Loop detour(greatest, hole.end());
  detour.insert(detour.end(), hole.begin(), greatest + 1);
  detour.push_back(outline[*nearest]);
  outline.insert(outline.begin() + static_cast<std::ptrdiff_t>(*nearest) + 1, detour.begin(), detour.end());
  return true;
}

// Adds a flat polygon at height z, which faces up or down.
void addCap(Mesh& mesh, const Loop& outline, const std::vector<std::array<std::uint32_t, 3>>& triangles, double z,
            bool up) {
  for (const auto& t : triangles) {
    const auto first = static_cast<std::uint32_t>(mesh.positions.size());
    for (const std::uint32_t corner : t) {
      mesh.positions.push_back(Vec3f(Vec3d{outline[corner].x, outline[corner].y, z}));
    }
    mesh.triangles.push_back(up ? Triangle{first, first + 1, first + 2} : Triangle{first, first + 2, first + 1});
    mesh.surfaceOf.push_back(0);
  }
}

}  // namespace

Mesh extrudedPolylines(const XmlNode& geometry) {
  const XmlNode& first = *geometry.child("polyline");
  const double height = numbersIn(first, first.textOf("height", "1"), 1).front();
  if (!(height > 0)) first.fail(fmt::format("has the height {:g}, but it must be above 0", height));
  std::vector<Loop> loops;
  double corners = 0;
  for (const XmlNode& child : geometry.children) {
    if (child.name == "polyline") loops.push_back(loopOf(child));
  }
  for (const Loop& loop : loops) corners += static_cast<double>(loop.size());
  if (corners * corners * static_cast<double>(loops.size()) > kMostSteps) {
    first.fail(fmt::format("and those beside it have {} points: give them as a mesh", corners));
  }
  std::vector<std::size_t> depths;  // in how many others each loop lies
  for (Loop& loop : loops) {
    depths.push_back(static_cast<std::size_t>(std::count_if(loops.begin(), loops.end(), [&](const Loop& other) {
      return &other != &loop && contains(other, loop.front());
    })));
    if ((areaOf(loop) > 0) != (depths.back() % 2 == 0)) std::reverse(loop.begin(), loop.end());
  }
  double tests = 0;
  Mesh mesh;
  for (std::size_t i = 0; i < loops.size(); ++i) {
    for (std::size_t k = 0; k < loops[i].size(); ++k) {
      const Vec3d& a = loops[i][k];
      const Vec3d& b = loops[i][(k + 1) % loops[i].size()];
      appendQuad(mesh, 0, a, b, {b.x, b.y, height}, {a.x, a.y, height});
    }
    if (depths[i] % 2 != 0) continue;
    std::vector<Loop> holes;
    for (std::size_t k = 0; k < loops.size(); ++k) {
      if (depths[k] == depths[i] + 1 && contains(loops[i], loops[k].front())) holes.push_back(loops[k]);
    }
    const auto right = [](const Loop& loop) {
      return std::max_element(loop.begin(), loop.end(), [](const Vec3d& a, const Vec3d& b) { return a.x < b.x; })->x;
    };
    std::sort(holes.begin(), holes.end(), [&](const Loop& a, const Loop& b) { return right(a) > right(b); });
    Loop outline = loops[i];
    for (const Loop& hole : holes) {
      if (!join(outline, hole, holes)) first.fail("and those beside it intersect or touch each other");
    }
    std::vector<std::array<std::uint32_t, 3>> triangles;
    if (!triangulate(outline, triangles, tests)) first.fail("would take minutes to divide into triangles: give a mesh");
    addCap(mesh, outline, triangles, height, true);
    addCap(mesh, outline, triangles, 0, false);
  }
  return mesh;
}

}  // namespace scanmill
