#include "assets/meshes/assimp/reader.h"

#include <assimp/commonMetaData.h>
#include <assimp/config.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <assimp/IOSystem.hpp>
#include <assimp/Importer.hpp>
#include <cmath>
#include <cstdint>
#include <exception>
#include <map>
#include <new>
#include <optional>
#include <set>
#include <stdexcept>
#include <string_view>
#include <utility>

#include "assets/meshes/asset_parts.h"
#include "assets/meshes/assimp/ac3d.h"
#include "assets/meshes/assimp/collada.h"
#include "assets/meshes/assimp/fbx.h"
#include "assets/meshes/assimp/parts.h"
#include "assets/meshes/assimp/studio_3ds.h"
#include "assets/meshes/imported_asset.h"
#include "assets/meshes/polygon.h"
#include "base/error.h"

namespace scanmill {

namespace {

constexpr std::string_view kCollada = "Collada Importer";
constexpr std::string_view kFbx = "Autodesk FBX Importer";
constexpr std::string_view kXFile = "Direct3D XFile Importer";

Affine toAffine(const aiMatrix4x4& m) {
  return {{{m.a1, m.b1, m.c1}, {m.a2, m.b2, m.c2}, {m.a3, m.b3, m.c3}}, {m.a4, m.b4, m.c4}};
}

// Returns an entry of the metadata of a scene or a node.
template <class T>
T metadataOf(const auto& owner, const char* key, T fallback) {
  T value{};
  return owner.mMetaData != nullptr && owner.mMetaData->Get(key, value) ? value : fallback;
}

class Importer {
 public:
  Importer(const std::filesystem::path& file, const std::string& kind, const AssetOptions& options)
      : file_(file), options_(options), kind_(kind) {
    importer_.SetIOHandler(filesFor(file, options.allowOutside, refused_).release());
  }

  ImportedFile read() {
    ImportedFile read;
    import();
    format_ = metadataOf(*scene_, AI_METADATA_SOURCE_FORMAT, aiString()).C_Str();
    nameJointsById();
    const std::optional<char> declared = declaredUp();
    read.up = options_.up.value_or(declared.value_or('z'));
    read.upDeclared = declared.has_value();
    read.statedUnit = statedUnit();
    countRest();
    read.outOfRange = dropBadFaces();
    undoTurnOfFbx();
    makeUvs();
    read.materials = materialsOf(*scene_, format_ == kXFile, placements_);
    mendMaterials(read.materials);
    read.images = imagesOf(*scene_);
    walk(read);
    read.problems = log_.problems;
    read.leftOut = std::move(leftOut_);
    return read;
  }

 private:
  [[noreturn]] static void fail(const std::string& what) { throw Error(what); }

  void import() {
    configure(importer_);
    if (kind_ == ".dae") collada_ = colladaFacts(file_);
    leftOut_.add(collada_.leftOut);
    try {
      scene_ = open();
      if (scene_ == nullptr && importer_.GetException() != nullptr) std::rethrow_exception(importer_.GetException());
    } catch (const std::bad_alloc&) {
      throw;
    } catch (const std::length_error&) {
      throw;
    } catch (const std::exception& e) {
      failReading(reason(e.what()));
    }
    if (!refused_.empty()) fail(refused_);
    if (scene_ == nullptr) failReading(reason(importer_.GetErrorString()));
    if (scene_->mRootNode == nullptr) failReading("it has no nodes");
  }

  [[noreturn]] void failReading(const std::string& why) const {
    fail(fmt::format("cannot be read: {}; {}", why, remedyFor(kind_)));
  }

  const aiScene* open() {
    const bool known = isAc3d(kind_) || kind_ == ".fbx" || kind_ == ".3ds";
    if (!known) return open(importer_);
    const std::string text = kind_ == ".fbx"   ? readFbx(file_, leftOut_, fbxImages_)
                             : kind_ == ".3ds" ? read3ds(file_, leftOut_)
                                               : readAc3d(file_, leftOut_);
    return importer_.ReadFileFromMemory(text.data(), text.size(), 0, isAc3d(kind_) ? "ac" : kind_.c_str() + 1);
  }

  const aiScene* open(Assimp::Importer& importer) const {
    if (kind_ != ".dae") return importer.ReadFile(file_.string(), 0);
    return importer.ReadFileFromMemory(collada_.text.data(), collada_.text.size(), 0, "dae");
  }

  void configure(Assimp::Importer& importer) const {
    importer.SetPropertyBool(AI_CONFIG_IMPORT_COLLADA_USE_COLLADA_NAMES, true);
    importer.SetPropertyBool(AI_CONFIG_IMPORT_COLLADA_IGNORE_UP_DIRECTION, options_.up.has_value());
    importer.SetPropertyBool(AI_CONFIG_IMPORT_NO_SKELETON_MESHES, true);
    importer.SetPropertyBool(AI_CONFIG_IMPORT_FBX_READ_ANIMATIONS, false);
    // Removes the importer's readers of glTF, which would skip this program's checks. The importer would choose them
    // for glTF content in files with any suffix.
    for (const char* kind : {"gltf", "glb"}) {
      while (auto* loader = importer.GetImporter(kind)) importer.UnregisterLoader(loader);
    }
  }

  // Names the joints of a COLLADA file by the ids of their nodes. The importer names them by the nodes' names, which
  // may be absent or not unique, unless it reads the file by ids.
  void nameJointsById() const {
    const auto hasBones = [](const aiMesh* mesh) { return mesh->mNumBones > 0; };
    if (format_ != kCollada || std::none_of(scene_->mMeshes, scene_->mMeshes + scene_->mNumMeshes, hasBones)) return;
    std::string refused;
    Assimp::Importer again;
    again.SetIOHandler(filesFor(file_, options_.allowOutside, refused).release());
    configure(again);
    again.SetPropertyBool(AI_CONFIG_IMPORT_COLLADA_USE_COLLADA_NAMES, false);
    const aiScene* const byId = open(again);
    if (byId == nullptr || byId->mNumMeshes != scene_->mNumMeshes) return;
    for (unsigned m = 0; m < scene_->mNumMeshes; ++m) {
      const aiMesh& from = *byId->mMeshes[m];
      for (unsigned b = 0; b < std::min(from.mNumBones, scene_->mMeshes[m]->mNumBones); ++b) {
        scene_->mMeshes[m]->mBones[b]->mName = from.mBones[b]->mName;
      }
    }
  }

  // Counts what the importer has read and is not used.
  void countRest() {
    leftOut_.add("animations (the file's pose is taken)", scene_->mNumAnimations);
    if (metadataOf(*scene_, "UpAxisSign", 1) < 0 && !axesOfFbx()) {
      leftOut_.add("negative signs of the up axis (UpAxisSign)");
    }
    for (unsigned m = 0; m < scene_->mNumMeshes; ++m) {
      const aiMesh& mesh = *scene_->mMeshes[m];
      if (mesh.HasVertexColors(0)) leftOut_.add("colours of vertices", mesh.mNumVertices);
      // The importer sets the weights of FBX files to 1; readFbx() counts those that are not 0.
      if (format_ != kFbx) leftOut_.add("morph targets", mesh.mNumAnimMeshes);
      for (unsigned f = 0; f < mesh.mNumFaces; ++f) {
        if (mesh.mFaces[f].mNumIndices == 1) leftOut_.add("points");
        if (mesh.mFaces[f].mNumIndices == 2) leftOut_.add("lines");
      }
    }
  }

  // Adds to the materials what the importer does not report, and takes from them what it reads wrong.
  void mendMaterials(std::vector<ImportedMaterial>& materials) {
    for (std::size_t i = 0; i < std::min(materials.size(), collada_.materials.size()); ++i) {
      const ColladaMaterial& stated = collada_.materials[i];
      ImportedMaterial& material = materials[i];
      if (!stated.colored) {
        leftOut_.add("materials without a plain diffuse colour");
        material.stated = false;
        material.color = {1, 1, 1};
      }
      material.base.repeats = material.base.repeats && !stated.clamps;
      if (!stated.transparency) continue;
      material.opacity = 1;
      material.opacityMap.inverted = stated.inverted;
      if (stated.inverted && *stated.transparency == 0) {
        material.opacityMap = {};  // opaque everywhere
      } else if (*stated.transparency != 1) {
        leftOut_.add("numbers of `transparency` beside images (the images alone count)");
      }
    }
    for (std::size_t i = 0; i < materials.size(); ++i) {
      ImportedMap& base = materials[i].base;
      if (fbxImages_.clamped.contains(base.label)) base.repeats = false;
      const auto set = fbxImages_.uvSets.find(base.name.empty() ? materials[i].opacityMap.label : base.label);
      if (set != fbxImages_.uvSets.end()) placements_[i].set = set->second;
    }
    // The importer takes these angles, which are in degrees, for radians, and no specification states their sign.
    for (UvPlacement& placement : placements_) {
      if (placement.rotation == 0 || (format_ != kFbx && format_ != kCollada)) continue;
      leftOut_.add(format_ == kFbx ? "rotations of images (Rotation)" : "rotations of images (rotateUV)");
      placement.rotation = 0;
    }
  }

  // Returns an error message of the importer without its end.
  static std::string reason(std::string text) {
    while (!text.empty() && (text.back() == '\n' || text.back() == '.' || text.back() == ' ')) text.pop_back();
    return text.empty() ? "the file is damaged" : text;
  }

  // Empties faces with an index out of range, since triangulation would read beyond the vertices. Returns the number of
  // lost triangles.
  std::uint64_t dropBadFaces() const {
    std::uint64_t dropped = 0;
    for (unsigned m = 0; m < scene_->mNumMeshes; ++m) {
      aiMesh& mesh = *scene_->mMeshes[m];
      const unsigned vertices = mesh.mVertices != nullptr ? mesh.mNumVertices : 0;
      for (unsigned f = 0; f < mesh.mNumFaces; ++f) {
        aiFace& face = mesh.mFaces[f];
        if (std::all_of(face.mIndices, face.mIndices + face.mNumIndices, [&](unsigned i) { return i < vertices; })) {
          continue;
        }
        dropped += face.mNumIndices > 2 ? face.mNumIndices - 2 : 0;
        face.mNumIndices = 0;
      }
    }
    return dropped;
  }

  // Resets the root transform of FBX files, in which assimp 5.4 stores the rotation to the declared axes. For all
  // versions of assimp, assetFromImported() rotates by the up axis and scales by the unit, so the root transform would
  // rotate a second time.
  void undoTurnOfFbx() const {
    if (format_ == kFbx && scene_->mRootNode != nullptr) scene_->mRootNode->mTransformation = aiMatrix4x4();
  }

  // Makes the texture coordinates of materials that state a projection instead. Polygons are divided in append(), since
  // the importer divides concave ones wrong.
  void makeUvs() {
    scene_ = importer_.ApplyPostProcessing(aiProcess_GenUVCoords);
    if (scene_ == nullptr)
      fail(fmt::format("cannot be read: {}; {}", reason(importer_.GetErrorString()), remedyFor(kind_)));
  }

  // Returns the transform from the importer's frame to metres and z up.
  Affine assetFromImported(char up) const {
    double scale = options_.metresPerUnit;
    if (format_ == kCollada && !options_.up) up = 'y';  // the importer has rotated the declared axis to y
    if (format_ == kFbx) scale *= statedUnit();
    if (!(scale > 0) || !std::isfinite(scale)) fail("declares a unit that is not above 0");
    const bool turned = format_ == "Discreet 3DS Importer";  // which rotates files from z-up to y-up
    const Mat3 fileFromImported = turned ? zUpFrom('y') : Mat3();
    return {axesOfFbx().value_or(zUpFrom(up)) * fileFromImported * Mat3::scale({scale, scale, scale}), {}};
  }

  // Returns the transform from the axes that an FBX file states to x right, y back and z up; it mirrors if these are
  // left-handed. Returns nullopt for other kinds, if the axes are not three different ones, and if the key `up` is
  // given.
  std::optional<Mat3> axesOfFbx() const {
    if (format_ != kFbx || options_.up) return std::nullopt;
    std::array<Vec3d, 3> columns{};
    for (const auto& [name, to] :
         {std::pair<std::string, Vec3d>{"CoordAxis", {1, 0, 0}}, {"FrontAxis", {0, -1, 0}}, {"UpAxis", {0, 0, 1}}}) {
      const auto axis = static_cast<std::size_t>(metadataOf(*scene_, name.c_str(), std::int32_t{-1}));
      if (axis > 2 || length(columns[axis]) > 0) return std::nullopt;
      columns[axis] = to * (metadataOf(*scene_, (name + "Sign").c_str(), std::int32_t{1}) < 0 ? -1.0 : 1.0);
    }
    return Mat3{columns[0], columns[1], columns[2]};
  }

  // Returns the unit that the file states (m); 0 if it states none.
  double statedUnit() const {
    return format_ == kFbx ? static_cast<double>(metadataOf(*scene_, "UnitScaleFactor", 1.0f)) * 0.01 : collada_.unit;
  }

  // Returns the up axis that the file states or its kind prescribes; nullopt if neither does.
  std::optional<char> declaredUp() const {
    if (format_ == kFbx) {
      const std::int32_t axis = metadataOf(*scene_, "UpAxis", std::int32_t{1});
      return axis >= 0 && axis <= 2 ? "xyz"[axis] : 'y';
    }
    if (format_ == kCollada) return collada_.up;
    if (format_ == "AC3D Importer") return 'y';
    return std::nullopt;
  }

  static std::string nodeName(const aiNode& node) {
    std::string name = node.mName.C_Str();
    if (const auto pivot = name.find("_$AssimpFbx$_"); pivot != std::string::npos) name.resize(pivot);
    // The importer invents this name for COLLADA nodes without a name.
    if (!name.starts_with("$ColladaAutoName$")) return name;
    return metadataOf(node, "Collada_id", aiString()).C_Str();
  }

  struct Placed {
    const aiNode* node;
    Affine assetFromNode;
    std::string name;  // name of the node or of its nearest named ancestor; the root's children do not inherit its
                       // name, which the importer often invents
    bool shown;        // false: hidden, with all nodes below it
    // Only set in FBX files: the frame and the scale of the object above, and the object's transform in that frame.
    Affine assetFromParent{};
    Vec3d parentScale{1, 1, 1};
    Affine parentFromObject{};
  };

  static Vec3d scaleOf(const Mat3& m) { return {length(m.x), length(m.y), length(m.z)}; }

  // Changes the transform of an object of an FBX file that does not inherit its parent's scale as the importer assumes
  // (FBX SDK: InheritType 1, the parent's scale acts after the object's rotation): with 0 it acts before the object's
  // rotation, and with 2 it does too, without what the parent itself adds to it.
  void inheritScale(Placed& item) {
    // The importer divides an object into several nodes, the last of which has the object's name.
    const std::string_view name = item.node->mName.C_Str();
    if (name.find("_$AssimpFbx$_Geometric") == std::string_view::npos) {
      item.parentFromObject = item.parentFromObject * toAffine(item.node->mTransformation);
    }
    if (name.find("_$AssimpFbx$_") != std::string_view::npos) return;
    const Affine assumed = item.assetFromParent * item.parentFromObject;
    Affine object = assumed;
    if (const auto type = metadataOf(*item.node, "InheritType", std::int32_t{0}); type != 1) {
      const Mat3& p = item.assetFromParent.linear;
      const Vec3d all = scaleOf(p);
      const Vec3d own = type == 2 ? item.parentScale : Vec3d{1, 1, 1};
      const Mat3 turned{p.x * (1 / all.x), p.y * (1 / all.y), p.z * (1 / all.z)};
      object.linear =
          turned * item.parentFromObject.linear * Mat3::scale({all.x / own.x, all.y / own.y, all.z / own.z});
      const double moved = length(object.linear.x - assumed.linear.x) + length(object.linear.y - assumed.linear.y) +
                           length(object.linear.z - assumed.linear.z);
      const Vec3d size = scaleOf(assumed.linear);
      constexpr double kRounding = 1e-5;  // the importer's numbers are in single precision
      const bool sheared = std::max({std::abs(dot(turned.x, turned.y)), std::abs(dot(turned.y, turned.z)),
                                     std::abs(dot(turned.z, turned.x))}) > kRounding;
      if (moved <= kRounding * (size.x + size.y + size.z)) {
        object = assumed;
      } else if (sheared || isSingular(assumed.linear) || !std::isfinite(moved)) {
        leftOut_.add("scales that objects inherit from sheared or flat parents (InheritType)");
        object = assumed;
      } else {
        item.assetFromNode = object * inverse(assumed) * item.assetFromNode;
      }
    }
    item.assetFromParent = object;
    item.parentScale = scaleOf(item.parentFromObject.linear);
    item.parentFromObject = {};
  }

  void walk(ImportedFile& read) {
    std::vector<Placed> placed;  // in the order of the file, depth first
    const Affine frame = assetFromImported(read.up);
    std::vector<Placed> open{{scene_->mRootNode, frame, {}, true, frame}};
    while (!open.empty()) {
      Placed item = std::move(open.back());
      open.pop_back();
      if (std::string own = nodeName(*item.node); !own.empty()) item.name = std::move(own);
      item.assetFromNode = item.assetFromNode * toAffine(item.node->mTransformation);
      if (format_ == kFbx) inheritScale(item);
      item.shown = item.shown && !hidesTree(*item.node);
      const std::string inherited = item.node == scene_->mRootNode ? std::string() : item.name;
      for (unsigned i = item.node->mNumChildren; i-- > 0;) {
        if (const aiNode* child = item.node->mChildren[i]) {
          open.push_back({child, item.assetFromNode, inherited, item.shown, item.assetFromParent, item.parentScale,
                          item.parentFromObject});
        }
      }
      joints_.emplace(jointName(*item.node), item.assetFromNode);
      placed.push_back(std::move(item));
    }
    for (std::uint32_t index = 0; index < placed.size(); ++index) {
      const Placed& item = placed[index];
      if (item.shown && metadataOf(*item.node, "Show", true)) {
        addNode(read, *item.node, item.name, index, item.assetFromNode);
      } else if (item.node->mNumMeshes > 0) {
        leftOut_.add("hidden nodes");
      }
    }
    for (AssetPart& part : read.parts) weld(part.positions, part.uvs, part.triangles);
    std::erase_if(read.parts, [](const AssetPart& part) { return part.triangles.empty(); });
  }

  // True if a node and all below it are hidden.
  bool hidesTree(const aiNode& node) const {
    return metadataOf(node, kFbxVisibility, 1.0f) <= 0 ||
           collada_.hidden.contains(metadataOf(node, "Collada_id", aiString()).C_Str());
  }

  // Returns the name by which joints refer to a node: of COLLADA files see nameJointsById().
  static std::string jointName(const aiNode& node) {
    return metadataOf(node, "Collada_id", metadataOf(node, "Collada_sid", node.mName)).C_Str();
  }

  void addNode(ImportedFile& read, const aiNode& node, const std::string& name, std::uint32_t index,
               const Affine& assetFromNode) {
    const std::size_t first = read.parts.size();
    // The parts of this node so far: their material, and whether they lack the texture coordinates that it needs.
    std::vector<std::pair<unsigned, bool>> known;
    for (unsigned i = 0; i < node.mNumMeshes; ++i) {
      if (node.mMeshes[i] >= scene_->mNumMeshes) continue;
      const aiMesh& mesh = *scene_->mMeshes[node.mMeshes[i]];
      if (mesh.mNumVertices == 0 || mesh.mVertices == nullptr || mesh.mNumFaces == 0) continue;
      triangles_ += mesh.mNumFaces;
      if (triangles_ > kMostTriangles)
        fail(fmt::format("has more than {} triangles, with all copies: split it", kMostTriangles));
      const std::pair key(mesh.mMaterialIndex,
                          !mesh.HasTextureCoords(0) && hasImage(read.materials, mesh.mMaterialIndex));
      const auto found = std::find(known.begin(), known.end(), key);
      const std::size_t part = first + static_cast<std::size_t>(found - known.begin());
      if (found == known.end()) {
        known.push_back(key);
        read.parts.emplace_back();
        read.parts.back().node = name;
        read.parts.back().nodeIndex = index;
        read.parts.back().materialIndex = mesh.mMaterialIndex;
      }
      append(read.parts[part], mesh, assetFromNode);
    }
  }

  static bool hasImage(const std::vector<ImportedMaterial>& materials, unsigned i) {
    return i < materials.size() && !(materials[i].base.name.empty() && materials[i].opacityMap.name.empty());
  }

  void append(AssetPart& part, const aiMesh& mesh, const Affine& assetFromNode) {
    const std::size_t base = part.positions.size();
    if (base + mesh.mNumVertices > UINT32_MAX) fail("has more vertices than 32-bit indices allow: split it");
    part.positions.resize(base + mesh.mNumVertices);
    const auto assetFromMesh = [&](const aiBone& bone) -> std::optional<Affine> {
      const auto joint = joints_.find(bone.mName.C_Str());
      if (joint == joints_.end()) return std::nullopt;
      return joint->second * toAffine(bone.mOffsetMatrix);
    };
    const std::optional<SkinnedMesh> posed = skinned(mesh, assetFromNode, assetFromMesh, leftOut_);
    for (unsigned i = 0; i < mesh.mNumVertices; ++i) {
      const aiVector3D& v = mesh.mVertices[i];
      part.positions[base + i] = static_cast<Vec3f>(posed ? posed->vertices[i] : assetFromNode * Vec3d{v.x, v.y, v.z});
    }
    appendUvs(part, mesh, base);
    // If the transform mirrors, swaps two corners, so that surfaces are not turned inside out.
    const bool mirrored = posed ? posed->mirrored : determinant(assetFromNode.linear) < 0;
    const auto offset = static_cast<std::uint32_t>(base);
    part.triangles.reserve(part.triangles.size() + mesh.mNumFaces);
    for (unsigned f = 0; f < mesh.mNumFaces; ++f) {
      const aiFace& face = mesh.mFaces[f];
      if (face.mNumIndices < 3) continue;
      const unsigned* at = face.mIndices;
      const auto corner = [&](std::size_t i) {
        const aiVector3D& v = mesh.mVertices[at[i]];
        return Vec3d{v.x, v.y, v.z};
      };
      for (const auto& t : polygons_.divide(face.mNumIndices, corner)) {
        part.triangles.push_back(
            {offset + at[t[0]], offset + at[t[mirrored ? 2 : 1]], offset + at[t[mirrored ? 1 : 2]]});
      }
    }
  }

  // Returns the index of the set of texture coordinates that a mesh's image uses.
  unsigned channelOf(const aiMesh& mesh, const UvPlacement& placement) {
    if (placement.set.empty()) {
      const unsigned channel = placement.channel;
      return channel < AI_MAX_NUMBER_OF_TEXTURECOORDS && mesh.HasTextureCoords(channel) ? channel : 0;
    }
    for (unsigned i = 0; i < mesh.GetNumUVChannels(); ++i) {
      if (mesh.HasTextureCoordsName(i) && placement.set == mesh.GetTextureCoordsName(i)->C_Str()) return i;
    }
    if (mesh.GetNumUVChannels() > 1) {
      leftOut_.add("sets of texture coordinates that meshes lack (UVSet; their first is taken)");
    }
    return 0;
  }

  void appendUvs(AssetPart& part, const aiMesh& mesh, std::size_t base) {
    const UvPlacement placement =
        mesh.mMaterialIndex < placements_.size() ? placements_[mesh.mMaterialIndex] : UvPlacement{};
    const unsigned channel = channelOf(mesh, placement);
    const bool has = mesh.HasTextureCoords(channel);
    if (!has && part.uvs.empty()) return;
    part.uvs.resize(base + mesh.mNumVertices);  // zeros for meshes without texture coordinates
    for (unsigned i = 0; has && i < mesh.mNumVertices; ++i) {
      part.uvs[base + i] = placement.apply({mesh.mTextureCoords[channel][i].x, mesh.mTextureCoords[channel][i].y});
    }
  }

  const std::filesystem::path& file_;
  const AssetOptions& options_;
  const std::string& kind_;
  ImporterLog log_;
  std::string refused_;  // message about the first file that was refused; empty: none
  Assimp::Importer importer_;
  const aiScene* scene_ = nullptr;       // owned by importer_
  std::string format_;                   // the importer's name for the kind of the file
  std::vector<UvPlacement> placements_;  // by material
  std::uint64_t triangles_ = 0;
  Triangulator polygons_{std::filesystem::path()};  // without the file's name, which the parent process adds
  ColladaFacts collada_;
  FbxImages fbxImages_;
  std::map<std::string, Affine> joints_;  // assetFromNode by jointName() of the node
  LeftOut leftOut_;
};

}  // namespace

const FormatSupport& importedFormat() {
  using enum FormatElements::Use;
  static const FormatSupport format{
      "other files that the assimp library reads",
      ".3ds, .x",
      {{Read, "", "nodes with their names and transforms, polygons, texture coordinates"},
       {Read, "", "skins of .x, in the pose in which the nodes stand"},
       {Read, "", "colours, opacity and images of materials, with their scale, shift and rotation"},
       {Read, "", "colours are taken as linear light, since these formats state no colour space"},
       {Unused, "", "cameras, lights, normals"},
       {LeftOut, "", "animations (the file's pose is taken)"},
       {LeftOut, "", "morph targets"},
       {LeftOut, "", "colours of vertices"},
       {LeftOut, "", "lines"},
       {LeftOut, "", "points"},
       {LeftOut, "", "hidden nodes (.3ds)"},
       {LeftOut, "", "master scales (.3ds; lengths are divided by them)"},
       {LeftOut, "", "joints of skins that no node has"},
       {LeftOut, "", "opacities of materials (they are solid)"},
       {LeftOut, "", "clamped or mirrored textures (they repeat)"},
       {LeftOut, "", "textures of parts without texture coordinates"}}};
  return format;
}

ImportedFile readByAssimp(const std::filesystem::path& file, const std::string& kind, const AssetOptions& options) {
  return Importer(file, kind, options).read();
}

}  // namespace scanmill
