#include "assets/worlds/solids.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "assets/meshes/asset_parts.h"
#include "assets/meshes/polygon.h"
#include "base/text_scan.h"
#include "config/text.h"
#include "rasters/raster.h"
#include "scene/primitives.h"

namespace scanmill {
namespace {

std::string sizeText(const XmlNode& shape, std::string_view key, std::string_view fallback) {
  if (const std::string* attribute = shape.attribute(key)) return *attribute;
  if (const XmlNode* element = shape.child(key)) return element->text;
  if (fallback.empty()) shape.fail(fmt::format("has no {}", key));
  return std::string(fallback);
}

double positive(const XmlNode& shape, double size) {
  if (!(size > 0)) shape.fail(fmt::format("has the size {:g}, but sizes must be above 0", size));
  return size;
}

double lengthOf(const XmlNode& shape, std::string_view key) {
  return positive(shape, numbersIn(shape, sizeText(shape, key, ""), 1).front());
}

void addPlane(Mesh& mesh, const XmlNode& shape) {
  const std::vector<double> size = numbersIn(shape, sizeText(shape, "size", "1 1"), 2);
  const Vec3d normal = vectorIn(shape, sizeText(shape, "normal", "0 0 1"));
  if (!(length(normal) > 0)) shape.fail("has a normal of zeros");
  const Vec3d z = normalized(normal);
  // The shortest rotation from the z axis to the normal, as in Gazebo.
  const Vec3d x = z.z > -1 + 1e-9 ? Vec3d{1 - z.x * z.x / (1 + z.z), -z.x * z.y / (1 + z.z), -z.x} : Vec3d{-1, 0, 0};
  appendPlane(mesh, 0, {{x, cross(z, x), z}, {}}, positive(shape, size[0]), positive(shape, size[1]));
}

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

bool isImage(const Raster& raster, const std::filesystem::path& file) {
  const std::string suffix = lowerExtension(file);
  return !raster.placed || suffix == ".png" || suffix == ".jpg" || suffix == ".jpeg";
}

// Returns the size of a heightmap (m) whose heights reach from `low` to `high`.
Vec3d sizeOf(const XmlNode& shape, const Raster& raster, bool image, double low, double high) {
  if (shape.child("size") != nullptr) return sizesOf(shape, "size");
  if (image) return {1, 1, 1};
  if (raster.geographic) shape.fail("has no <size>, which a raster in degrees needs");
  const auto& t = raster.transform;
  return {raster.width * std::hypot(t[1], t[4]) * raster.perUnit,
          raster.height * std::hypot(t[2], t[5]) * raster.perUnit, high - low};
}

// Returns the value between a and b at t, 0 to 1. A value that is missing (NaN) does not reach the other's place.
double between(double a, double b, double t) {
  return t == 0 ? a : a + t * (b - a);
}

}  // namespace

Vec3d sizesOf(const XmlNode& shape, std::string_view key) {
  const Vec3d sizes = vectorIn(shape, sizeText(shape, key, ""));
  for (const double size : {sizes.x, sizes.y, sizes.z}) positive(shape, size);
  return sizes;
}

std::optional<Mesh> solidOf(const XmlNode& shape) {
  Mesh mesh;
  if (shape.name == "box") {
    appendBox(mesh, 0, {}, sizesOf(shape, "size"));
  } else if (shape.name == "cylinder") {
    const double radius = lengthOf(shape, "radius");
    appendCylinder(mesh, 0, {}, radius, radius, lengthOf(shape, "length"));
  } else if (shape.name == "cone") {
    appendCylinder(mesh, 0, {}, lengthOf(shape, "radius"), 0, lengthOf(shape, "length"));
  } else if (shape.name == "capsule") {
    appendCapsule(mesh, 0, {}, lengthOf(shape, "radius"), lengthOf(shape, "length"));
  } else if (shape.name == "sphere") {
    appendSphere(mesh, 0, {}, lengthOf(shape, "radius"));
  } else if (shape.name == "ellipsoid") {
    appendSphere(mesh, 0, {Mat3::scale(sizesOf(shape, "radii")), {}}, 1);
  } else if (shape.name == "plane") {
    addPlane(mesh, shape);
  } else {
    return std::nullopt;
  }
  return mesh;
}

Quat rotationOf(const XmlNode& node, const Quat& q) {
  const double norm = std::sqrt(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z);
  if (!(norm > 0)) node.fail("has a quaternion of zeros");
  return {q.w / norm, q.x / norm, q.y / norm, q.z / norm};
}

std::array<float, 4> colorOf(const XmlNode& node, std::string_view text, LeftOut& leftOut) {
  const std::vector<double> n = numbersIn(node, text, wordsOf(text).size() == 3 ? 3 : 4);
  std::array<float, 4> color{0, 0, 0, 1};
  if (*std::max_element(n.begin(), n.end()) > 1) leftOut.add("numbers of colours above 1 (they count as 1)");
  for (std::size_t i = 0; i < n.size(); ++i) color[i] = static_cast<float>(std::clamp(n[i], 0.0, 1.0));
  return color;
}

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

Mesh heightmapOf(const XmlNode& shape, const std::filesystem::path& file) {
  RasterRequest request;
  request.placed = false;
  const Raster raster = readRaster(file, request);
  const bool image = isImage(raster, file);
  const double step = numbersIn(shape, shape.textOf("sampling", "1"), 1).front();
  if (!(step >= 1 && step <= 64 && step == std::floor(step))) {
    shape.fail(fmt::format("has the sampling {:g}, but it must be a whole number from 1 to 64", step));
  }
  if (raster.width < 2 || raster.height < 2) {
    shape.fail(fmt::format("names '{}', which has not two rows and two columns of samples", file.string()));
  }
  if (2 * raster.width * step * raster.height * step > static_cast<double>(kMostTriangles)) {
    shape.fail(fmt::format("has {} x {} samples, {:g} a pixel and direction: lower its <sampling>", raster.width,
                           raster.height, step));
  }
  const int every = static_cast<int>(step);
  const int columns = (raster.width - 1) * every + 1, rows = (raster.height - 1) * every + 1;
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const float value : raster.values) {
    if (!std::isfinite(value)) continue;
    low = std::min(low, double{value});
    high = std::max(high, double{value});
  }
  if (image) low = 0;
  const Vec3d size = sizeOf(shape, raster, image, low, high);
  const Vec3d middle = vectorIn(shape, shape.textOf("pos", "0 0 0"));
  const double scale = high > low ? size.z / (high - low) : 0;
  const auto value = [&](int column, int row) {
    return double{raster.values[static_cast<std::size_t>(row) * static_cast<std::size_t>(raster.width) +
                                static_cast<std::size_t>(column)]};
  };
  Mesh mesh;
  for (int row = 0; row < rows; ++row) {
    const int above = row / every, below = std::min(above + 1, raster.height - 1);
    const double down = static_cast<double>(row % every) / every;
    for (int column = 0; column < columns; ++column) {
      const int left = column / every, right = std::min(left + 1, raster.width - 1);
      const double along = static_cast<double>(column % every) / every;
      const double height = between(between(value(left, above), value(right, above), along),
                                    between(value(left, below), value(right, below), along), down);
      mesh.positions.push_back(
          Vec3f(middle + Vec3d{size.x * (static_cast<double>(column) / (columns - 1) - 0.5),
                               size.y * (0.5 - static_cast<double>(row) / (rows - 1)), (height - low) * scale}));
    }
  }
  const auto index = [&](int column, int row) { return static_cast<std::uint32_t>(row * columns + column); };
  for (int row = 0; row + 1 < rows; ++row) {
    for (int column = 0; column + 1 < columns; ++column) {
      const std::array<std::uint32_t, 4> v{index(column, row), index(column, row + 1), index(column + 1, row + 1),
                                           index(column + 1, row)};
      if (std::any_of(v.begin(), v.end(), [&](std::uint32_t i) { return !isFinite(mesh.positions[i]); })) continue;
      mesh.triangles.push_back({v[0], v[1], v[2]});
      mesh.triangles.push_back({v[0], v[2], v[3]});
    }
  }
  return mesh;
}

}  // namespace scanmill
