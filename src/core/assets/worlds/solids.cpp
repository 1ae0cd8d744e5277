#include "assets/worlds/solids.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <sstream>
#include <string>

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
  std::istringstream words{std::string(text)};
  const auto count = std::distance(std::istream_iterator<std::string>(words), {});
  const std::vector<double> n = numbersIn(node, text, count == 3 ? 3 : 4);
  std::array<float, 4> color{0, 0, 0, 1};
  if (*std::max_element(n.begin(), n.end()) > 1) leftOut.add("numbers of colours above 1 (they count as 1)");
  for (std::size_t i = 0; i < n.size(); ++i) color[i] = static_cast<float>(std::clamp(n[i], 0.0, 1.0));
  return color;
}

}  // namespace scanmill
