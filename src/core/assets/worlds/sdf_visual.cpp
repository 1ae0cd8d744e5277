#include <fmt/format.h>

#include <algorithm>

#include "assets/worlds/named_files.h"
#include "assets/worlds/sdf_parts.h"
#include "assets/worlds/solids.h"

namespace scanmill {
namespace {

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

// Returns the image of a heightmap; nullopt if it is missing.
std::optional<std::filesystem::path> imageOf(const XmlNode& heightmap, const std::filesystem::path& file,
                                             WorldFile& world) {
  const XmlNode* const uri = heightmap.child("uri");
  if (uri == nullptr) heightmap.fail("has no <uri>");
  try {
    return findModel(*uri, file, uri->text);
  } catch (const MissingFileError& e) {
    if (uri->text.starts_with("file://media")) {
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
  const XmlNode* const uri = shape.child("uri");
  if (uri == nullptr) shape.fail("has no <uri>");
  MeshFile mesh;
  try {
    mesh.path = findModel(*uri, file, uri->text);
  } catch (const MissingFileError& e) {
    world.missing.push_back(e);
    return false;
  }
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
    if (const auto image = imageOf(shape, file, world)) solid = heightmapOf(shape, *image);
  } else {
    solid = solidOf(shape);
  }
  if (solid) part.shape = std::move(*solid);
  return solid.has_value();
}

}  // namespace

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
