#include "assets/assimp_reader.h"

#include <assimp/commonMetaData.h>
#include <assimp/config.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <fmt/core.h>

#include <algorithm>
#include <assimp/IOSystem.hpp>
#include <assimp/Importer.hpp>
#include <cmath>
#include <cstdint>
#include <exception>
#include <fstream>
#include <optional>
#include <string_view>
#include <utility>

#include "assets/ac3d.h"
#include "assets/asset_parts.h"
#include "assets/assimp_parts.h"
#include "assets/imported_asset.h"
#include "base/error.h"

namespace scanmill {

namespace {

// Largest sum of squared corner counts over all polygons. The importer's time to triangulate a polygon grows with the
// square of its corners: a second for 40,000 corners.
constexpr double kMostCornersSquared = 4e9;

constexpr std::string_view kCollada = "Collada Importer";
constexpr std::string_view kFbx = "Autodesk FBX Importer";

Affine toAffine(const aiMatrix4x4& m) {
  return {{{m.a1, m.b1, m.c1}, {m.a2, m.b2, m.c2}, {m.a3, m.b3, m.c3}}, {m.a4, m.b4, m.c4}};
}

template <class T>
T metadata(const aiScene& scene, const char* key, T fallback) {
  T value{};
  return scene.mMetaData != nullptr && scene.mMetaData->Get(key, value) ? value : fallback;
}

class Importer {
 public:
  Importer(const std::filesystem::path& file, const std::string& kind, const AssetOptions& options)
      : file_(file), options_(options), kind_(kind) {
    importer_.SetIOHandler(filesFor(file, options.allowOutside, refused_).release());
  }

  ImportedFile read() {
    import();
    ImportedFile read;
    const std::optional<char> declared = declaredUp();
    read.up = options_.up.value_or(declared.value_or('z'));
    read.upDeclared = declared.has_value();
    read.outOfRange = dropBadFaces();
    undoTurnOfFbx();
    triangulate();
    read.materials = materialsOf(*scene_);
    read.images = imagesOf(*scene_);
    for (const ImportedMaterial& material : read.materials) uvChannels_.push_back(material.uvChannel());
    walk(read);
    return read;
  }

 private:
  [[noreturn]] static void fail(const std::string& what) { throw Error(what); }

  void import() {
    configure();
    if (kind_.empty() || !importer_.IsExtensionSupported(kind_)) {
      fail(fmt::format("has an unknown kind ('{}'): convert it to glTF, GLB, OBJ, PLY, STL, DAE, FBX, AC or BLEND",
                       kind_));
    }
    try {
      scene_ = open();
    } catch (const std::bad_alloc&) {
      throw;
    } catch (const std::exception& e) {
      failReading(e.what());
    }
    if (!refused_.empty()) fail(refused_);
    if (scene_ == nullptr) failReading(reason());
    if (scene_->mRootNode == nullptr) failReading("it has no nodes");
  }

  [[noreturn]] void failReading(const std::string& why) const {
    fail(fmt::format("cannot be read: {}; {}", why, remedyFor(kind_)));
  }

  const aiScene* open() {
    if (!isAc3d(kind_)) return importer_.ReadFile(file_.string(), 0);
    const std::string text = readAc3d(file_);
    return importer_.ReadFileFromMemory(text.data(), text.size(), 0, "ac");
  }

  void configure() {
    importer_.SetPropertyBool(AI_CONFIG_IMPORT_COLLADA_USE_COLLADA_NAMES, true);
    importer_.SetPropertyBool(AI_CONFIG_IMPORT_COLLADA_IGNORE_UP_DIRECTION, options_.up.has_value());
    importer_.SetPropertyBool(AI_CONFIG_IMPORT_NO_SKELETON_MESHES, true);
    importer_.SetPropertyBool(AI_CONFIG_IMPORT_FBX_READ_ANIMATIONS, false);
    // Removes the importer's readers of glTF, which would skip this program's checks. The importer would choose them
    // for glTF content in files with any suffix.
    for (const char* kind : {"gltf", "glb"}) {
      while (auto* loader = importer_.GetImporter(kind)) importer_.UnregisterLoader(loader);
    }
  }

  std::string reason() const {
    std::string text = importer_.GetErrorString();
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
    if (importedAs() == kFbx && scene_->mRootNode != nullptr) scene_->mRootNode->mTransformation = aiMatrix4x4();
  }

  void triangulate() {
    unsigned steps = aiProcess_TransformUVCoords;
    double squared = 0;
    unsigned most = 0;
    for (unsigned m = 0; m < scene_->mNumMeshes; ++m) {
      const aiMesh& mesh = *scene_->mMeshes[m];
      for (unsigned f = 0; f < mesh.mNumFaces; ++f) {
        const unsigned corners = mesh.mFaces[f].mNumIndices;
        if (corners <= 3) continue;
        steps |= aiProcess_Triangulate;
        squared += static_cast<double>(corners) * corners;
        most = std::max(most, corners);
      }
    }
    if (squared > kMostCornersSquared) {
      fail(
          fmt::format("has polygons of up to {} corners, which would take minutes to divide into triangles: export it "
                      "with triangles",
                      most));
    }
    scene_ = importer_.ApplyPostProcessing(steps);
    if (scene_ == nullptr) fail(fmt::format("cannot be divided into triangles: {}; {}", reason(), remedyFor(kind_)));
  }

  // Returns the transform from the importer's frame to metres and z up.
  Affine assetFromImported(char up) const {
    double scale = options_.metresPerUnit;
    const std::string format = importedAs();
    if (format == kCollada && !options_.up) up = 'y';  // the importer has rotated the declared axis to y
    if (format == kFbx) {
      scale *=
          static_cast<double>(metadata(*scene_, "UnitScaleFactor", 1.0f)) * 0.01;  // FBX states its unit in centimetres
    }
    if (!(scale > 0) || !std::isfinite(scale)) fail("declares a unit that is not above 0");
    // The importer rotates files of these kinds from z-up to y-up.
    const bool turned = format == "Discreet 3DS Importer" || format == "ASE Importer" ||
                        format == "Drawing Interchange Format (DXF) Importer";
    const Mat3 fileFromImported = turned ? zUpFrom('y') : Mat3();
    return {zUpFrom(up) * fileFromImported * Mat3::scale({scale, scale, scale}), {}};
  }

  // Returns the up axis that the file states or its kind prescribes; nullopt if neither does.
  std::optional<char> declaredUp() const {
    const std::string format = importedAs();
    if (format == kFbx) {
      const std::int32_t axis = metadata(*scene_, "UpAxis", std::int32_t{1});
      return axis >= 0 && axis <= 2 ? "xyz"[axis] : 'y';
    }
    if (format == kCollada) return colladaUp();
    if (format == "AC3D Importer") return 'y';
    return std::nullopt;
  }

  // Returns the up_axis of a COLLADA file from its first bytes, since the importer does not report it. By the schema,
  // the element `asset` comes first.
  char colladaUp() const {
    std::string head(1 << 16, '\0');
    std::ifstream in(file_, std::ios::binary);
    in.read(head.data(), static_cast<std::streamsize>(head.size()));
    head.resize(static_cast<std::size_t>(in.gcount()));
    constexpr std::string_view kTag = "<up_axis>";
    const std::size_t tag = head.find(kTag);
    if (tag == std::string::npos) return 'y';
    const std::size_t axis = head.find_first_not_of(" \t\r\n", tag + kTag.size());
    if (axis == std::string::npos) return 'y';
    return head[axis] == 'X' ? 'x' : head[axis] == 'Z' ? 'z' : 'y';
  }

  std::string importedAs() const { return metadata(*scene_, AI_METADATA_SOURCE_FORMAT, aiString()).C_Str(); }

  static std::string nodeName(const aiNode& node) {
    std::string name = node.mName.C_Str();
    if (const auto pivot = name.find("_$AssimpFbx$_"); pivot != std::string::npos) name.resize(pivot);
    // The importer invents this name for COLLADA nodes without a name.
    if (!name.starts_with("$ColladaAutoName$")) return name;
    aiString id;
    return node.mMetaData != nullptr && node.mMetaData->Get("Collada_id", id) ? id.C_Str() : "";
  }

  void walk(ImportedFile& read) {
    struct Item {
      const aiNode* node;
      Affine assetFromParent;
      std::string name;  // name of the nearest named ancestor; never the root's name, which the importer often invents
    };
    std::vector<Item> open{{scene_->mRootNode, assetFromImported(read.up), {}}};
    for (std::uint32_t index = 0; !open.empty(); ++index) {
      const Item item = std::move(open.back());
      open.pop_back();
      std::string name = nodeName(*item.node);
      if (name.empty()) name = item.name;
      const Affine assetFromNode = item.assetFromParent * toAffine(item.node->mTransformation);
      addNode(read, *item.node, name, index, assetFromNode);
      const std::string inherited = item.node == scene_->mRootNode ? std::string() : name;
      for (unsigned i = item.node->mNumChildren; i-- > 0;) {
        if (const aiNode* child = item.node->mChildren[i]) open.push_back({child, assetFromNode, inherited});
      }
    }
    for (ImportedPart& part : read.parts) weld(part.positions, part.uvs, part.triangles);
    std::erase_if(read.parts, [](const ImportedPart& part) { return part.triangles.empty(); });
  }

  void addNode(ImportedFile& read, const aiNode& node, const std::string& name, std::uint32_t index,
               const Affine& assetFromNode) {
    const std::size_t first = read.parts.size();
    std::vector<unsigned> materials;  // materials of this node's parts so far
    for (unsigned i = 0; i < node.mNumMeshes; ++i) {
      if (node.mMeshes[i] >= scene_->mNumMeshes) continue;
      const aiMesh& mesh = *scene_->mMeshes[node.mMeshes[i]];
      if (mesh.mNumVertices == 0 || mesh.mVertices == nullptr || mesh.mNumFaces == 0) continue;
      triangles_ += mesh.mNumFaces;
      if (triangles_ > kMostTriangles)
        fail(fmt::format("has more than {} triangles, with all copies: split it", kMostTriangles));
      const auto known = std::find(materials.begin(), materials.end(), mesh.mMaterialIndex);
      const std::size_t part = first + static_cast<std::size_t>(known - materials.begin());
      if (known == materials.end()) {
        materials.push_back(mesh.mMaterialIndex);
        read.parts.emplace_back();
        read.parts.back().node = name;
        read.parts.back().nodeIndex = index;
        read.parts.back().material = mesh.mMaterialIndex;
      }
      append(read.parts[part], mesh, assetFromNode);
    }
  }

  void append(ImportedPart& part, const aiMesh& mesh, const Affine& assetFromNode) const {
    const std::size_t base = part.positions.size();
    if (base + mesh.mNumVertices > UINT32_MAX) fail("has more vertices than 32-bit indices allow: split it");
    part.positions.resize(base + mesh.mNumVertices);
    for (unsigned i = 0; i < mesh.mNumVertices; ++i) {
      const aiVector3D& v = mesh.mVertices[i];
      part.positions[base + i] = static_cast<Vec3f>(assetFromNode * Vec3d{v.x, v.y, v.z});
    }
    appendUvs(part, mesh, base);
    // If the transform mirrors, swaps two corners, so that surfaces are not turned inside out.
    const bool mirrored = determinant(assetFromNode.linear) < 0;
    const auto offset = static_cast<std::uint32_t>(base);
    part.triangles.reserve(part.triangles.size() + mesh.mNumFaces);
    for (unsigned f = 0; f < mesh.mNumFaces; ++f) {
      const aiFace& face = mesh.mFaces[f];
      if (face.mNumIndices != 3) continue;
      const unsigned* at = face.mIndices;
      part.triangles.push_back({offset + at[0], offset + at[mirrored ? 2 : 1], offset + at[mirrored ? 1 : 2]});
    }
  }

  void appendUvs(ImportedPart& part, const aiMesh& mesh, std::size_t base) const {
    unsigned channel = mesh.mMaterialIndex < uvChannels_.size() ? uvChannels_[mesh.mMaterialIndex] : 0;
    if (channel >= AI_MAX_NUMBER_OF_TEXTURECOORDS || !mesh.HasTextureCoords(channel)) channel = 0;
    const bool has = mesh.HasTextureCoords(channel);
    if (!has && part.uvs.empty()) return;
    part.uvs.resize(base + mesh.mNumVertices);  // zeros for meshes without texture coordinates
    for (unsigned i = 0; has && i < mesh.mNumVertices; ++i) {
      part.uvs[base + i] = {mesh.mTextureCoords[channel][i].x, mesh.mTextureCoords[channel][i].y};
    }
  }

  const std::filesystem::path& file_;
  const AssetOptions& options_;
  const std::string& kind_;
  std::string refused_;  // message about the first file that was refused; empty: none
  Assimp::Importer importer_;
  const aiScene* scene_ = nullptr;         // owned by importer_
  std::vector<std::uint32_t> uvChannels_;  // index of the set of texture coordinates, by material
  std::uint64_t triangles_ = 0;
};

}  // namespace

ImportedFile readByAssimp(const std::filesystem::path& file, const std::string& kind, const AssetOptions& options) {
  return Importer(file, kind, options).read();
}

}  // namespace scanmill
