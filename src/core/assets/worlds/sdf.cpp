#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <sstream>

#include "assets/worlds/model_search.h"
#include "assets/worlds/ogre_material.h"
#include "assets/worlds/solids.h"
#include "assets/worlds/world.h"
#include "assets/worlds/xml.h"
#include "base/append_new.h"
#include "scene/primitives.h"

namespace scanmill {
namespace {

constexpr int kDeepestModel = 24;       // largest depth of nested models
constexpr std::size_t kLongest = 1000;  // longest chain of frames, each relative to the next

// The named frames of a world or a model, to which poses may be relative.
struct Scope {
  struct Frame {
    const XmlNode* node = nullptr;
    Pose pose;
    std::string relativeTo;               // name of the frame that `pose` refers to; empty: the scope's own frame
    std::shared_ptr<const Scope> inside;  // frames inside a model; null: this frame is not a model
  };
  std::map<std::string, Frame> frames;

  // Returns the pose of a frame in the scope's own frame (that of the world or model). Errors are thrown at `from`.
  Pose resolve(const std::string& name, const XmlNode& from) const {
    std::set<std::pair<const Scope*, std::string>> been;
    return resolve(name, from, been);
  }

 private:
  Pose resolve(const std::string& name, const XmlNode& from,
               std::set<std::pair<const Scope*, std::string>>& been) const {
    if (name.empty() || name == "__model__" || name == "world" || name == "__root__") return {};
    if (!been.emplace(this, name).second) {
      from.fail(fmt::format("has a pose relative to '{}', which is relative to itself", name));
    }
    if (been.size() > kLongest)
      from.fail(fmt::format("has a pose relative to a chain of more than {} frames", kLongest));
    const std::size_t colons = name.find("::");
    const auto found = frames.find(name.substr(0, colons));
    if (found == frames.end())
      from.fail(fmt::format("has a pose relative to '{}', but this frame does not exist", name));
    const Frame& frame = found->second;
    const Pose own = resolve(frame.relativeTo, *frame.node, been) * frame.pose;
    if (colons == std::string::npos) return own;
    if (frame.inside == nullptr) from.fail(fmt::format("has a pose relative to '{}', which is not in a model", name));
    return own * frame.inside->resolve(name.substr(colons + 2), from, been);
  }
};

struct PlacedModel;

struct Model {
  std::string name;
  std::filesystem::path definition;
  std::vector<WorldPart> parts;  // in the model's frame
  std::vector<PlacedModel> children;
  Pose placement;  // pose of the placement frame in the model's frame
};

struct PlacedModel {
  Pose pose;
  Model model;
};

struct PoseElement {
  Pose pose;
  std::string relativeTo;
};

PoseElement readPose(const XmlNode& of) {
  const XmlNode* const element = of.child("pose");
  if (element == nullptr) return {};
  PoseElement read;
  read.relativeTo = element->attributeOr("relative_to", element->attributeOr("frame", ""));
  if (element->text.empty()) return read;
  if (element->attributeOr("rotation_format", "euler_rpy") == "quat_xyzw") {
    const std::vector<double> n = numbersIn(*element, element->text, 7);
    const double norm = std::sqrt(n[3] * n[3] + n[4] * n[4] + n[5] * n[5] + n[6] * n[6]);
    if (!(norm > 0)) element->fail("has a quaternion of zeros");
    read.pose = {{n[6] / norm, n[3] / norm, n[4] / norm, n[5] / norm}, {n[0], n[1], n[2]}};
    return read;
  }
  const std::vector<double> n = numbersIn(*element, element->text, 6);
  const double unit = element->attributeOr("degrees", "false") == "true" ? kPi / 180 : 1;
  read.pose = {fromYawPitchRoll(n[5] * unit, n[4] * unit, n[3] * unit), {n[0], n[1], n[2]}};
  return read;
}

class SdfReader {
 public:
  World read(const std::filesystem::path& file) {
    const XmlNode root = readXml(file);
    if (root.name != "sdf" && root.name != "gazebo") root.fail("is not an SDF: its first element must be <sdf>");
    std::vector<PlacedModel> models;
    bool any = false;
    for (const XmlNode& child : root.children) {
      if (child.name != "world" && child.name != "model" && child.name != "include") continue;
      any = true;
      XmlNode alone;
      alone.where = child.where;
      alone.children = {child};
      for (auto& placed : modelsOf(child.name == "world" ? child : alone, file, 0).first) {
        models.push_back(std::move(placed));
      }
    }
    if (!any) root.fail("has neither a world nor a model");
    for (const auto& [pose, model] : models) addThings(toAffine(pose), model);
    return std::move(world_);
  }

 private:
  using Placed = std::vector<PlacedModel>;

  // Returns the models of a world, or the models nested in a model, and the frames to which their poses may be
  // relative.
  std::pair<Placed, std::shared_ptr<Scope>> modelsOf(const XmlNode& of, const std::filesystem::path& file, int depth) {
    if (depth > kDeepestModel)
      of.fail(fmt::format("is nested in more than {} models: does one include itself?", kDeepestModel));
    auto scope = std::make_shared<Scope>();
    struct Found {
      PoseElement pose;
      Model model;
      const XmlNode* node;
    };
    std::vector<Found> found;
    for (const XmlNode& child : of.children) {
      if (child.name == "model" || child.name == "include") {
        PoseElement pose;
        std::shared_ptr<const Scope> inside;
        std::optional<Model> model = child.name == "model" ? readModel(child, file, depth + 1, pose, inside)
                                                           : readInclude(child, file, depth + 1, pose, inside);
        if (!model) continue;
        pose.pose = pose.pose * inverse(model->placement);
        scope->frames[model->name] = {&child, pose.pose, pose.relativeTo, inside};
        if (child.attributeOr("merge", "false") == "true" && inside != nullptr) {
          for (const auto& [name, frame] : inside->frames) {
            Scope::Frame merged = frame;
            if (merged.relativeTo.empty()) merged.relativeTo = model->name;
            scope->frames.try_emplace(name, std::move(merged));
          }
        }
        found.push_back({pose, std::move(*model), &child});
      } else if (child.name == "frame" || child.name == "link" || child.name == "joint") {
        const PoseElement pose = readPose(child);
        std::string relativeTo = pose.relativeTo;
        if (relativeTo.empty() && child.name == "frame") relativeTo = child.attributeOr("attached_to", "");
        if (relativeTo.empty() && child.name == "joint") relativeTo = child.textOf("child", "");
        scope->frames[child.attributeOr("name", child.name)] = {&child, pose.pose, relativeTo, nullptr};
      } else if (child.name == "actor" || child.name == "population" || child.name == "road") {
        leftOut(child.name);
      }
    }
    Placed placed;
    for (Found& f : found) {
      placed.push_back({scope->resolve(f.pose.relativeTo, *f.node) * f.pose.pose, std::move(f.model)});
    }
    return {std::move(placed), scope};
  }

  Model readModel(const XmlNode& node, const std::filesystem::path& file, int depth, PoseElement& pose,
                  std::shared_ptr<const Scope>& inside) {
    Model model;
    model.name = node.attributeOr("name", "model");
    pose = readPose(node);
    auto [children, scope] = modelsOf(node, file, depth);
    model.children = std::move(children);
    for (const XmlNode& link : node.children) {
      if (link.name != "link") continue;
      const std::string name = link.attributeOr("name", "link");
      const Pose modelFromLink = scope->resolve(name, link);
      for (const XmlNode& visual : link.children) {
        if (visual.name == "visual") addVisual(visual, name, modelFromLink, *scope, file, model.parts);
      }
    }
    if (const std::string* frame = node.attribute("placement_frame")) model.placement = scope->resolve(*frame, node);
    inside = scope;
    return model;
  }

  std::optional<Model> readInclude(const XmlNode& node, const std::filesystem::path& file, int depth, PoseElement& pose,
                                   std::shared_ptr<const Scope>& inside) {
    const std::string uri = node.textOf("uri", "");
    std::string plain = uri;
    while (plain.ends_with('/') && !plain.ends_with("//")) plain.pop_back();
    const std::string name = std::filesystem::path(plain).filename().string();
    std::optional<std::filesystem::path> definition;
    try {
      definition = definitionOf(node, file, plain);
    } catch (const InputError&) {                       // models that belong to Gazebo may not be installed
      if (plain == "model://sun") return std::nullopt;  // sun is a light
      if (plain != "model://ground_plane") throw;
    }
    Model model;
    if (!definition) {
      model = groundPlane(node);
    } else {
      const auto [known, isNew] = definitions_.try_emplace(*definition);
      if (isNew) known->second = readXml(*definition);
      const XmlNode& root = known->second;
      const XmlNode* const child = root.child("model");
      if (child == nullptr) {
        if (root.child("actor") != nullptr) leftOut("actor");
        if (root.child("light") != nullptr || root.child("actor") != nullptr) return std::nullopt;
        root.fail(fmt::format("has no model, but {} includes it", node.where.text()));
      }
      model = readModel(*child, *definition, depth, pose, inside);
      model.definition = *definition;
      model.name = node.textOf("name", plain.ends_with(".sdf") ? child->attributeOr("name", name) : name);
      if (const XmlNode* frame = node.child("placement_frame")) model.placement = inside->resolve(frame->text, node);
    }
    if (node.child("pose") != nullptr) pose = readPose(node);
    return model;
  }

  // Returns the parts of a version as numbers, so that "1.10" compares greater than "1.9".
  static std::vector<int> versionOf(const XmlNode& sdf) {
    std::vector<int> parts;
    std::istringstream text(sdf.attributeOr("version", "0"));
    for (std::string part; std::getline(text, part, '.');) {
      parts.push_back(static_cast<int>(numbersIn(sdf, part, 1).front()));
    }
    return parts;
  }

  // Returns the file that defines a model. If `uri` is a folder, this is the file with the highest version in
  // model.config, or else model.sdf.
  static std::filesystem::path definitionOf(const XmlNode& node, const std::filesystem::path& file,
                                            const std::string& uri) {
    const XmlNode* const named = node.child("uri");
    const XmlNode& place = named == nullptr ? node : *named;
    std::filesystem::path found = findModel(place, file, uri);
    std::error_code ignored;
    if (std::filesystem::is_directory(found, ignored)) {
      std::string best = "model.sdf";
      std::vector<int> highest;
      const std::filesystem::path config = found / "model.config";
      if (std::filesystem::exists(config, ignored)) {
        for (const XmlNode& sdf : readXml(config).children) {
          if (sdf.name != "sdf") continue;
          const std::vector<int> version = versionOf(sdf);
          if (version <= highest || !std::filesystem::exists(found / sdf.text, ignored)) continue;
          highest = version;
          best = sdf.text;
        }
      }
      found /= best;
      if (!std::filesystem::exists(found, ignored)) {
        place.fail(fmt::format("names '{}', but no {} of this name exists", uri, found.string()));
      }
    }
    const std::filesystem::path canonical = std::filesystem::weakly_canonical(found, ignored);
    return ignored ? found : canonical;
  }

  static Model groundPlane(const XmlNode& node) {
    constexpr double kSize = 100;  // m, side of the square plane, as in Gazebo's model ground_plane
    Model model;
    model.name = "ground_plane";
    WorldPart part;
    part.node = "link/visual";
    part.where = node.where;
    part.solid.emplace();
    appendPlane(*part.solid, 0, {}, kSize, kSize);
    model.parts.push_back(std::move(part));
    return model;
  }

  void addVisual(const XmlNode& visual, const std::string& link, const Pose& modelFromLink, const Scope& scope,
                 const std::filesystem::path& file, std::vector<WorldPart>& parts) {
    const XmlNode* const geometry = visual.child("geometry");
    if (geometry == nullptr) return;
    const std::string transparency = visual.textOf("transparency", "0");
    if (numbersIn(visual, transparency, 1).front() >= 1) return;  // invisible visuals are not scanned
    WorldPart part;
    part.where = visual.where;
    part.node = link + "/" + visual.attributeOr("name", "visual");
    const PoseElement pose = readPose(visual);
    const Pose modelFromVisual =
        pose.relativeTo.empty() ? modelFromLink * pose.pose : scope.resolve(pose.relativeTo, visual) * pose.pose;
    part.thingFromPart = toAffine(modelFromVisual);
    for (const XmlNode& shape : geometry->children) {
      if (shape.name == "mesh") {
        const XmlNode* const uri = shape.child("uri");
        if (uri == nullptr) shape.fail("has no <uri>");
        part.mesh = findModel(*uri, file, uri->text);
        if (const XmlNode* scale = shape.child("scale")) {
          part.thingFromPart.linear = part.thingFromPart.linear * Mat3::scale(vectorIn(*scale, scale->text));
        }
        if (const XmlNode* submesh = shape.child("submesh")) {
          part.submesh = submesh->textOf("name", "");
          const std::string centre = submesh->textOf("center", "false");
          part.centred = centre == "true" || centre == "1";
        }
      } else if (shape.name == "empty") {
        return;
      } else {
        part.solid = solidOf(shape);
        if (!part.solid) return leftOut(shape.name);
      }
      readLook(visual, file, part);
      parts.push_back(std::move(part));
      return;
    }
  }

  void readLook(const XmlNode& visual, const std::filesystem::path& file, WorldPart& part) {
    const XmlNode* const material = visual.child("material");
    if (material == nullptr) return;
    const XmlNode* const diffuse = material->child("diffuse");
    if (diffuse != nullptr) part.color = colorOf(*diffuse, diffuse->text);
    readAlbedo(*material, file, part);
    const XmlNode* const script = material->child("script");
    if (script == nullptr) return;
    part.material = script->textOf("name", "");
    // The <uri>s of the script name folders of scripts and images. URIs that begin with file://media refer to Gazebo's
    // own materials, such as Gazebo/Grey, and are skipped.
    std::vector<std::filesystem::path> places;
    for (const XmlNode& uri : script->children) {
      if (uri.name != "uri" || uri.text.starts_with("file://media")) continue;
      try {
        places.push_back(findModel(uri, file, uri.text));
      } catch (const InputError&) {
        continue;  // the file may come from a machine with other models
      }
    }
    for (const std::filesystem::path& place : places) {
      const auto [known, isNew] = looks_.try_emplace(place);
      if (isNew) known->second = readOgreMaterials(place);
      const auto look = known->second.find(part.material);
      if (look == known->second.end()) continue;
      if (look->second.color) part.color = look->second.color;
      if (look->second.texture.empty()) return;
      part.alphaCutoff = look->second.alphaCutoff;
      std::error_code ignored;
      for (const std::filesystem::path& folder : places) {
        const std::filesystem::path image = folder / look->second.texture;
        if (!std::filesystem::is_regular_file(image, ignored)) continue;
        part.texture = image;
        return;
      }
      return leftOut(fmt::format("the missing image '{}' of the material '{}'", look->second.texture, part.material));
    }
  }

  // Reads the image of a physically based material.
  void readAlbedo(const XmlNode& material, const std::filesystem::path& file, WorldPart& part) {
    const XmlNode* const pbr = material.child("pbr");
    if (pbr == nullptr) return;
    for (const XmlNode& kind : pbr->children) {
      const XmlNode* const map = kind.child("albedo_map");
      if (map == nullptr || map->text.empty()) continue;
      try {
        part.texture = findModel(*map, file, map->text);
      } catch (const InputError&) {
        leftOut(fmt::format("the missing albedo_map '{}'", map->text));
      }
      return;
    }
  }

  // Adds the things of a model. A model without visuals is not a thing, but the models nested in it are.
  void addThings(const Affine& worldFromModel, const Model& model) {
    if (model.parts.empty()) {
      for (const auto& [pose, child] : model.children) addThings(worldFromModel * toAffine(pose), child);
      return;
    }
    WorldThing thing{model.name, model.definition, worldFromModel, {}};
    collect({}, "", model, thing.parts);
    world_.things.push_back(std::move(thing));
  }

  static void collect(const Affine& thingFromModel, const std::string& prefix, const Model& model,
                      std::vector<WorldPart>& parts) {
    for (WorldPart part : model.parts) {
      part.node = prefix + part.node;
      part.thingFromPart = thingFromModel * part.thingFromPart;
      parts.push_back(std::move(part));
    }
    for (const auto& [pose, child] : model.children) {
      collect(thingFromModel * toAffine(pose), prefix + child.name + "/", child, parts);
    }
  }

  void leftOut(const std::string& what) { appendNew({what}, world_.leftOut); }

  World world_;
  std::map<std::filesystem::path, XmlNode> definitions_;
  std::map<std::filesystem::path, std::map<std::string, OgreMaterial>> looks_;  // by script or folder, then by name
};

}  // namespace

World readSdf(const std::filesystem::path& file) {
  return SdfReader().read(file);
}

}  // namespace scanmill
