#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdlib>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <utility>

#include "assets/worlds/sdf_parts.h"
#include "assets/worlds/solids.h"
#include "assets/worlds/world_asset.h"
#include "assets/worlds/xml.h"
#include "base/file.h"
#include "base/format_support.h"
#include "base/input_budget.h"

namespace scanmill {
namespace {

constexpr int kDeepestModel = 24;        // largest depth of nested models
constexpr double kBytesPerModel = 4096;  // memory of a model without parts

// A model of a file, or the contents of a world as a model without parts.
struct Model {
  std::string name;
  std::string nameInFile;            // name that the file of an included model gives it; empty: it is not included
  std::filesystem::path definition;  // see WorldThing::definition
  std::vector<WorldPart> parts;      // in the model's frame
  std::vector<Model> children;
  std::shared_ptr<SdfFrames> frames;  // frames to which poses in the model may be relative
  const XmlNode* node = nullptr;      // the <model> or <include>, while the model around it is read
  Pose parentFromModel;
  SdfPose pose;                     // pose of the placement frame, as the file states it
  Pose placement;                   // pose of the placement frame in the model's frame
  std::optional<Pose> poseByState;  // pose in the parent's frame, if the world's state gives one
  bool merged = false;              // true: the model that includes this one gets its links and models
  bool missing = false;             // true: the file of the model is missing
};

// The part of a world's state that describes the models in a world or in a model.
struct State {
  const XmlNode* node = nullptr;  // a <state> or a <model> in a state; null: none
  Pose worldFromModel;            // identity for the world
};

// Where elements may stand; see countMisplaced().
constexpr std::array<ElementPlace, 19> kSdfPlaces{
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

// True if an element of SDF that is left out states the default, so that nothing is lost.
bool isSdfDefault(const XmlNode& element) {
  const double number = std::strtod(element.text.c_str(), nullptr);
  return ((element.name == "laser_retro" || element.name == "initial_position") && number == 0) ||
         (element.name == "visibility_flags" && number == UINT32_MAX) || (element.name == "sampling" && number == 1);
}

class SdfReader {
 public:
  WorldFile read(const std::filesystem::path& file) {
    const XmlNode root = readXml(file);
    if (root.name != "sdf" && root.name != "gazebo") root.fail("is not an SDF: its first element must be <sdf>");
    std::vector<Model> models;
    bool isEmpty = true, hasWorld = false;
    for (const XmlNode& child : root.children) {
      if (child.name == "world" && std::exchange(hasWorld, true)) {
        world_.leftOut.add("worlds after the first");
        continue;
      }
      if (child.name == "actor") world_.leftOut.addKeyword(kSdfFormat, child.name);
      if (child.name != "world" && child.name != "model" && child.name != "include") continue;
      isEmpty = false;
      countUnread(child);
      // A model outside of all worlds is read as the only model of a world.
      const XmlNode worldOfModel{child.where, "", "", {}, {child}};
      for (Model& model : contentsOf(child.name == "world" ? child : worldOfModel, file, 0, {}).children) {
        models.push_back(std::move(model));
      }
    }
    if (isEmpty) root.fail("has neither a world nor a model");
    for (const Model& model : models) addThings(toAffine(model.parentFromModel), model, model.name);
    return std::move(world_);
  }

 private:
  // Counts elements in `element` and below it that kSdfFormat leaves out or does not know, or that stand where
  // kSdfPlaces does not allow them. In a state, elements may stand anywhere. Throws InputError for SDF 1.0.
  void countUnread(const XmlNode& element, bool isInState = false) {
    if (!isInState) countMisplaced(element, kSdfPlaces, world_.leftOut);
    for (const XmlNode& child : element.children) {
      if (child.name == "origin" && child.attribute("pose") != nullptr) {
        child.fail("is of SDF 1.0: convert the file, by `gz sdf -c FILE`");
      }
      if (child.name == "transparency") {
        const double transparency = std::strtod(child.text.c_str(), nullptr);
        if (transparency > 0 && transparency < 1)
          world_.leftOut.add("transparencies between 0 and 1 (these visuals are solid)");
      }
      const bool isKnown = kSdfFormat.useOf(child.name) != FormatSupport::Use::Unknown;
      const bool isCustom = child.name.find(':') != std::string::npos && !isKnown;  // elements of other programs
      if (!isSdfDefault(child) && !isCustom) world_.leftOut.addKeyword(kSdfFormat, child.name);
      if (kSdfFormat.useOf(child.name) != FormatSupport::Use::Read) continue;
      countUnread(child, isInState || child.name == "state");
    }
  }

  // Returns the "model" or "link" (`kind`) of this name in `state`; null if there is none or `state` is null.
  const XmlNode* stateOf(const XmlNode* state, std::string_view kind, const std::string& name) {
    if (state == nullptr) return nullptr;
    const auto child = std::ranges::find_if(state->children, [&](const XmlNode& node) {
      return node.name == kind && node.attributeOr("name", "") == name;
    });
    if (child == state->children.end()) return nullptr;
    usedStates_.insert(&*child);
    return &*child;
  }

  // Appends the names of the models and links in a state that stateOf() did not find.
  void listUnused(const XmlNode& state, std::vector<std::string>& names) const {
    for (const XmlNode& child : state.children) {
      if (child.name != "model" && child.name != "link") continue;
      usedStates_.contains(&child) ? listUnused(child, names) : names.push_back(child.attributeOr("name", ""));
    }
  }

  // Counts the models and links in a world's state that the world lacks.
  void countUnusedStates(const XmlNode& state) {
    std::vector<std::string> names;
    listUnused(state, names);
    if (names.empty()) return;
    world_.leftOut.add(
        fmt::format("states of models and links that the world lacks (the first is '{}')", names.front()),
        names.size());
  }

  // Reads the frames of a <world> or a <model> and the models in it, and returns them as a model without parts.
  // `depth`: the number of models and worlds that contain the element, 0 for a world. `state`: the state of the
  // <model>; a <world> contains its own state.
  Model contentsOf(const XmlNode& around, const std::filesystem::path& file, int depth, State state) {
    if (depth > kDeepestModel) around.fail("is nested in more than {} models: does one include itself?", kDeepestModel);
    chargeCopies(1, around.where, kBytesPerModel);
    Model contents;
    contents.frames = std::make_shared<SdfFrames>();
    contents.frames->isWorld = depth == 0;
    if (depth == 0) {
      state.node = around.child("state");  // the first state, as in Gazebo
      const auto states = std::ranges::count(around.children, "state", &XmlNode::name);
      if (states > 1) world_.leftOut.add("states after the first", static_cast<std::uint64_t>(states - 1));
    }
    for (const XmlNode& child : around.children) {
      if (child.name == "frame" || child.name == "link" || child.name == "joint") {
        contents.frames->add(child.attributeOr("name", child.name), frameOf(child));
      }
      if (child.name != "model" && child.name != "include") continue;
      std::optional<Model> model = child.name == "model"
                                       ? readModel(child, file, depth + 1, state, child.attributeOr("name", "model"))
                                       : readInclude(child, file, depth + 1, state);
      if (!model) continue;
      model->node = &child;
      model->pose.pose = model->pose.pose * inverse(model->placement);
      model->merged = depth > 0 && isSdfTrue(child.attributeOr("merge", "false"));
      addFramesOf(*model, *contents.frames);
      if (!model->missing) contents.children.push_back(std::move(*model));
    }
    if (depth == 0 && state.node != nullptr && world_.missing.empty()) countUnusedStates(*state.node);
    // Poses may be relative to frames that the file defines later.
    for (Model& model : contents.children) {
      const Pose pose = contents.frames->resolve(model.pose.relativeTo, *model.node) * model.pose.pose;
      model.parentFromModel = model.poseByState.value_or(pose);
    }
    return contents;
  }

  // Returns the frame of a <frame>, <link> or <joint>.
  static SdfFrames::Frame frameOf(const XmlNode& node) {
    SdfPose pose = readSdfPose(node);
    if (pose.relativeTo.empty() && node.name == "frame") pose.relativeTo = node.attributeOr("attached_to", "");
    if (pose.relativeTo.empty() && node.name == "joint") pose.relativeTo = node.textOf("child", "");
    return {&node, pose, nullptr};
  }

  // Adds the frame of a model to `around`; if the model is merged, also the frames in the model.
  static void addFramesOf(const Model& model, SdfFrames& around) {
    // The frame of a merged model has the name that libsdformat gives it, which no link of the model has.
    const std::string name = model.merged ? "_merged__" + model.name + "__model__" : model.name;
    const SdfFrames::Frame frame{model.node, model.pose, model.frames};
    around.add(name, frame);
    if (!model.merged) {
      if (!model.nameInFile.empty()) around.byName.try_emplace(model.nameInFile, frame);
      return;
    }
    for (const auto& [innerName, innerFrame] : model.frames->byName) {
      SdfFrames::Frame merged = innerFrame;
      if (merged.pose.relativeTo.empty() || merged.pose.relativeTo == "__model__") merged.pose.relativeTo = name;
      around.byName.try_emplace(innerName, std::move(merged));
    }
    if (model.missing) around.substitute = name;
  }

  // Reads a <model> of a file. `depth`: see contentsOf(). `around`: the state of the world or model around it. `name`:
  // the model's name in that world or model.
  Model readModel(const XmlNode& node, const std::filesystem::path& file, int depth, const State& around,
                  const std::string& name) {
    Model model;
    model.name = name;
    model.pose = readSdfPose(node);
    State state{stateOf(around.node, "model", name), {}};
    Vec3d scale{1, 1, 1};
    if (state.node != nullptr) {
      state.worldFromModel = readSdfPose(*state.node).pose;
      model.poseByState = inverse(around.worldFromModel) * state.worldFromModel;
      if (state.node->child("scale") != nullptr) scale = sizesOf(*state.node, "scale");
    }
    Model contents = contentsOf(node, file, depth, state);
    model.frames = contents.frames;
    for (Model& child : contents.children) addChild(std::move(child), model);
    for (const XmlNode& link : node.children) {
      if (link.name != "link") continue;
      const std::string linkName = link.attributeOr("name", "link");
      const SdfLink sdfLink{.name = linkName,
                            .modelFromLink = model.frames->resolve(linkName, link),
                            .frames = *model.frames,
                            .file = file,
                            .scale = scale};
      addLink(link, sdfLink, state, model.parts);
    }
    if (const std::string* frame = node.attribute("placement_frame")) {
      model.placement = model.frames->resolve(*frame, node);
    }
    return model;
  }

  // Adds a nested model to a model. If the nested model is merged, adds its parts and its nested models instead.
  static void addChild(Model child, Model& model) {
    if (!child.merged) return model.children.push_back(std::move(child));
    for (WorldPart& part : child.parts) {
      part.thingFromPart = toAffine(child.parentFromModel) * part.thingFromPart;
      model.parts.push_back(std::move(part));
    }
    for (Model& inner : child.children) {
      inner.parentFromModel = child.parentFromModel * inner.parentFromModel;
      model.children.push_back(std::move(inner));
    }
  }

  // Adds the visuals of a link, at the pose that the state gives the link or, without one, at the link's own pose.
  void addLink(const XmlNode& node, const SdfLink& link, const State& state, std::vector<WorldPart>& parts) {
    const std::size_t first = parts.size();
    for (const XmlNode& visual : node.children) {
      if (visual.name != "visual") continue;
      if (auto part = readSdfVisual(visual, link, world_)) parts.push_back(std::move(*part));
    }
    const XmlNode* const linkState = stateOf(state.node, "link", link.name);
    if (linkState == nullptr) return;
    const Pose worldFromLink = readSdfPose(*linkState).pose;
    const Affine move = toAffine(inverse(state.worldFromModel) * worldFromLink * inverse(link.modelFromLink));
    for (std::size_t i = first; i < parts.size(); ++i) parts[i].thingFromPart = move * parts[i].thingFromPart;
  }

  // Returns the model that an <include> names; nullopt for lights and actors. The model's name is the <name> of the
  // <include>; without one, the name in the file if the URI names an .sdf, else the last part of the URI.
  std::optional<Model> readInclude(const XmlNode& node, const std::filesystem::path& file, int depth,
                                   const State& around) {
    std::string uri = node.textOf("uri", "");
    while (uri.ends_with('/') && !uri.ends_with("//")) uri.pop_back();
    const std::string nameInUri = std::filesystem::path(uri).filename().string();
    std::optional<std::filesystem::path> definition;  // nullopt: Gazebo's own ground_plane
    try {
      std::filesystem::path& cached = definitions_[{file.parent_path(), uri}];
      if (cached.empty()) cached = definitionOf(node, file, uri);
      definition = cached;
    } catch (const MissingFileError& e) {             // models that belong to Gazebo may not be installed
      if (uri == "model://sun") return std::nullopt;  // sun is a light
      if (uri != "model://ground_plane") return missingModel(node, nameInUri, e);
    }
    const std::filesystem::path path = definition.value_or(uri);  // the built-in model has its URI as key of roots_
    const auto [root, isNew] = roots_.try_emplace(path);
    if (isNew) root->second = definition ? readXml(path) : groundPlane(node.where);
    const XmlNode* const modelNode = modelIn(root->second, node);
    if (modelNode == nullptr) return std::nullopt;
    if (isNew) countUnread(*modelNode);
    const std::string nameInFile = modelNode->attributeOr("name", nameInUri);
    const std::string nameHere = node.textOf("name", uri.ends_with(".sdf") ? nameInFile : nameInUri);
    Model model = readModel(*modelNode, path, depth, around, nameHere);
    if (node.child("name") == nullptr) model.nameInFile = nameInFile;
    if (definition && !model.poseByState) model.definition = path;  // all copies have the same parts
    if (const XmlNode* frame = node.child("placement_frame")) {
      model.placement = model.frames->resolve(frame->text, node);
    }
    if (node.child("pose") != nullptr) model.pose = readSdfPose(node);
    return model;
  }

  // Notes the missing file in world_, and returns an empty model in place of the one that the file would define.
  Model missingModel(const XmlNode& include, const std::string& name, const MissingFileError& error) {
    world_.missing.push_back(error);
    Model model;
    model.name = include.textOf("name", name);
    model.pose = readSdfPose(include);
    model.frames = std::make_shared<SdfFrames>();
    model.frames->substitute = "";
    model.missing = true;
    return model;
  }

  // Returns the model of an included file; null if the file has a light or an actor instead. Else throws InputError.
  const XmlNode* modelIn(const XmlNode& root, const XmlNode& include) {
    if (root.name == "robot") {
      root.fail(
          "is a URDF, but {} includes it: convert it by `gz sdf -p FILE` and include the SDF, or load it as an object "
          "of its own",
          include.where.text());
    }
    const XmlNode* const model = root.child("model");
    if (model != nullptr) return model;
    if (root.child("actor") != nullptr) world_.leftOut.addKeyword(kSdfFormat, "actor");
    if (root.child("light") != nullptr || root.child("actor") != nullptr) return nullptr;
    root.fail("has no model, but {} includes it", include.where.text());
  }

  // Returns the existing file that model.config in a folder lists with the highest version; without any, model.sdf.
  static std::string newestSdf(const std::filesystem::path& folder) {
    std::string newest = "model.sdf", highestVersion;
    const std::filesystem::path config = folder / "model.config";
    if (!pathExists(config)) return newest;
    for (const XmlNode& sdf : readXml(config).children) {
      if (sdf.name != "sdf") continue;
      const std::string version = sdf.attributeOr("version", "0");
      if (version.find_first_of("0123456789") != 0) sdf.fail("has the version '{}', which is no number", version);
      // strverscmp() compares the numbers in the texts, so that 1.10 is greater than 1.9.
      if (::strverscmp(version.c_str(), highestVersion.c_str()) <= 0) continue;
      if (!pathExists(folder / sdf.text)) continue;
      highestVersion = version;
      newest = sdf.text;
    }
    return newest;
  }

  // Returns the file that defines a model: the file `uri` or, if `uri` is a folder, newestSdf() of the folder.
  static std::filesystem::path definitionOf(const XmlNode& node, const std::filesystem::path& file,
                                            const std::string& uri) {
    const XmlNode* const uriNode = node.child("uri");
    const XmlNode& naming = uriNode == nullptr ? node : *uriNode;
    std::filesystem::path path = findModel(naming, file, uri);
    if (isFolder(path)) {
      path /= newestSdf(path);
      if (!pathExists(path)) {
        throw MissingFileError(
            naming.where, uri,
            fmt::format("<{}> names '{}', but no {} of this name exists", naming.name, uri, path.string()));
      }
    }
    std::error_code error;
    const std::filesystem::path canonical = std::filesystem::weakly_canonical(path, error);
    return error ? path : canonical;
  }

  // Returns the definition of Gazebo's model ground_plane, a square of 100 m.
  static XmlNode groundPlane(const Location& where) {
    XmlNode node{where, "size", "100 100", {}, {}};
    for (const char* name : {"plane", "geometry", "visual", "link", "model", "sdf"}) {
      node = XmlNode{where, name, "", {}, {node}};
    }
    return node;
  }

  // Adds the things of a model, whose name in the world is `name`. A model without visuals is not a thing, but the
  // models nested in it are: a single one gets the name `name`, several are called NAME/NESTED.
  void addThings(const Affine& worldFromModel, const Model& model, const std::string& name) {
    if (model.parts.empty()) {
      for (const Model& child : model.children) {
        const std::string childName = model.children.size() == 1 ? name : fmt::format("{}/{}", name, child.name);
        addThings(worldFromModel * toAffine(child.parentFromModel), child, childName);
      }
      return;
    }
    WorldThing thing{name, model.definition, worldFromModel, {}};
    addParts({}, "", model, thing.parts);
    world_.things.push_back(std::move(thing));
  }

  // Adds the parts of a model and of all models nested in it. The names of the parts begin with `prefix`.
  static void addParts(const Affine& thingFromModel, const std::string& prefix, const Model& model,
                       std::vector<WorldPart>& parts) {
    for (WorldPart part : model.parts) {
      part.node = prefix + part.node;
      part.thingFromPart = thingFromModel * part.thingFromPart;
      parts.push_back(std::move(part));
    }
    for (const Model& child : model.children) {
      addParts(thingFromModel * toAffine(child.parentFromModel), prefix + child.name + "/", child, parts);
    }
  }

  WorldFile world_;
  std::set<const XmlNode*> usedStates_;             // elements that stateOf() returned
  std::map<std::filesystem::path, XmlNode> roots_;  // root elements of the files that define models
  // Files that define models, by the folder of the file that includes them and their URI.
  std::map<std::pair<std::filesystem::path, std::string>, std::filesystem::path> definitions_;
};

}  // namespace

const FormatSupport kSdfFormat{
    "SDF",
    ".sdf, .world",
    "The first world of a file and all models beside it, with models of other files. Poses relative to links, "
    "joints, models and frames, in radians, degrees or as quaternions; joints are at 0. Of a world's states the "
    "first: poses and scales of visuals. Meshes, whose up axis in COLLADA counts for nothing, as in Gazebo; solids; "
    "outlines, extruded from 0 to the height of the first, where an outline within another is a hole; terrain from "
    "band 1 of an image, whose greatest value has the height of <size>, or from a georeferenced raster. Visuals with "
    "transparency 1 are not there for beams, which meet no <collision>. `diffuse` is taken as linear light, since "
    "SDF states no colour space",
    "elements in a wrong place, and further ones where one may stand; transparencies between 0 and 1 and alphas of "
    "colours (these visuals are solid); numbers of colours above 1 (they count as 1); looks by scripts of OGRE; "
    "textures of parts without texture coordinates; worlds and states after the first, states of models and links "
    "that the world lacks",
    {.read = {"sdf gazebo world model link visual geometry name include uri placement_frame pose frame joint",
              "parent child axis axis2 state mesh submesh center scale box capsule cone cylinder ellipsoid plane",
              "sphere empty size radius radii length normal polyline point height heightmap pos transparency",
              "material diffuse pbr metal albedo_map roughness metalness script"},
     .unused = {"collision inertial surface self_collide static allow_auto_disable kinematic gravity velocity_decay",
                "must_be_base_link enable_wind physics atmosphere magnetic_field wind gripper battery xyz dynamics",
                "limit use_parent_model_frame mimic gearbox_ratio gearbox_reference_body thread_pitch",
                "screw_thread_pitch angle sim_time wall_time real_time iterations time velocity acceleration wrench",
                "light_state light projector sensor audio audio_sink audio_source plugin gui scene",
                "spherical_coordinates cast_shadows meta lighting shader render_order ambient specular emissive",
                "shininess double_sided roughness_map metalness_map environment_map ambient_occlusion_map",
                "normal_map emissive_map light_map blend use_terrain_paging convex_decomposition namespace"},
     .leftOut = {{"image", "extruded images (image)"},
                 {"texture", "textures of heightmaps"},
                 {"sampling", "samples between the pixels of heightmaps (sampling)"},
                 {"actor", "actors"},
                 {"population", "populations"},
                 {"road", "roads"},
                 {"particle_emitter", "particle emitters"},
                 {"laser_retro", "values of laser_retro"},
                 {"visibility_flags", "visibility flags of visuals that are read"},
                 {"initial_position", "initial positions of joints"},
                 {"insertions deletions", "models that a state inserts or deletes"},
                 {"model_state joint_state", "states of SDF 1.12 (model_state, joint_state)"},
                 {"experimental:params", "changes of included models (experimental:params)"}}}};

WorldFile readSdf(const std::filesystem::path& file) {
  return SdfReader().read(file);
}

}  // namespace scanmill
