#include "assets/worlds/sdf_parts.h"

#include <fmt/format.h>

#include <algorithm>

#include "assets/worlds/solids.h"

namespace scanmill {
namespace {

constexpr std::size_t kLongestChain = 1000;  // of frames, each relative to the next

float fractionIn(const XmlNode& node) {
  return static_cast<float>(std::clamp(numbersIn(node, node.text, 1).front(), 0.0, 1.0));
}

// Returns how the scale of a model's state scales a shape in its own frame: round shapes stay round, as in Gazebo.
Mat3 scaleOf(const XmlNode& shape, const Vec3d& scale) {
  const double across = std::max(scale.x, scale.y);
  if (shape.name == "sphere") return Mat3::scale(Vec3d{1, 1, 1} * std::max(across, scale.z));
  if (shape.name == "cylinder") return Mat3::scale({across, across, scale.z});
  return Mat3::scale(scale);
}

// Returns the file of a <mesh> or a <heightmap>; nullopt if it is missing.
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
  const bool isGazebos = std::all_of(script->children.begin(), script->children.end(), [](const XmlNode& child) {
    return child.name != "uri" || child.text.starts_with("file://media");
  });
  if (!isGazebos || (!part.color && part.texture.empty())) {
    world.leftOut.add("looks by scripts of OGRE (state them by <diffuse> or <pbr>)");
  }
}

// Gives the part the mesh of a <mesh>. Returns false if its file is missing.
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

// Gives the part the surface of an element of <geometry>. Returns false if it has none, or if its file is missing.
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

SdfPose readSdfPose(const XmlNode& of) {
  const XmlNode* const element = of.child("pose");
  if (element == nullptr) return {};
  SdfPose read;
  read.relativeTo = element->attributeOr("relative_to", element->attributeOr("frame", ""));
  if (element->text.empty()) return read;
  const std::string format = element->attributeOr("rotation_format", "euler_rpy");
  if (format == "quat_xyzw") {
    const std::vector<double> n = numbersIn(*element, element->text, 7);
    read.pose = {rotationOf(*element, {n[6], n[3], n[4], n[5]}), {n[0], n[1], n[2]}};
    return read;
  }
  if (format != "euler_rpy") {
    element->fail(fmt::format("has the rotation_format '{}', but it must be euler_rpy or quat_xyzw", format));
  }
  const std::vector<double> n = numbersIn(*element, element->text, 6);
  const double unit = isSdfTrue(element->attributeOr("degrees", "false")) ? kPi / 180 : 1;
  read.pose = {fromYawPitchRoll(n[5] * unit, n[4] * unit, n[3] * unit), {n[0], n[1], n[2]}};
  return read;
}

void SdfFrames::add(const std::string& name, const Frame& frame) {
  const auto known = byName.find(name);
  const bool isLink = known != byName.end() && known->second.node->name == "link";
  if (isLink && frame.node->name == "link") {
    frame.node->fail(fmt::format("has the name '{}', as another link: links need names of their own", name));
  }
  if (!isLink) byName[name] = frame;
}

Pose SdfFrames::resolve(const std::string& name, const XmlNode& from) const {
  std::set<std::pair<const SdfFrames*, std::string>> passed;
  return resolve(name, from, passed);
}

Pose SdfFrames::resolve(const std::string& name, const XmlNode& from,
                        std::set<std::pair<const SdfFrames*, std::string>>& passed) const {
  if (name.empty() || name == "__model__" || name == "__root__" || (isWorld && name == "world")) return {};
  if (!passed.emplace(this, name).second) {
    from.fail(fmt::format("has a pose relative to '{}', which is relative to itself", name));
  }
  if (passed.size() > kLongestChain)
    from.fail(fmt::format("has a pose relative to a chain of more than {} frames", kLongestChain));
  // Files that sdformat 1.7 flattened have frames with colons in their names.
  const std::size_t colons = byName.contains(name) ? std::string::npos : name.find("::");
  const auto found = byName.find(name.substr(0, colons));
  if (found == byName.end() && inPlaceOfMissing) return resolve(*inPlaceOfMissing, from, passed);
  if (found == byName.end()) from.fail(fmt::format("has a pose relative to '{}', but this frame does not exist", name));
  const Frame& frame = found->second;
  const Pose pose = resolve(frame.pose.relativeTo, *frame.node, passed) * frame.pose.pose;
  if (colons == std::string::npos) return pose;
  if (frame.inside == nullptr) from.fail(fmt::format("has a pose relative to '{}', which is not in a model", name));
  return pose * frame.inside->resolve(name.substr(colons + 2), from, passed);
}

std::optional<WorldPart> readSdfVisual(const XmlNode& visual, const SdfLink& link, WorldFile& world) {
  const XmlNode* const geometry = visual.child("geometry");
  if (geometry == nullptr) return std::nullopt;
  const std::string transparency = visual.textOf("transparency", "0");
  if (numbersIn(visual, transparency, 1).front() >= 1) return std::nullopt;  // invisible visuals are not scanned
  WorldPart part;
  part.where = visual.where;
  part.node = link.name + "/" + visual.attributeOr("name", "visual");
  const SdfPose pose = readSdfPose(visual);
  const Pose modelFromFrame =
      pose.relativeTo.empty() ? link.modelFromLink : link.frames.resolve(pose.relativeTo, visual);
  part.thingFromPart = toAffine(modelFromFrame * pose.pose);
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
