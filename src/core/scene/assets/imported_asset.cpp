#include "scene/assets/imported_asset.h"

#include <assimp/commonMetaData.h>
#include <assimp/config.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <fmt/core.h>

#include <algorithm>
#include <assimp/Importer.hpp>
#include <cctype>
#include <cmath>
#include <cstdint>
#include <exception>
#include <fstream>
#include <memory>
#include <optional>
#include <string_view>
#include <utility>

#include "base/error.h"
#include "scene/assets/ac3d.h"
#include "scene/assets/asset_material.h"
#include "scene/assets/asset_parts.h"
#include "scene/assets/ply_check.h"
#include "scene/assets/trial.h"

namespace scanmill {

namespace {

constexpr std::uint64_t kTrialMemory = std::uint64_t{4} << 30;  // bytes, and 64 for every byte of the file
constexpr unsigned kTrialSeconds = 300;

constexpr std::string_view kCollada = "Collada Importer";

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
      : file_(file), options_(options), kind_(kind) {}

  Asset read() {
    import();
    Asset asset;
    const std::optional<char> declared = declaredUp();
    asset.up = options_.up.value_or(declared.value_or('z'));
    asset.upDeclared = declared.has_value();
    asset.dropped.outOfRange = dropBadFaces(*scene_);
    triangulate();
    materials_ = readMaterials(*scene_, file_, options_);
    walk(asset);
    return asset;
  }

 private:
  [[noreturn]] void fail(const std::string& what) const { throw InputError({file_.string()}, what); }

  void import() {
    configure(importer_);
    if (kind_.empty() || !importer_.IsExtensionSupported(kind_)) {
      fail(fmt::format("is of an unknown kind ('{}'): convert it to glTF, GLB, OBJ, PLY, STL, DAE, FBX, AC or BLEND",
                       kind_));
    }
    if (kind_ == ".ply") {
      checkPly(file_);
    } else if (!isSound()) {
      const std::uint64_t memory = kTrialMemory + 64 * std::filesystem::file_size(file_);
      const std::string failure = tryApart([&] { return importTrial(); }, memory, kTrialSeconds);
      if (!failure.empty()) fail(fmt::format("cannot be read: {}; {}", trimmed(failure), remedy()));
    }
    try {
      scene_ = read(importer_);
    } catch (const std::exception& e) {
      fail(fmt::format("cannot be read: {}; {}", e.what(), remedy()));
    }
    if (scene_ == nullptr) fail(fmt::format("cannot be read: {}; {}", reason(importer_), remedy()));
    if (scene_->mRootNode == nullptr) fail("cannot be read: it has no nodes; " + remedy());
  }

  bool isAc3d() const { return kind_ == ".ac" || kind_ == ".acc" || kind_ == ".ac3d"; }

  const aiScene* read(Assimp::Importer& importer) const {
    if (!isAc3d()) return importer.ReadFile(file_.string(), 0);
    const std::string text = readAc3d(file_);
    return importer.ReadFileFromMemory(text.data(), text.size(), 0, "ac");
  }

  void configure(Assimp::Importer& importer) const {
    importer.SetPropertyBool(AI_CONFIG_IMPORT_COLLADA_USE_COLLADA_NAMES, true);
    importer.SetPropertyBool(AI_CONFIG_IMPORT_COLLADA_IGNORE_UP_DIRECTION, options_.up.has_value());
    importer.SetPropertyBool(AI_CONFIG_IMPORT_NO_SKELETON_MESHES, true);
    importer.SetPropertyBool(AI_CONFIG_IMPORT_FBX_READ_ANIMATIONS, false);
    // The importer also goes by content: glTF under another name would come in unchecked.
    for (const char* kind : {"gltf", "glb"}) {
      while (auto* loader = importer.GetImporter(kind)) importer.UnregisterLoader(loader);
    }
  }

  // Kinds whose damaged files the importer survives. It crashes on some of all others.
  bool isSound() const { return kind_ == ".obj" || kind_ == ".stl"; }

  // In a child process, before the same is done here.
  std::string importTrial() const {
    Assimp::Importer importer;
    configure(importer);
    const aiScene* scene = read(importer);
    if (scene == nullptr) return reason(importer);
    dropBadFaces(*scene);
    return importer.ApplyPostProcessing(postProcessing(*scene)) == nullptr ? reason(importer) : std::string();
  }

  static std::string trimmed(std::string text) {
    while (!text.empty() && (text.back() == '\n' || text.back() == '.' || text.back() == ' ')) text.pop_back();
    return text.empty() ? "the file is damaged" : text;
  }

  static std::string reason(const Assimp::Importer& importer) { return trimmed(importer.GetErrorString()); }

  std::string remedy() const {
    if (isAc3d()) {
      return "remove objects without surfaces, or convert it to glTF or OBJ";
    }
    return "check that the file is whole, or convert it to glTF or OBJ";
  }

  // Faces with an index beyond the vertices lose their indices, since triangulation reads what they point at. Returns
  // the triangles lost.
  static std::uint64_t dropBadFaces(const aiScene& scene) {
    std::uint64_t dropped = 0;
    for (unsigned m = 0; m < scene.mNumMeshes; ++m) {
      aiMesh& mesh = *scene.mMeshes[m];
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

  static bool anyPolygon(const aiScene& scene) {
    for (unsigned m = 0; m < scene.mNumMeshes; ++m) {
      const aiMesh& mesh = *scene.mMeshes[m];
      if (std::any_of(mesh.mFaces, mesh.mFaces + mesh.mNumFaces, [](const aiFace& f) { return f.mNumIndices > 3; })) {
        return true;
      }
    }
    return false;
  }

  static unsigned postProcessing(const aiScene& scene) {
    unsigned steps = aiProcess_TransformUVCoords;
    if (anyPolygon(scene)) steps |= aiProcess_Triangulate;
    return steps;
  }

  void triangulate() {
    scene_ = importer_.ApplyPostProcessing(postProcessing(*scene_));
    if (scene_ == nullptr) fail(fmt::format("cannot be cut into triangles: {}; {}", reason(importer_), remedy()));
  }

  // From the importer's frame to metres and z up.
  Affine assetFromImported(char up) const {
    double scale = options_.metresPerUnit;
    const std::string format = importedAs();
    if (format == kCollada && !options_.up) up = 'y';  // to which the importer has turned the declared axis
    if (format == "Autodesk FBX Importer") {
      scale *=
          static_cast<double>(metadata(*scene_, "UnitScaleFactor", 1.0f)) * 0.01;  // FBX states its unit in centimetres
    }
    if (!(scale > 0) || !std::isfinite(scale)) fail("declares a unit that is not above 0");
    // The importer turns files of these kinds, which are z-up, to y-up.
    const bool turned = format == "Discreet 3DS Importer" || format == "ASE Importer" ||
                        format == "Drawing Interchange Format (DXF) Importer";
    const Mat3 fileFromImported = turned ? zUpFrom('y') : Mat3();
    return {zUpFrom(up) * fileFromImported * Mat3::scale({scale, scale, scale}), {}};
  }

  // The up axis that the file states or its kind prescribes; nothing where neither does.
  std::optional<char> declaredUp() const {
    const std::string format = importedAs();
    if (format == "Autodesk FBX Importer") {
      const std::int32_t axis = metadata(*scene_, "UpAxis", std::int32_t{1});
      return axis >= 0 && axis <= 2 ? "xyz"[axis] : 'y';
    }
    if (format == kCollada) return colladaUp();
    if (format == "AC3D Importer") return 'y';
    return std::nullopt;
  }

  // The importer keeps up_axis to itself. It is in the head of the file, since the schema puts `asset` first.
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
    // What the importer calls nodes of COLLADA without a name.
    if (!name.starts_with("$ColladaAutoName$")) return name;
    aiString id;
    return node.mMetaData != nullptr && node.mMetaData->Get("Collada_id", id) ? id.C_Str() : "";
  }

  void walk(Asset& asset) {
    struct Item {
      const aiNode* node;
      Affine assetFromParent;
      std::string name;  // of the nearest ancestor that has one, but the root, which the importer often makes
    };
    std::vector<Item> open{{scene_->mRootNode, assetFromImported(asset.up), {}}};
    for (std::uint32_t index = 0; !open.empty(); ++index) {
      const Item item = std::move(open.back());
      open.pop_back();
      std::string name = nodeName(*item.node);
      if (name.empty()) name = item.name;
      const Affine assetFromNode = item.assetFromParent * toAffine(item.node->mTransformation);
      addNode(asset, *item.node, name, index, assetFromNode);
      const std::string inherited = item.node == scene_->mRootNode ? std::string() : name;
      for (unsigned i = item.node->mNumChildren; i-- > 0;) {
        if (const aiNode* child = item.node->mChildren[i]) open.push_back({child, assetFromNode, inherited});
      }
    }
    for (AssetPart& part : asset.parts) weld(part);
    std::erase_if(asset.parts, [](const AssetPart& part) { return part.triangles.empty(); });
  }

  void addNode(Asset& asset, const aiNode& node, const std::string& name, std::uint32_t index,
               const Affine& assetFromNode) {
    const std::size_t first = asset.parts.size();
    std::vector<unsigned> materials;  // of the parts of this node
    for (unsigned i = 0; i < node.mNumMeshes; ++i) {
      if (node.mMeshes[i] >= scene_->mNumMeshes) continue;
      const aiMesh& mesh = *scene_->mMeshes[node.mMeshes[i]];
      if (mesh.mNumVertices == 0 || mesh.mVertices == nullptr || mesh.mNumFaces == 0) continue;
      triangles_ += mesh.mNumFaces;
      if (triangles_ > kMostTriangles) fail(fmt::format("places over {} triangles", kMostTriangles));
      const auto known = std::find(materials.begin(), materials.end(), mesh.mMaterialIndex);
      const std::size_t part = first + static_cast<std::size_t>(known - materials.begin());
      if (known == materials.end()) {
        materials.push_back(mesh.mMaterialIndex);
        asset.parts.push_back(newPart(name, index, mesh.mMaterialIndex));
      }
      append(asset.parts[part], mesh, assetFromNode);
    }
  }

  AssetPart newPart(std::string node, std::uint32_t index, unsigned material) const {
    AssetPart part;
    part.node = std::move(node);
    part.nodeIndex = index;
    if (material < materials_.size()) {
      part.fileMaterial = materials_[material].material;
      part.material = part.fileMaterial.name;
      part.texture = materials_[material].texture;
      part.color = materials_[material].color;
    }
    return part;
  }

  void append(AssetPart& part, const aiMesh& mesh, const Affine& assetFromNode) const {
    const std::size_t base = part.positions.size();
    if (base + mesh.mNumVertices > UINT32_MAX) fail("has more vertices than 32-bit indices reach");
    part.positions.resize(base + mesh.mNumVertices);
    for (unsigned i = 0; i < mesh.mNumVertices; ++i) {
      const aiVector3D& v = mesh.mVertices[i];
      part.positions[base + i] = static_cast<Vec3f>(assetFromNode * Vec3d{v.x, v.y, v.z});
    }
    appendUvs(part, mesh, base);
    // A mirroring transform turns surfaces inside out unless their corners change places.
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

  void appendUvs(AssetPart& part, const aiMesh& mesh, std::size_t base) const {
    unsigned channel = mesh.mMaterialIndex < materials_.size() ? materials_[mesh.mMaterialIndex].uvChannel : 0;
    if (channel >= AI_MAX_NUMBER_OF_TEXTURECOORDS || !mesh.HasTextureCoords(channel)) channel = 0;
    const bool has = mesh.HasTextureCoords(channel);
    if (!has && part.uvs.empty()) return;
    part.uvs.resize(base + mesh.mNumVertices);  // zero where a mesh of the part has none
    for (unsigned i = 0; has && i < mesh.mNumVertices; ++i) {
      part.uvs[base + i] = {mesh.mTextureCoords[channel][i].x, mesh.mTextureCoords[channel][i].y};
    }
  }

  const std::filesystem::path& file_;
  const AssetOptions& options_;
  const std::string& kind_;
  Assimp::Importer importer_;
  const aiScene* scene_ = nullptr;  // owned by the importer
  std::vector<AssetMaterial> materials_;
  std::uint64_t triangles_ = 0;
};

}  // namespace

Asset readImported(const std::filesystem::path& file, const std::string& kind, const AssetOptions& options) {
  return Importer(file, kind, options).read();
}

}  // namespace scanmill
