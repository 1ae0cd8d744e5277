#include "assets/worlds/world_asset.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>
#include <set>
#include <utility>

#include "assets/asset_kinds.h"
#include "assets/meshes/asset_parts.h"
#include "assets/meshes/base_color.h"
#include "assets/meshes/references.h"
#include "base/file.h"
#include "base/input_budget.h"

namespace scanmill {
namespace {

// Returns a name without the numbers at its end and before slashes: "car" for "car_01_002", "row/car" for
// "row_1/car_2".
std::string withoutNumbers(const std::string& name) {
  std::string shortName;
  for (std::size_t begin = 0; begin <= name.size();) {
    const std::size_t end = std::min(name.find('/', begin), name.size());
    const std::string word = name.substr(begin, end - begin);
    const std::size_t last = word.find_last_not_of("0123456789_-. ");
    shortName += (begin == 0 ? "" : "/") + (last == std::string::npos ? word : word.substr(0, last + 1));
    begin = end + 1;
  }
  return shortName;
}

class WorldAsset {
 public:
  WorldAsset(const std::filesystem::path& file, const AssetOptions& options)
      : file_(file), options_(options), images_(file, true) {
    asset_.up = options.up.value_or('z');
    asset_.upDeclared = true;
    asset_.statedUnit = 1;
    assetFromWorld_ = {assetFromFile(asset_.up, options.metresPerUnit), {}};
  }

  Asset build(const WorldFile& world) {
    leftOut_ = world.leftOut;
    reportMissing(world.missing, options_.leaveOutMissing, leftOut_);
    // Things of the same model whose names differ only in the numbers at their ends are copies of the first.
    std::map<std::pair<std::filesystem::path, std::string>, std::vector<const WorldThing*>> copies;
    for (const WorldThing& thing : world.things) {
      if (!thing.definition.empty()) copies[{thing.definition, withoutNumbers(thing.name)}].push_back(&thing);
    }
    for (const WorldThing& thing : world.things) {
      const auto group = copies.find({thing.definition, withoutNumbers(thing.name)});
      if (group == copies.end() || group->second.size() < 2) {
        addThing(thing, thing.name, assetFromWorld_ * thing.worldFromThing, asset_.parts);
      } else if (group->second.front() == &thing) {
        InstancedParts instanced;
        addThing(thing, withoutNumbers(thing.name), {}, instanced.parts);
        if (instanced.parts.empty()) continue;
        for (const WorldThing* copy : group->second) {
          instanced.assetFromParts.push_back(assetFromWorld_ * copy->worldFromThing);
        }
        asset_.instanced.push_back(std::move(instanced));
      }
    }
    leftOut_.warn(file_.string());
    if (asset_.parts.empty() && asset_.instanced.empty()) {
      throw InputError(
          {file_.string()},
          "has no triangle: beams meet the <visual>s of links, not their <collision>s, and no visual has a shape that "
          "is read");
    }
    return std::move(asset_);
  }

 private:
  // Adds the parts of a thing as one node. The names of the parts begin with `name`.
  void addThing(const WorldThing& thing, const std::string& name, const Affine& assetFromThing,
                std::vector<AssetPart>& parts) {
    for (const WorldPart& visual : thing.parts) {
      for (AssetPart& part : partsOf(visual)) {
        part.fileMaterial.roughness = visual.roughness.value_or(part.fileMaterial.roughness);
        part.fileMaterial.metallic = visual.metallic.value_or(part.fileMaterial.metallic);
        part.node = fmt::format("{}/{}{}{}", name, visual.node, part.node.empty() ? "" : "/", part.node);
        part.nodeIndex = nodes_;
        move(part, assetFromThing * visual.thingFromPart);
        chargeBytes(kBytesPerTriangle * static_cast<double>(part.triangles.size()), {file_.string()});
        parts.push_back(std::move(part));
      }
    }
    ++nodes_;
  }

  // Returns the parts of a visual, in the visual's frame. Parts of a mesh file keep the file's look, unless the visual
  // has a texture, or has a colour and the part no texture.
  std::vector<AssetPart> partsOf(const WorldPart& visual) {
    if (const Mesh* solid = std::get_if<Mesh>(&visual.shape)) {
      AssetPart part;
      part.positions = solid->positions;
      part.triangles = solid->triangles;
      applyLook(visual, part);
      return {std::move(part)};
    }
    std::vector<AssetPart> parts = partsOf(std::get<MeshFile>(visual.shape), visual.where);
    for (AssetPart& part : parts) {
      if (!visual.texture.empty() || (visual.color && part.texture.empty())) applyLook(visual, part);
      if (part.material.empty()) part.fileMaterial.name = part.material = visual.material;
    }
    return parts;
  }

  void applyLook(const WorldPart& visual, AssetPart& part) {
    using enum BaseColor::Source;
    if (part.material.empty()) part.material = visual.material;
    part.fileMaterial.name = part.material;
    const std::filesystem::path definition(visual.where.file);
    part.fileMaterial.source = "base colour of " + definition.filename().string();
    BaseColor color{.source = visual.color ? Factor : None,
                    .factor = visual.color.value_or(std::array<float, 3>{1, 1, 1})};
    if (!visual.texture.empty()) {
      const std::string name = visual.texture.string();
      part.texture = visual.texture.filename().string();
      color.source = Image;
      if (options_.alpha == AlphaUse::Test) color.alphaCutoff = kUsualAlphaCutoff;
      const auto need = options_.textures ? ColorImages::Need::AnyImage : ColorImages::Need::ImageWithAlpha;
      if (options_.textures || color.alphaCutoff) color.image = images_.load(name, name, need);
      if (color.image) color.factor = {1, 1, 1};  // the image replaces the colour
    }
    part.color = color.factor;
    setColor(part.fileMaterial, color, definition, options_, images_);
    if (!visual.texture.empty()) checkTexture(part, true, leftOut_);
  }

  // Returns the parts of a mesh, or of its submesh if one is named. `where`: the visual, for messages.
  std::vector<AssetPart> partsOf(const MeshFile& file, const Location& where) {
    const Asset& mesh = meshOf(file.path, where);
    if (file.submesh.empty()) return mesh.parts;
    std::vector<AssetPart> submeshParts;
    std::set<std::string> names;
    Box box;
    for (const AssetPart& part : mesh.parts) {
      if (!part.node.empty()) names.insert(part.node);
      if (part.node != file.submesh) continue;
      submeshParts.push_back(part);
      for (const Vec3f& p : part.positions) box.add(Vec3d(p));
    }
    if (submeshParts.empty()) {
      throw InputError(where, "'{}' has no submesh '{}', {}", file.path.string(), file.submesh,
                       names.empty() ? "since none of its parts has a name: leave out <submesh>"
                                     : fmt::format("but has {}", fmt::join(names, ", ")));
    }
    for (AssetPart& part : submeshParts) {
      for (Vec3f& p : part.positions) p = file.centred ? Vec3f(Vec3d(p) - box.center()) : p;
    }
    return submeshParts;
  }

  // Returns the asset in a mesh file, in the frame of the file. Reads each file only once.
  const Asset& meshOf(const std::filesystem::path& path, const Location& where) {
    const auto cached = meshes_.find(path);
    if (cached != meshes_.end()) return cached->second;
    AssetOptions options{.unitStated = true,  // the world states the scale of its meshes
                         .alpha = options_.alpha,
                         .textures = options_.textures,
                         .allowOutside = options_.allowOutside,
                         .textureFolders = options_.textureFolders};
    const AssetReader reader = readerOf(path);
    if (reader == AssetReader::World) throw InputError(where, "'{}' is not a mesh", path.string());
    // Gazebo and ROS ignore the up axis that a file declares, except for glTF.
    if (reader == AssetReader::Mesh) options.up = 'z';
    try {
      Asset mesh = readAsset(path, options);
      flatten(mesh);
      if (length(mesh.origin) > 0) {
        for (AssetPart& part : mesh.parts) move(part, {{}, mesh.origin});
      }
      asset_.dropped += mesh.dropped;
      return meshes_.emplace(path, std::move(mesh)).first->second;
    } catch (const InputError& e) {
      throw InputError(where, e.what());
    }
  }

  std::filesystem::path file_;
  const AssetOptions& options_;
  ColorImages images_;
  Affine assetFromWorld_;
  Asset asset_;
  LeftOut leftOut_;
  std::map<std::filesystem::path, Asset> meshes_;
  std::uint32_t nodes_ = 0;  // number of nodes so far
};

}  // namespace

void reportMissing(const std::vector<MissingFileError>& missing, bool leaveOut, LeftOut& leftOut) {
  if (leaveOut) {
    for (const MissingFileError& e : missing) leftOut.add(fmt::format("missing models and meshes ('{}')", e.name));
    return;
  }
  if (missing.empty()) return;
  const MissingFileError& first = missing.front();
  std::set<std::string> names{first.name};
  std::string furtherNames;
  for (const MissingFileError& e : missing) {
    if (!names.insert(e.name).second) continue;
    const bool isInSameFile = e.where.file == first.where.file && e.where.line > 0;
    furtherNames += fmt::format("{} '{}' ({})", furtherNames.empty() ? "" : ",", e.name,
                                isInSameFile ? fmt::format("line {}", e.where.line) : e.where.text());
  }
  throw InputError(fmt::format(
      "{}{}{}; `missing: leave_out` of the object (--leave-out-missing of `info` and `draft`) goes on without {}",
      first.what(), furtherNames.empty() ? "" : "; further ones are missing:", furtherNames,
      names.size() == 1 ? "it" : "them"));
}

std::filesystem::path findModel(const XmlNode& from, const std::filesystem::path& file, const std::string& uri) {
  if (uri.empty()) from.fail("names no file");
  const auto missing = [&](const std::string& reason) {
    return MissingFileError(from.where, uri, fmt::format("<{}> names '{}', {}", from.name, uri, reason));
  };
  if (uri.starts_with("http://") || uri.starts_with("https://")) {
    throw missing("which is not a local file: download it and name the file");
  }
  for (const std::string_view scheme : {"model://", "package://"}) {
    if (!uri.starts_with(scheme)) continue;
    const std::string name = uri.substr(scheme.size());
    if (const auto path = findInModelFolders(file, name)) return *path;
    const std::string model = name.substr(0, name.find('/'));
    if (const auto folder = findInModelFolders(file, model); folder && model.size() < name.size()) {
      throw missing(fmt::format("but '{}' has no file '{}'", folder->string(), name.substr(model.size() + 1)));
    }
    throw missing(
        fmt::format("which is neither in '{}', nor in the folders above it, nor in the folders of the variables {}: a "
                    "folder must have the name '{}' (a name in package.xml does not count)",
                    file.parent_path().string(), modelFolderVariables(), model));
  }
  const std::string name = uri.starts_with("file://") ? uri.substr(7) : uri;
  for (const std::string& spelling : {name, decodeUri(name)}) {
    std::filesystem::path path = file.parent_path() / spelling;
    if (pathExists(path)) return path;
  }
  // A relative name may also be the name of a model.
  if (const auto path = findInModelFolders(file, name)) return *path;
  throw missing("but this file does not exist");
}

Asset readWorld(const std::filesystem::path& file, std::string_view suffix, const AssetOptions& options) {
  if (suffix == ".json") return readTileset(file, options);
  const bool sdf = suffix == ".sdf" || suffix == ".world";
  return WorldAsset(file, options).build(sdf ? readSdf(file) : readUrdf(file, options.joints));
}

}  // namespace scanmill
