#include "assets/worlds/sdf_parts.h"

#include <fmt/format.h>

#include <algorithm>

#include "assets/worlds/solids.h"

namespace scanmill {
namespace {

constexpr std::size_t kLongestChain = 1000;  // largest number of frames, each relative to the next

// Returns the number in an element, clamped to 0 to 1.
float fractionIn(const XmlNode& node) {
  return static_cast<float>(std::clamp(numbersIn(node, node.text, 1).front(), 0.0, 1.0));
}

// Returns a shape's scale if the world's state scales its model by `scale`. Round shapes stay round, as in Gazebo.
Mat3 scaleOf(const XmlNode& shape, const Vec3d& scale) {
  const double across = std::max(scale.x, scale.y);
  if (shape.name == "sphere") return Mat3::scale(Vec3d{1, 1, 1} * std::max(across, scale.z));
  if (shape.name == "cylinder") return Mat3::scale({across, across, scale.z});
  return Mat3::scale(scale);
}

// Returns the file of a <mesh> or a <heightmap>. If it is missing, adds its name to `world` and returns nullopt.
std::optional<std::filesystem::path> fileOf(const XmlNode& shape, const std::filesystem::path& file, WorldFile& world) {
  const XmlNode* const uri = shape.child("uri");
  if (uri == nullptr) shape.fail("has no <uri>");
  try {
    return findModel(*uri, file, uri->text);
  } catch (const MissingFileError& e) {
    if (shape.name == "heightmap" && uri->text.starts_with("file://media")) {
      world.leftOut.add(fmt::format("heightmaps of Gazebo's own '{}'", uri->text));
    } else {
      world.missing.push_back(e);
    }
    return std::nullopt;
  }
}

// Reads the image, roughness and metalness of a physically based material.
void readAlbedo(const XmlNode& material, const std::filesystem::path& file, LeftOut& leftOut, WorldPart& part) {
  const XmlNode* const pbr = material.child("pbr");
  if (pbr == nullptr) return;
  for (const XmlNode& kind : pbr->children) {
    if (const XmlNode* r = kind.child("roughness")) part.roughness = fractionIn(*r);
    if (const XmlNode* m = kind.child("metalness")) part.metallic = fractionIn(*m);
    const XmlNode* const map = kind.child("albedo_map");
    if (map == nullptr || map->text.empty()) continue;
    try {
      part.texture = findModel(*map, file, map->text);
    } catch (const InputError&) {
      leftOut.add(fmt::format("missing images '{}' (albedo_map)", map->text));
    }
    return;
  }
}

// Reads the <material> of a visual into its part. `file`: the model's file.
void readLook(const XmlNode& visual, const std::filesystem::path& file, WorldFile& world, WorldPart& part) {
  const XmlNode* const material = visual.child("material");
  if (material == nullptr) return;
  const XmlNode* const diffuse = material->child("diffuse");
  if (diffuse != nullptr) {
    const auto [r, g, b, alpha] = colorOf(*diffuse, diffuse->text, world.leftOut);
    part.color = {r, g, b};
    if (alpha < 1) world.leftOut.add("alphas of diffuse colours (these visuals are solid)");
  }
  readAlbedo(*material, file, world.leftOut, part);
  const XmlNode* const script = material->child("script");
  if (script == nullptr) return;
  part.material = script->textOf("name", "");
  // Scripts at file://media are Gazebo's own, such as Gazebo/Grey.
  const bool isOfGazebo = std::ranges::all_of(script->children, [](const XmlNode& child) {
    return child.name != "uri" || child.text.starts_with("file://media");
  });
  if (!isOfGazebo || (!part.color && part.texture.empty())) {
    world.leftOut.add("looks by scripts of OGRE (state them by <diffuse> or <pbr>)");
  }
}

// Sets the shape of the part to the mesh that a <mesh> names. Returns false if the mesh's file is missing.
bool readMesh(const XmlNode& shape, const std::filesystem::path& file, WorldFile& world, WorldPart& part) {
  const std::optional<std::filesystem::path> path = fileOf(shape, file, world);
  if (!path) return false;
  MeshFile mesh{*path};
  if (const XmlNode* scale = shape.child("scale")) {
    part.thingFromPart.linear = part.thingFromPart.linear * Mat3::scale(vectorIn(*scale, scale->text));
  }
  if (const XmlNode* submesh = shape.child("submesh")) {
    mesh.submesh = submesh->textOf("name", "");
    mesh.centred = isSdfTrue(submesh->textOf("center", "false"));
  }
  part.shape = std::move(mesh);
  return true;
}

// Sets the part's shape from an element of <geometry>. Returns false if it is no surface or its file is missing.
bool readShape(const XmlNode& geometry, const XmlNode& shape, const std::filesystem::path& file, WorldFile& world,
               WorldPart& part) {
  if (shape.name == "mesh") return readMesh(shape, file, world, part);
  std::optional<Mesh> solid;
  if (shape.name == "polyline") {
    solid = extrudedPolylines(geometry);
  } else if (shape.name == "heightmap") {
    if (const auto image = fileOf(shape, file, world)) solid = heightmapOf(shape, *image);
  } else {
    solid = solidOf(shape);
  }
  if (solid) part.shape = std::move(*solid);
  return solid.has_value();
}

}  // namespace

bool isSdfTrue(const std::string& text) {
  return text == "true" || text == "True" || text == "TRUE" || text == "1";
}

SdfPose readSdfPose(const XmlNode& owner) {
  const XmlNode* const element = owner.child("pose");
  if (element == nullptr) return {};
  SdfPose read{{}, element->attributeOr("relative_to", element->attributeOr("frame", ""))};
  if (element->text.empty()) return read;
  const std::string format = element->attributeOr("rotation_format", "euler_rpy");
  const bool isQuaternion = format == "quat_xyzw";
  if (!isQuaternion && format != "euler_rpy") {
    element->fail("has the rotation_format '{}', but it must be euler_rpy or quat_xyzw", format);
  }
  // The numbers are the position, then the quaternion x, y, z, w or roll, pitch and yaw.
  const std::vector<double> n = numbersIn(*element, element->text, isQuaternion ? 7 : 6);
  const double unit = isSdfTrue(element->attributeOr("degrees", "false")) ? kPi / 180 : 1;
  read.pose.translation = {n[0], n[1], n[2]};
  read.pose.rotation = isQuaternion ? rotationOf(*element, {n[6], n[3], n[4], n[5]})
                                    : fromYawPitchRoll(n[5] * unit, n[4] * unit, n[3] * unit);
  return read;
}

void SdfFrames::add(const std::string& name, const Frame& frame) {
  const auto earlier = byName.find(name);
  const bool isNameOfLink = earlier != byName.end() && earlier->second.node->name == "link";
  if (isNameOfLink && frame.node->name == "link") {
    frame.node->fail("has the name '{}', as another link: links need names of their own", name);
  }
  if (!isNameOfLink) byName[name] = frame;
}

Pose SdfFrames::resolve(const std::string& name, const XmlNode& from) const {
  std::set<std::pair<const SdfFrames*, std::string>> visited;
  return resolve(name, from, visited);
}

Pose SdfFrames::resolve(const std::string& name, const XmlNode& from,
                        std::set<std::pair<const SdfFrames*, std::string>>& visited) const {
  if (name.empty() || name == "__model__" || name == "__root__" || (isWorld && name == "world")) return {};
  if (!visited.emplace(this, name).second) from.fail("has a pose relative to '{}', which is relative to itself", name);
  if (visited.size() > kLongestChain) from.fail("has a pose relative to a chain of more than {} frames", kLongestChain);
  // Files that sdformat 1.7 flattened have colons in the names of frames.
  const std::size_t colons = byName.contains(name) ? std::string::npos : name.find("::");
  const auto found = byName.find(name.substr(0, colons));
  if (found == byName.end() && substitute) return resolve(*substitute, from, visited);
  if (found == byName.end()) from.fail("has a pose relative to '{}', but this frame does not exist", name);
  const Frame& frame = found->second;
  const Pose pose = resolve(frame.pose.relativeTo, *frame.node, visited) * frame.pose.pose;
  if (colons == std::string::npos) return pose;
  if (frame.inside == nullptr) from.fail("has a pose relative to '{}', which is not in a model", name);
  return pose * frame.inside->resolve(name.substr(colons + 2), from, visited);
}

std::optional<WorldPart> readSdfVisual(const XmlNode& visual, const SdfLink& link, WorldFile& world) {
  const XmlNode* const geometry = visual.child("geometry");
  if (geometry == nullptr) return std::nullopt;
  const std::string transparency = visual.textOf("transparency", "0");
  if (numbersIn(visual, transparency, 1).front() >= 1) return std::nullopt;  // invisible visuals are not scanned
  const auto [pose, relativeTo] = readSdfPose(visual);
  const Pose modelFromFrame = relativeTo.empty() ? link.modelFromLink : link.frames.resolve(relativeTo, visual);
  WorldPart part{.node = link.name + "/" + visual.attributeOr("name", "visual"),
                 .thingFromPart = toAffine(modelFromFrame * pose),
                 .where = visual.where};
  for (const XmlNode& shape : geometry->children) {
    if (!readShape(*geometry, shape, link.file, world, part)) {
      if (shape.name == "mesh" || shape.name == "heightmap") return std::nullopt;
      continue;
    }
    if (link.scale != Vec3d{1, 1, 1}) {
      part.thingFromPart.linear = part.thingFromPart.linear * scaleOf(shape, link.scale);
    }
    readLook(visual, link.file, world, part);
    return part;
  }
  return std::nullopt;
}

}  // namespace scanmill
