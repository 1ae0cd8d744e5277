#include "assets/worlds/solids.h"

#include <algorithm>
#include <boost/polygon/polygon.hpp>
#include <cmath>
#include <cstdint>
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

// Returns the text of an attribute (URDF) or an element (SDF). Throws InputError if both are absent and there is no
// fallback.
std::string sizeText(const XmlNode& shape, std::string_view key, std::string_view fallback) {
  if (const std::string* attribute = shape.attribute(key)) return *attribute;
  if (const XmlNode* element = shape.child(key)) return element->text;
  if (fallback.empty()) shape.fail("has no {}", key);
  return std::string(fallback);
}

// Returns `size`. Throws InputError unless `size` is above 0.
double positive(const XmlNode& shape, double size) {
  if (!(size > 0)) shape.fail("has the size {:g}, but sizes must be above 0", size);
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
  // `x` is the x axis after the shortest rotation of the z axis to the normal, as in Gazebo.
  constexpr double kRounding = 1e-9;
  const Vec3d x =
      z.z > -1 + kRounding ? Vec3d{1 - z.x * z.x / (1 + z.z), -z.x * z.y / (1 + z.z), -z.x} : Vec3d{-1, 0, 0};
  appendPlane(mesh, 0, {{x, cross(z, x), z}, {}}, positive(shape, size[0]), positive(shape, size[1]));
}

namespace gtl = boost::polygon;
using Outline = gtl::polygon_data<int>;  // in units of kOutlineStep
constexpr double kOutlineStep = 1e-4;    // m, within which Gazebo takes two points for one

// Returns the outline of a <polyline>. Throws InputError if it has no area or is too large for integers.
Outline outlineOf(const XmlNode& polyline) {
  constexpr double kFarthest = 1e5;  // m
  std::vector<gtl::point_data<int>> corners;
  for (const XmlNode& point : polyline.children) {
    if (point.name != "point") continue;
    const std::vector<double> n = numbersIn(point, point.text, 2);
    if (std::max(std::abs(n[0]), std::abs(n[1])) > kFarthest) point.fail("lies more than 100 km away");
    corners.emplace_back(static_cast<int>(std::lround(n[0] / kOutlineStep)),
                         static_cast<int>(std::lround(n[1] / kOutlineStep)));
  }
  Outline outline;
  outline.set(corners.begin(), corners.end());
  if (gtl::area(outline) == 0) polyline.fail("encloses no area: it needs three points that differ");
  return outline;
}

// Returns the corners of an outline (m, z = 0): counter-clockwise if `counterClockwise`, else clockwise.
template <class Polygon>
std::vector<Vec3d> cornersOf(const Polygon& outline, bool counterClockwise) {
  std::vector<Vec3d> corners;
  for (const auto& p : outline) corners.push_back({p.x() * kOutlineStep, p.y() * kOutlineStep, 0});
  if (corners.front() == corners.back()) corners.pop_back();
  if ((gtl::winding(outline) == gtl::COUNTERCLOCKWISE) != counterClockwise)
    std::reverse(corners.begin(), corners.end());
  return corners;
}

// Adds a wall from z = 0 to z = `height` on each edge of an outline. The walls face outwards if the corners are
// counter-clockwise.
void addWalls(Mesh& mesh, const std::vector<Vec3d>& corners, double height) {
  for (std::size_t k = 0; k < corners.size(); ++k) {
    const Vec3d& a = corners[k];
    const Vec3d& b = corners[(k + 1) % corners.size()];
    appendQuad(mesh, 0, a, b, {b.x, b.y, height}, {a.x, a.y, height});
  }
}

// Adds a flat polygon at the height z (m): a floor, which faces down, if z is 0, else a ceiling, which faces up. The
// triangles must be counter-clockwise.
void addCap(Mesh& mesh, const std::vector<Vec3d>& outline, const std::vector<std::array<std::uint32_t, 3>>& triangles,
            double z) {
  for (const auto& triangle : triangles) {
    const auto first = static_cast<std::uint32_t>(mesh.positions.size());
    for (const std::uint32_t corner : triangle) {
      mesh.positions.push_back(Vec3f(Vec3d{outline[corner].x, outline[corner].y, z}));
    }
    mesh.triangles.push_back(z > 0 ? Triangle{first, first + 1, first + 2} : Triangle{first, first + 2, first + 1});
    mesh.surfaceOf.push_back(0);
  }
}

// Returns the size of a heightmap (m): its <size> or, without one, 1 m for an image, else the raster's extent.
Vec3d sizeOf(const XmlNode& shape, const Raster& raster, bool isImage, double low, double high) {
  if (shape.child("size") != nullptr) return sizesOf(shape, "size");
  if (isImage) return {1, 1, 1};
  if (raster.system.geographic) shape.fail("has no <size>, which a raster in degrees needs");
  const auto& t = raster.transform;
  return {raster.width * std::hypot(t[1], t[4]) * raster.system.perUnit,
          raster.height * std::hypot(t[2], t[5]) * raster.system.perUnit, high - low};
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
  if (!(height > 0)) first.fail("has the height {:g}, but it must be above 0", height);
  gtl::polygon_set_data<int> covered;
  double corners = 0;
  for (const XmlNode& child : geometry.children) {
    if (child.name != "polyline") continue;
    const Outline outline = outlineOf(child);
    corners += static_cast<double>(outline.size());
    gtl::operators::operator^=(covered, outline);
  }
  constexpr double kMostCorners = 20'000;  // this many take some seconds to process
  if (corners > kMostCorners) first.fail("and those beside it have {} points: give them as a mesh", corners);
  Mesh mesh;
  std::vector<gtl::polygon_with_holes_data<int>> walls;
  covered.get(walls);
  for (const auto& outline : walls) {
    addWalls(mesh, cornersOf(outline, true), height);
    for (auto hole = outline.begin_holes(); hole != outline.end_holes(); ++hole) {
      addWalls(mesh, cornersOf(*hole, false), height);
    }
  }
  std::vector<Outline> caps;  // cut open where they have holes
  covered.get(caps);
  Triangulator polygons(first.where);
  for (const Outline& cap : caps) {
    const std::vector<Vec3d> outline = cornersOf(cap, true);
    const auto& triangles = polygons.divide(outline.size(), [&](std::size_t i) { return outline[i]; });
    addCap(mesh, outline, triangles, height);
    addCap(mesh, outline, triangles, 0);
  }
  return mesh;
}

Mesh heightmapOf(const XmlNode& shape, const std::filesystem::path& file) {
  const Raster raster = readRaster(file, {.georeferenced = false});
  // The values of a plain image are not heights in metres.
  const bool isImage = !raster.georeferenced || containsWord(".png .jpg .jpeg", lowerExtension(file));
  if (raster.width < 2 || raster.height < 2) {
    shape.fail("names '{}', which has not two rows and two columns of samples", file.string());
  }
  auto [low, high] = raster.range();
  if (isImage) low = 0;
  const Vec3d size = sizeOf(shape, raster, isImage, low, high);
  const Vec3d middle = vectorIn(shape, shape.textOf("pos", "0 0 0"));
  const double scale = high > low ? size.z / (high - low) : 0;
  Mesh mesh;
  for (int row = 0; row < raster.height; ++row) {
    for (int column = 0; column < raster.width; ++column) {
      const double value = double{raster.values[mesh.positions.size()]};
      const double x = size.x * (static_cast<double>(column) / (raster.width - 1) - 0.5);
      const double y = size.y * (0.5 - static_cast<double>(row) / (raster.height - 1));
      mesh.positions.push_back(Vec3f(middle + Vec3d{x, y, (value - low) * scale}));
    }
  }
  const auto index = [&](int column, int row) { return static_cast<std::uint32_t>(row * raster.width + column); };
  for (int row = 0; row + 1 < raster.height; ++row) {
    for (int column = 0; column + 1 < raster.width; ++column) {
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
