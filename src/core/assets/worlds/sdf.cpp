#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <utility>

#include "assets/worlds/named_files.h"
#include "assets/worlds/solids.h"
#include "assets/worlds/world_asset.h"
#include "assets/worlds/xml.h"
#include "base/format_support.h"
#include "base/input_budget.h"

namespace scanmill {
namespace {

constexpr int kDeepestModel = 24;        // largest depth of nested models
constexpr double kBytesPerModel = 4096;  // memory of a model without parts
constexpr std::size_t kLongest = 1000;   // longest chain of frames, each relative to the next

// The named frames of a world or a model, to which poses may be relative.
struct Scope {
  struct Frame {
    const XmlNode* node = nullptr;
    Pose pose;
    std::string relativeTo;               // name of the frame that `pose` refers to; empty: the scope's own frame
    std::shared_ptr<const Scope> inside;  // frames inside a model; null: this frame is not a model
  };
  std::map<std::string, Frame> frames;
  bool isWorld = false;
  // Frame whose pose frames have that are not in `frames`, because the file with them is missing; nullopt: none is.
  std::optional<std::string> inPlaceOfMissing;

  // Returns the pose of a frame in the scope's own frame (that of the world or model). Errors are thrown at `from`.
  Pose resolve(const std::string& name, const XmlNode& from) const {
    std::set<std::pair<const Scope*, std::string>> been;
    return resolve(name, from, been);
  }

 private:
  Pose resolve(const std::string& name, const XmlNode& from,
               std::set<std::pair<const Scope*, std::string>>& been) const {
    if (name.empty() || name == "__model__" || name == "__root__" || (isWorld && name == "world")) return {};
    if (!been.emplace(this, name).second) {
      from.fail(fmt::format("has a pose relative to '{}', which is relative to itself", name));
    }
    if (been.size() > kLongest)
      from.fail(fmt::format("has a pose relative to a chain of more than {} frames", kLongest));
    // Files that sdformat 1.7 flattened have frames with colons in their names.
    const std::size_t colons = frames.contains(name) ? std::string::npos : name.find("::");
    const auto found = frames.find(name.substr(0, colons));
    if (found == frames.end() && inPlaceOfMissing) return resolve(*inPlaceOfMissing, from, been);
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
  std::string nameInFile;  // name that the file of an included model gives it; empty: it is not included
  std::filesystem::path definition;
  std::vector<WorldPart> parts;  // in the model's frame
  std::vector<PlacedModel> children;
  Pose placement;              // pose of the placement frame in the model's frame
  std::optional<Pose> stated;  // pose in the parent's frame by the world's state
  bool merged = false;         // its links and models are those of the model that includes it
  bool missing = false;        // its file is missing
};

// The world's state as far as it concerns the models of one world or one model.
struct State {
  const XmlNode* node = nullptr;  // a <state>, or the <model> in it; null: none
  Pose worldFromModel;            // identity for the world
};

struct PlacedModel {
  Pose pose;
  Model model;
};

struct PoseElement {
  Pose pose;
  std::string relativeTo;
};

float fractionIn(const XmlNode& node) {
  return static_cast<float>(std::clamp(numbersIn(node, node.text, 1).front(), 0.0, 1.0));
}

bool isTrue(const std::string& text) {
  return text == "true" || text == "True" || text == "TRUE" || text == "1";
}

PoseElement readPose(const XmlNode& of) {
  const XmlNode* const element = of.child("pose");
  if (element == nullptr) return {};
  PoseElement read;
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
  const double unit = isTrue(element->attributeOr("degrees", "false")) ? kPi / 180 : 1;
  read.pose = {fromYawPitchRoll(n[5] * unit, n[4] * unit, n[3] * unit), {n[0], n[1], n[2]}};
  return read;
}

class SdfReader {
 public:
  WorldFile read(const std::filesystem::path& file) {
    const XmlNode root = readXml(file);
    if (root.name != "sdf" && root.name != "gazebo") root.fail("is not an SDF: its first element must be <sdf>");
    std::vector<PlacedModel> models;
    bool any = false, world = false;
    for (const XmlNode& child : root.children) {
      if (child.name == "world" && std::exchange(world, true)) {
        world_.leftOut.add("worlds after the first");
        continue;
      }
      if (child.name == "actor") world_.leftOut.addKeyword(sdfFormat(), child.name);
      if (child.name != "world" && child.name != "model" && child.name != "include") continue;
      any = true;
      survey(child);
      XmlNode alone;
      alone.where = child.where;
      alone.children = {child};
      for (auto& placed : modelsOf(child.name == "world" ? child : alone, file, 0, {}).first) {
        models.push_back(std::move(placed));
      }
    }
    if (!any) root.fail("has neither a world nor a model");
    for (const auto& [pose, model] : models) addThings(toAffine(pose), model, model.name);
    return std::move(world_);
  }

 private:
  using Placed = std::vector<PlacedModel>;

  // Counts the elements of a file that are left out, those that the table does not know, and, outside of states, those
  // in wrong places.
  void survey(const XmlNode& of, bool inState = false) {
    static constexpr std::array<ElementPlace, 19> kPlaces{
        {{"model include", "sdf gazebo world model", true},
         {"link", "model", true},
         {"visual", "link", true},
         {"geometry", "visual collision"},
         {"mesh box capsule cone cylinder ellipsoid plane sphere heightmap image empty", "geometry"},
         {"polyline", "geometry", true},
         {"pose", "model include link visual frame joint"},
         {"uri", "include"},
         {"uri", "mesh heightmap"},
         {"uri", "script", true},
         {"submesh", "mesh"},
         {"scale", "mesh"},
         {"size", "box plane heightmap image"},
         {"radius", "cylinder sphere capsule cone"},
         {"length", "cylinder capsule cone"},
         {"material", "visual"},
         {"diffuse", "material"},
         {"script", "material"},
         {"transparency", "visual"}}};
    if (!inState) countMisplaced(of, kPlaces, world_.leftOut);
    for (const XmlNode& child : of.children) {
      if (child.name == "origin" && child.attribute("pose") != nullptr) {
        child.fail("is of SDF 1.0: convert the file, by `gz sdf -c FILE`");
      }
      const double number = std::strtod(child.text.c_str(), nullptr);
      if (child.name == "transparency" && number > 0 && number < 1)
        world_.leftOut.add("transparencies between 0 and 1 (these visuals are solid)");
      const bool usual = ((child.name == "laser_retro" || child.name == "initial_position") && number == 0) ||
                         (child.name == "visibility_flags" && number == UINT32_MAX) ||
                         (child.name == "sampling" && number == 1);
      const bool known = sdfFormat().find(child.name) != nullptr;
      const bool custom = child.name.find(':') != std::string::npos && !known;  // elements of other programs
      if (!usual && !custom) world_.leftOut.addKeyword(sdfFormat(), child.name);
      if (!sdfFormat().has(FormatElements::Use::Read, child.name)) continue;
      survey(child, inState || child.name == "state");
    }
  }

  // Returns the child of a state that concerns a model or link; null if there is none.
  const XmlNode* stateOf(const XmlNode* state, std::string_view kind, const std::string& name) {
    if (state == nullptr) return nullptr;
    const auto found = std::find_if(state->children.begin(), state->children.end(), [&](const XmlNode& child) {
      return child.name == kind && child.attributeOr("name", "") == name;
    });
    if (found == state->children.end()) return nullptr;
    statesUsed_.insert(&*found);
    return &*found;
  }

  // Appends the names of the models and links in a state that stateOf() did not find.
  void listUnused(const XmlNode& state, std::vector<std::string>& names) const {
    for (const XmlNode& child : state.children) {
      if (child.name != "model" && child.name != "link") continue;
      if (statesUsed_.contains(&child)) {
        listUnused(child, names);
      } else {
        names.push_back(child.attributeOr("name", ""));
      }
    }
  }

  // A link keeps its name if a joint, frame or model has the same, which SDF 1.6 allows.
  static void addFrame(Scope& scope, const std::string& name, const Scope::Frame& frame) {
    const auto known = scope.frames.find(name);
    const bool taken = known != scope.frames.end() && known->second.node->name == "link";
    if (taken && frame.node->name == "link") {
      frame.node->fail(fmt::format("has the name '{}', as another link: links need names of their own", name));
    }
    if (!taken) scope.frames[name] = frame;
  }

  // Returns the models of a world, or the models nested in a model, and the frames to which their poses may be
  // relative. `state`: state of the model in which they are nested; the state of a world is in `of`.
  std::pair<Placed, std::shared_ptr<Scope>> modelsOf(const XmlNode& of, const std::filesystem::path& file, int depth,
                                                     State state) {
    if (depth > kDeepestModel)
      of.fail(fmt::format("is nested in more than {} models: does one include itself?", kDeepestModel));
    chargeCopies(1, of.where, kBytesPerModel);
    auto scope = std::make_shared<Scope>();
    scope->isWorld = depth == 0;
    struct Found {
      PoseElement pose;
      Model model;
      const XmlNode* node;
    };
    std::vector<Found> found;
    for (const XmlNode& child : of.children) {
      if (child.name != "state" || depth != 0) continue;
      if (state.node != nullptr) world_.leftOut.add("states after the first");
      if (state.node == nullptr) state.node = &child;  // Gazebo applies the first state alone
    }
    for (const XmlNode& child : of.children) {
      if (child.name == "model" || child.name == "include") {
        PoseElement pose;
        std::shared_ptr<const Scope> inside;
        std::optional<Model> model = child.name == "model" ? readModel(child, file, depth + 1, pose, inside, state,
                                                                       child.attributeOr("name", "model"))
                                                           : readInclude(child, file, depth + 1, pose, inside, state);
        if (!model) continue;
        pose.pose = pose.pose * inverse(model->placement);
        // The frame of a merged model has the name that libsdformat gives it, which no link of the model has.
        model->merged = depth > 0 && inside != nullptr && isTrue(child.attributeOr("merge", "false"));
        const std::string own = model->merged ? "_merged__" + model->name + "__model__" : model->name;
        const Scope::Frame frame{&child, pose.pose, pose.relativeTo, inside};
        addFrame(*scope, own, frame);
        if (!model->merged && !model->nameInFile.empty()) scope->frames.try_emplace(model->nameInFile, frame);
        if (model->merged) {
          for (const auto& [name, innerFrame] : inside->frames) {
            Scope::Frame merged = innerFrame;
            if (merged.relativeTo.empty() || merged.relativeTo == "__model__") merged.relativeTo = own;
            scope->frames.try_emplace(name, std::move(merged));
          }
        }
        if (model->missing && model->merged) scope->inPlaceOfMissing = own;
        if (!model->missing) found.push_back({pose, std::move(*model), &child});
      } else if (child.name == "frame" || child.name == "link" || child.name == "joint") {
        const PoseElement pose = readPose(child);
        std::string relativeTo = pose.relativeTo;
        if (relativeTo.empty() && child.name == "frame") relativeTo = child.attributeOr("attached_to", "");
        if (relativeTo.empty() && child.name == "joint") relativeTo = child.textOf("child", "");
        addFrame(*scope, child.attributeOr("name", child.name), {&child, pose.pose, relativeTo, nullptr});
      }
    }
    std::vector<std::string> unused;
    if (depth == 0 && state.node != nullptr && world_.missing.empty()) listUnused(*state.node, unused);
    if (!unused.empty()) {
      world_.leftOut.add(
          fmt::format("states of models and links that the world lacks (the first is '{}')", unused.front()),
          unused.size());
    }
    Placed placed;
    for (Found& f : found) {
      const Pose pose = scope->resolve(f.pose.relativeTo, *f.node) * f.pose.pose;
      placed.push_back({f.model.stated.value_or(pose), std::move(f.model)});
    }
    return {std::move(placed), scope};
  }

  Model readModel(const XmlNode& node, const std::filesystem::path& file, int depth, PoseElement& pose,
                  std::shared_ptr<const Scope>& inside, const State& around, const std::string& name) {
    Model model;
    model.name = name;
    pose = readPose(node);
    State state{stateOf(around.node, "model", name), {}};
    Vec3d scale{1, 1, 1};
    if (state.node != nullptr) {
      state.worldFromModel = readPose(*state.node).pose;
      model.stated = inverse(around.worldFromModel) * state.worldFromModel;
      if (state.node->child("scale") != nullptr) scale = sizesOf(*state.node, "scale");
    }
    auto [children, scope] = modelsOf(node, file, depth, state);
    for (PlacedModel& child : children) {
      if (!child.model.merged) {
        model.children.push_back(std::move(child));
        continue;
      }
      for (WorldPart& part : child.model.parts) {
        part.thingFromPart = toAffine(child.pose) * part.thingFromPart;
        model.parts.push_back(std::move(part));
      }
      for (PlacedModel& inner : child.model.children) {
        model.children.push_back({child.pose * inner.pose, std::move(inner.model)});
      }
    }
    for (const XmlNode& link : node.children) {
      if (link.name != "link") continue;
      const std::string linkName = link.attributeOr("name", "link");
      const Pose modelFromLink = scope->resolve(linkName, link);
      const std::size_t first = model.parts.size();
      for (const XmlNode& visual : link.children) {
        if (visual.name == "visual") addVisual(visual, linkName, modelFromLink, *scope, file, scale, model.parts);
      }
      const XmlNode* const linkState = stateOf(state.node, "link", linkName);
      if (linkState == nullptr) continue;
      const Affine moved = toAffine(inverse(state.worldFromModel) * readPose(*linkState).pose * inverse(modelFromLink));
      for (std::size_t i = first; i < model.parts.size(); ++i) {
        model.parts[i].thingFromPart = moved * model.parts[i].thingFromPart;
      }
    }
    if (const std::string* frame = node.attribute("placement_frame")) model.placement = scope->resolve(*frame, node);
    inside = scope;
    return model;
  }

  std::optional<Model> readInclude(const XmlNode& node, const std::filesystem::path& file, int depth, PoseElement& pose,
                                   std::shared_ptr<const Scope>& inside, const State& around) {
    const std::string uri = node.textOf("uri", "");
    std::string plain = uri;
    while (plain.ends_with('/') && !plain.ends_with("//")) plain.pop_back();
    const std::string name = std::filesystem::path(plain).filename().string();
    std::optional<std::filesystem::path> definition;
    try {
      std::filesystem::path& found = found_[{file.parent_path(), plain}];
      if (found.empty()) found = definitionOf(node, file, plain);
      definition = found;
    } catch (const MissingFileError& e) {               // models that belong to Gazebo may not be installed
      if (plain == "model://sun") return std::nullopt;  // sun is a light
      if (plain != "model://ground_plane") {
        world_.missing.push_back(e);
        Model empty;
        empty.name = node.textOf("name", name);
        empty.missing = true;
        pose = readPose(node);
        auto scope = std::make_shared<Scope>();
        scope->inPlaceOfMissing = "";
        inside = std::move(scope);
        return empty;
      }
    }
    const std::filesystem::path place = definition.value_or(plain);
    const auto [known, isNew] = definitions_.try_emplace(place);
    if (isNew) known->second = definition ? readXml(place) : groundPlane(node.where);
    const XmlNode& root = known->second;
    const XmlNode* const child = root.child("model");
    if (root.name == "robot") {
      root.fail(fmt::format(
          "is a URDF, but {} includes it: convert it by `gz sdf -p FILE` and include the SDF, or load it as an object "
          "of its own",
          node.where.text()));
    }
    if (child == nullptr) {
      if (root.child("actor") != nullptr) world_.leftOut.addKeyword(sdfFormat(), "actor");
      if (root.child("light") != nullptr || root.child("actor") != nullptr) return std::nullopt;
      root.fail(fmt::format("has no model, but {} includes it", node.where.text()));
    }
    if (isNew) survey(*child);
    const std::string nameInFile = child->attributeOr("name", name);
    Model model = readModel(*child, place, depth, pose, inside, around,
                            node.textOf("name", plain.ends_with(".sdf") ? nameInFile : name));
    if (node.child("name") == nullptr) model.nameInFile = nameInFile;
    if (definition && !model.stated) model.definition = place;  // its parts are those of all copies
    if (const XmlNode* frame = node.child("placement_frame")) model.placement = inside->resolve(frame->text, node);
    if (node.child("pose") != nullptr) pose = readPose(node);
    return model;
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
      std::string highest;
      const std::filesystem::path config = found / "model.config";
      if (std::filesystem::exists(config, ignored)) {
        for (const XmlNode& sdf : readXml(config).children) {
          if (sdf.name != "sdf") continue;
          const std::string version = sdf.attributeOr("version", "0");
          if (version.find_first_of("0123456789") != 0)
            sdf.fail(fmt::format("has the version '{}', which is no number", version));
          // strverscmp() compares the numbers in the texts, so that 1.10 is greater than 1.9.
          if (::strverscmp(version.c_str(), highest.c_str()) <= 0 ||
              !std::filesystem::exists(found / sdf.text, ignored))
            continue;
          highest = version;
          best = sdf.text;
        }
      }
      found /= best;
      if (!std::filesystem::exists(found, ignored)) {
        throw MissingFileError(
            place.where, uri,
            fmt::format("<{}> names '{}', but no {} of this name exists", place.name, uri, found.string()));
      }
    }
    const std::filesystem::path canonical = std::filesystem::weakly_canonical(found, ignored);
    return ignored ? found : canonical;
  }

  // Returns the definition of Gazebo's model ground_plane, a square of 100 m.
  static XmlNode groundPlane(const Location& where) {
    XmlNode node{where, "size", "100 100", {}, {}};
    for (const char* name : {"plane", "geometry", "visual", "link", "model", "sdf"}) {
      node = XmlNode{where, name, "", {}, {node}};
    }
    return node;
  }

  void addVisual(const XmlNode& visual, const std::string& link, const Pose& modelFromLink, const Scope& scope,
                 const std::filesystem::path& file, const Vec3d& stated, std::vector<WorldPart>& parts) {
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
        try {
          part.mesh = findModel(*uri, file, uri->text);
        } catch (const MissingFileError& e) {
          return world_.missing.push_back(e);
        }
        if (const XmlNode* scale = shape.child("scale")) {
          part.thingFromPart.linear = part.thingFromPart.linear * Mat3::scale(vectorIn(*scale, scale->text));
        }
        if (const XmlNode* submesh = shape.child("submesh")) {
          part.submesh = submesh->textOf("name", "");
          part.centred = isTrue(submesh->textOf("center", "false"));
        }
      } else if (shape.name == "polyline") {
        part.solid = extrudedPolylines(*geometry);
      } else if (shape.name == "heightmap") {
        const std::optional<std::filesystem::path> image = imageOf(shape, file);
        if (!image) return;
        part.solid = heightmapOf(shape, *image);
      } else {
        part.solid = solidOf(shape);
        if (!part.solid) continue;
      }
      if (stated != Vec3d{1, 1, 1}) part.thingFromPart.linear = part.thingFromPart.linear * scaleOf(shape, stated);
      readLook(visual, file, part);
      parts.push_back(std::move(part));
      return;
    }
  }

  // Returns how the scale of a model's state scales a shape in its own frame: round shapes stay round, as in Gazebo.
  static Mat3 scaleOf(const XmlNode& shape, const Vec3d& scale) {
    const double across = std::max(scale.x, scale.y);
    if (shape.name == "sphere") return Mat3::scale(Vec3d{1, 1, 1} * std::max(across, scale.z));
    if (shape.name == "cylinder") return Mat3::scale({across, across, scale.z});
    return Mat3::scale(scale);
  }

  // Returns the image of a heightmap; nullopt if it is missing.
  std::optional<std::filesystem::path> imageOf(const XmlNode& heightmap, const std::filesystem::path& file) {
    const XmlNode* const uri = heightmap.child("uri");
    if (uri == nullptr) heightmap.fail("has no <uri>");
    try {
      return findModel(*uri, file, uri->text);
    } catch (const MissingFileError& e) {
      if (uri->text.starts_with("file://media")) {
        world_.leftOut.add(fmt::format("heightmaps of Gazebo's own '{}'", uri->text));
      } else {
        world_.missing.push_back(e);
      }
      return std::nullopt;
    }
  }

  void readLook(const XmlNode& visual, const std::filesystem::path& file, WorldPart& part) {
    const XmlNode* const material = visual.child("material");
    if (material == nullptr) return;
    const XmlNode* const diffuse = material->child("diffuse");
    if (diffuse != nullptr) {
      const auto [r, g, b, alpha] = colorOf(*diffuse, diffuse->text, world_.leftOut);
      part.color = {r, g, b};
      if (alpha < 1) world_.leftOut.add("alphas of diffuse colours (these visuals are solid)");
    }
    readAlbedo(*material, file, part);
    const XmlNode* const script = material->child("script");
    if (script == nullptr) return;
    part.material = script->textOf("name", "");
    // Scripts at file://media are Gazebo's own, such as Gazebo/Grey.
    const bool own = std::all_of(script->children.begin(), script->children.end(), [](const XmlNode& child) {
      return child.name != "uri" || child.text.starts_with("file://media");
    });
    if (!own || (!part.color && part.texture.empty())) {
      world_.leftOut.add("looks by scripts of OGRE (state them by <diffuse> or <pbr>)");
    }
  }

  // Reads the image, roughness and metalness of a physically based material.
  void readAlbedo(const XmlNode& material, const std::filesystem::path& file, WorldPart& part) {
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
        world_.leftOut.add(fmt::format("missing images '{}' (albedo_map)", map->text));
      }
      return;
    }
  }

  // Adds the things of a model, whose name in the world is `name`. A model without visuals is not a thing, but the
  // models nested in it are: a single one has its name, several are called NAME/NESTED.
  void addThings(const Affine& worldFromModel, const Model& model, const std::string& name) {
    if (model.parts.empty()) {
      for (const auto& [pose, child] : model.children) {
        const std::string own = model.children.size() == 1 ? name : fmt::format("{}/{}", name, child.name);
        addThings(worldFromModel * toAffine(pose), child, own);
      }
      return;
    }
    WorldThing thing{name, model.definition, worldFromModel, {}};
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

  WorldFile world_;
  std::set<const XmlNode*> statesUsed_;
  std::map<std::filesystem::path, XmlNode> definitions_;
  // Files of models, by the folder of the file that includes them and their URI.
  std::map<std::pair<std::filesystem::path, std::string>, std::filesystem::path> found_;
};

}  // namespace

const FormatSupport& sdfFormat() {
  using enum FormatElements::Use;
  static const FormatSupport format{
      "SDF",
      ".sdf, .world",
      {{Read, "sdf gazebo world model link visual geometry name include uri placement_frame pose frame joint parent"},
       {Read, "child axis axis2 state mesh submesh center scale box capsule cone cylinder"},
       {Read, "ellipsoid plane sphere empty size radius radii length normal polyline point height heightmap pos"},
       {Read, "transparency material diffuse pbr metal albedo_map roughness metalness script"},
       {LeftOut, "image", "extruded images (image)"},
       {LeftOut, "texture", "textures of heightmaps"},
       {LeftOut, "sampling", "samples between the pixels of heightmaps (sampling)"},
       {LeftOut, "actor", "actors"},
       {LeftOut, "population", "populations"},
       {LeftOut, "road", "roads"},
       {LeftOut, "particle_emitter", "particle emitters"},
       {LeftOut, "laser_retro", "values of laser_retro"},
       {LeftOut, "visibility_flags", "visibility flags of visuals that are read"},
       {LeftOut, "initial_position", "initial positions of joints"},
       {LeftOut, "insertions deletions", "models that a state inserts or deletes"},
       {LeftOut, "model_state joint_state", "states of SDF 1.12 (model_state, joint_state)"},
       {LeftOut, "experimental:params", "changes of included models (experimental:params)"},
       {Unused, "collision inertial surface self_collide static allow_auto_disable kinematic gravity velocity_decay"},
       {Unused, "must_be_base_link enable_wind physics atmosphere magnetic_field wind gripper battery"},
       {Unused, "xyz dynamics limit use_parent_model_frame mimic gearbox_ratio gearbox_reference_body thread_pitch"},
       {Unused, "screw_thread_pitch angle sim_time wall_time real_time iterations time velocity acceleration wrench"},
       {Unused, "light_state light projector sensor audio audio_sink audio_source plugin gui scene"},
       {Unused, "spherical_coordinates cast_shadows meta lighting shader render_order ambient specular emissive"},
       {Unused, "shininess double_sided roughness_map metalness_map environment_map ambient_occlusion_map normal_map"},
       {Unused, "emissive_map light_map blend use_terrain_paging convex_decomposition namespace"}},
      "The first world of a file and all models beside it, with models of other files. Poses relative to links, "
      "joints, models and frames, in radians, degrees or as quaternions; joints are at 0. Of a world's states the "
      "first: poses and scales of visuals. Meshes, whose up axis in COLLADA counts for "
      "nothing, as in Gazebo; solids; outlines, extruded from 0 to the height of the first, where an outline within "
      "another is a hole; terrain from band 1 of an image, whose greatest value has the height of <size>, or from a "
      "georeferenced raster. Visuals with transparency 1 are not there for beams, which meet no <collision>. `diffuse` "
      "is taken as linear light, since SDF states no colour space",
      "elements in a wrong place, and further ones where one may stand; transparencies between 0 and 1 and alphas of "
      "colours (these visuals are solid); numbers of colours above 1 (they count as 1); looks by scripts of OGRE; "
      "textures of parts without texture coordinates; worlds and states after the first, states of models and links "
      "that the world lacks"};
  return format;
}

WorldFile readSdf(const std::filesystem::path& file) {
  return SdfReader().read(file);
}

}  // namespace scanmill
