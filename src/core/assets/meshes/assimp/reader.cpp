#include <assimp/commonMetaData.h>
#include <assimp/config.h>
#include <assimp/material.h>
#include <assimp/scene.h>

#include <algorithm>
#include <assimp/DefaultLogger.hpp>
#include <assimp/Importer.hpp>
#include <assimp/LogStream.hpp>
#include <exception>
#include <initializer_list>
#include <new>
#include <span>
#include <stdexcept>
#include <string_view>
#include <utility>

#include "assets/meshes/asset_parts.h"
#include "assets/meshes/assimp/parts.h"
#include "assets/meshes/base_color.h"
#include "assets/meshes/polygon.h"
#include "base/error.h"

namespace scanmill {

namespace {

Affine toAffine(const aiMatrix4x4& m) {
  return {{{m.a1, m.b1, m.c1}, {m.a2, m.b2, m.c2}, {m.a3, m.b3, m.c3}}, {m.a4, m.b4, m.c4}};
}

std::string textOf(const aiMaterial& material, const char* key, unsigned type, unsigned i) {
  aiString value;
  return material.Get(key, type, i, value) == aiReturn_SUCCESS ? std::string(value.C_Str()) : std::string();
}

template <class Number>
Number numberOf(const aiMaterial& material, const char* key, unsigned type, unsigned i, Number fallback) {
  Number value{};
  return material.Get(key, type, i, value) == aiReturn_SUCCESS ? value : fallback;
}

// Returns the material's image of the first of these types for which it has an image; without any, an empty map. Adds
// rotations of images, which are not applied, to `leftOut`.
ImportedMap firstMap(const aiMaterial& material, std::initializer_list<aiTextureType> types, LeftOut& leftOut) {
  for (const aiTextureType type : types) {
    ImportedMap map{.name = textOf(material, AI_MATKEY_TEXTURE(type, 0))};
    if (map.name.empty()) continue;
    map.placement.channel = static_cast<std::uint32_t>(std::max(numberOf(material, AI_MATKEY_UVWSRC(type, 0), 0), 0));
    if (aiUVTransform transform; material.Get(AI_MATKEY_UVTRANSFORM(type, 0), transform) == aiReturn_SUCCESS) {
      map.placement.scale = {transform.mScaling.x, transform.mScaling.y};
      map.placement.offset = {transform.mTranslation.x, transform.mTranslation.y};
      // The importer reads degrees as radians, and no specification states the direction of the rotation.
      if (transform.mRotation != 0) leftOut.add("rotations of images (rotateUV)");
    }
    map.inverted = (numberOf(material, AI_MATKEY_TEXFLAGS(type, 0), 0) & aiTextureFlags_Invert) != 0;
    constexpr int kRepeat = aiTextureMapMode_Wrap;
    map.repeats = numberOf(material, AI_MATKEY_MAPPINGMODE_U(type, 0), kRepeat) == kRepeat &&
                  numberOf(material, AI_MATKEY_MAPPINGMODE_V(type, 0), kRepeat) == kRepeat;
    return map;
  }
  return {};
}

// Returns the materials of a scene. Base colours count as linear, since most exporters write linear ones.
std::vector<ImportedMaterial> materialsOf(const aiScene& scene, LeftOut& leftOut) {
  std::vector<ImportedMaterial> materials;
  for (const aiMaterial* const read : std::span(scene.mMaterials, scene.mNumMaterials)) {
    ImportedMaterial& material = materials.emplace_back();
    material.name = textOf(*read, AI_MATKEY_NAME);
    aiColor4D color(1, 1, 1, 1);  // white if the file states no colour, even if assimp's default material has one
    material.stated =
        material.name != kDefaultMaterial && read->Get(AI_MATKEY_COLOR_DIFFUSE, color) == aiReturn_SUCCESS;
    if (material.name == kDefaultMaterial) material.name.clear();
    material.roughness = fraction(numberOf(*read, AI_MATKEY_ROUGHNESS_FACTOR, 1.0f), 1.0f);
    material.metallic = fraction(numberOf(*read, AI_MATKEY_METALLIC_FACTOR, 0.0f), 0.0f);
    material.opacity = numberOf(*read, AI_MATKEY_OPACITY, 1.0f);
    material.color = {fraction(color.r, 1.0f), fraction(color.g, 1.0f), fraction(color.b, 1.0f)};
    material.opacityMap = firstMap(*read, {aiTextureType_OPACITY}, leftOut);
    material.base = firstMap(*read, {aiTextureType_BASE_COLOR, aiTextureType_DIFFUSE}, leftOut);
  }
  return materials;
}

// During its lifetime, collects the errors in files that assimp logs without failing.
class ImporterLog final : public Assimp::LogStream {
 public:
  ImporterLog() {
    Assimp::DefaultLogger::create("", Assimp::Logger::NORMAL, 0, nullptr);
    Assimp::DefaultLogger::get()->attachStream(this, Assimp::Logger::Err);
  }
  ~ImporterLog() override {
    Assimp::DefaultLogger::get()->detachStream(this, Assimp::Logger::Err);
    Assimp::DefaultLogger::kill();
  }

  // Takes a line such as "Error, T0: AC3D: Unexpected EOF".
  void write(const char* message) override {
    constexpr std::size_t kMostProblems = 4, kMostLetters = 200;
    std::string_view text(message);
    text.remove_prefix(std::min(text.find(": ") + 2, text.size()));
    const std::string problem(text.substr(0, std::min(text.find('\n'), kMostLetters)));
    const bool isRepeated = std::ranges::find(problems, problem) != problems.end();
    if (problems.size() < kMostProblems && !isRepeated) problems.push_back(problem);
  }

  std::vector<std::string> problems;  // the first kMostProblems errors
};

class Importer {
 public:
  Importer(const std::filesystem::path& file, const std::string& kind, const AssetOptions& options)
      : file_(file), options_(options), kind_(kind), isCollada_(kind == ".dae") {}

  ImportedFile read() {
    importScene();
    imported_.up = options_.up.value_or(facts_.up);
    imported_.upDeclared = true;
    imported_.statedUnit = facts_.unit;
    countUnread();
    imported_.dropped.outOfRange = dropBadFaces();
    imported_.materials = materialsOf(*scene_, imported_.leftOut);
    applyColladaFacts();
    addNodes();
    imported_.problems = log_.problems;
    return std::move(imported_);
  }

 private:
  // Sets scene_ and, for a COLLADA file, facts_.
  void importScene() {
    importer_.SetPropertyBool(AI_CONFIG_IMPORT_COLLADA_USE_COLLADA_NAMES, true);
    importer_.SetPropertyBool(AI_CONFIG_IMPORT_COLLADA_IGNORE_UP_DIRECTION, options_.up.has_value());
    importer_.SetPropertyBool(AI_CONFIG_IMPORT_NO_SKELETON_MESHES, true);
    const std::string text =
        isCollada_ ? readCollada(file_, facts_, imported_.leftOut) : readAc3d(file_, imported_.leftOut);
    try {
      scene_ = importer_.ReadFileFromMemory(text.data(), text.size(), 0, isCollada_ ? "dae" : "ac");
      if (scene_ == nullptr && importer_.GetException() != nullptr) std::rethrow_exception(importer_.GetException());
    } catch (const std::bad_alloc&) {
      throw;
    } catch (const std::length_error&) {
      throw;
    } catch (const std::exception& e) {
      failReading(reason(e.what()));
    }
    if (scene_ == nullptr) failReading(reason(importer_.GetErrorString()));
    if (scene_->mRootNode == nullptr) failReading("it has no nodes");
    // The importer may have recognised another kind of file by its content, whatever the ending says.
    aiString format;
    if (scene_->mMetaData != nullptr) scene_->mMetaData->Get(AI_METADATA_SOURCE_FORMAT, format);
    if (format != aiString(isCollada_ ? "Collada Importer" : "AC3D Importer")) failReading("it is of another kind");
  }

  [[noreturn]] void failReading(const std::string& reason) const {
    throw Error("cannot be read: {}; {}", reason, remedyFor(kind_));
  }

  // Counts contents that the importer has read but that are not used.
  void countUnread() {
    imported_.leftOut.add("animations (the file's pose is taken)", scene_->mNumAnimations);
    for (const aiMesh* const mesh : std::span(scene_->mMeshes, scene_->mNumMeshes)) {
      if (mesh->HasVertexColors(0)) imported_.leftOut.add("colours of vertices", mesh->mNumVertices);
      for (const aiFace& face : std::span(mesh->mFaces, mesh->mNumFaces)) {
        if (face.mNumIndices == 1) imported_.leftOut.add("points");
        if (face.mNumIndices == 2) imported_.leftOut.add("lines");
      }
    }
  }

  // Corrects the materials where the importer does not report what the COLLADA file states, or reads it wrong.
  void applyColladaFacts() {
    for (std::size_t i = 0; i < std::min(imported_.materials.size(), facts_.materials.size()); ++i) {
      const ColladaMaterial& stated = facts_.materials[i];
      ImportedMaterial& material = imported_.materials[i];
      if (!stated.colored) {
        imported_.leftOut.add("materials without a plain diffuse colour");
        material.stated = false;
        material.color = {1, 1, 1};
      }
      material.base.repeats = material.base.repeats && !stated.clamps;
      if (!stated.transparency) continue;
      material.opacity = 1;
      material.opacityMap.inverted = stated.inverted;
      if (stated.inverted && *stated.transparency == 0) {
        material.opacityMap.name.clear();  // opaque everywhere
      } else if (*stated.transparency != 1) {
        imported_.leftOut.add("numbers of `transparency` beside images (the images alone count)");
      }
    }
  }

  // Returns an error message of the importer without full stops, line breaks and blanks at its end.
  static std::string reason(std::string text) {
    while (!text.empty() && (text.back() == '\n' || text.back() == '.' || text.back() == ' ')) text.pop_back();
    return text.empty() ? "the file is damaged" : text;
  }

  // Empties faces with an index out of range, since triangulation would read beyond the vertices. Returns the number of
  // lost triangles.
  std::uint64_t dropBadFaces() const {
    std::uint64_t dropped = 0;
    for (const aiMesh* const mesh : std::span(scene_->mMeshes, scene_->mNumMeshes)) {
      const unsigned vertices = mesh->mVertices != nullptr ? mesh->mNumVertices : 0;
      for (aiFace& face : std::span(mesh->mFaces, mesh->mNumFaces)) {
        const std::span indices(face.mIndices, face.mNumIndices);
        if (std::ranges::all_of(indices, [&](unsigned i) { return i < vertices; })) continue;
        dropped += face.mNumIndices > 2 ? face.mNumIndices - 2 : 0;
        face.mNumIndices = 0;
      }
    }
    return dropped;
  }

  // Adds the parts of all nodes, in the order of the file, depth first.
  void addNodes() {
    struct PendingNode {
      const aiNode* node;
      Affine assetFromParent;
      std::string inheritedName;  // name of the nearest ancestor with one; empty: none, or only the root, whose name
                                  // the importer often invents
    };
    // If the options state no up axis, it is y: the importer has rotated COLLADA files to y, and AC3D is y-up.
    const char up = options_.up.value_or('y');
    std::vector<PendingNode> pending{{scene_->mRootNode, {assetFromFile(up, options_.metresPerUnit), {}}, {}}};
    for (std::uint32_t index = 0; !pending.empty(); ++index) {
      const auto [node, assetFromParent, inheritedName] = std::move(pending.back());
      pending.pop_back();
      const std::string_view ownName = node->mName.C_Str();
      const bool isInvented = ownName.starts_with("$ColladaAutoName$");
      const std::string name(ownName.empty() || isInvented ? std::string_view(inheritedName) : ownName);
      const Affine assetFromNode = assetFromParent * toAffine(node->mTransformation);
      for (unsigned i = node->mNumChildren; i-- > 0;) {
        if (node->mChildren[i] == nullptr) continue;
        pending.push_back({node->mChildren[i], assetFromNode, node == scene_->mRootNode ? "" : name});
      }
      addNode(*node, name, index, assetFromNode);
    }
  }

  void addNode(const aiNode& node, const std::string& name, std::uint32_t index, const Affine& assetFromNode) {
    static const ImportedMaterial kNoMaterial;
    const std::size_t first = imported_.parts.size();
    for (const unsigned meshIndex : std::span(node.mMeshes, node.mNumMeshes)) {
      if (meshIndex >= scene_->mNumMeshes) continue;
      const aiMesh& mesh = *scene_->mMeshes[meshIndex];
      if (mesh.mNumVertices == 0 || mesh.mVertices == nullptr || mesh.mNumFaces == 0) continue;
      triangles_ += mesh.mNumFaces;
      if (triangles_ > kMostTriangles)
        throw Error("has more than {} triangles, with all copies: split it", kMostTriangles);
      const unsigned number = mesh.mMaterialIndex;
      const ImportedMaterial& material =
          number < imported_.materials.size() ? imported_.materials[number] : kNoMaterial;
      scanmill::append(geometryOf(mesh, material.placement()), assetFromNode, number, material.namesImages(), first,
                       imported_.parts);
    }
    finishNode(name, index, first, imported_.parts);
  }

  // Returns the polygons of a mesh as triangles, in the frame of its node.
  Geometry geometryOf(const aiMesh& mesh, const UvPlacement& placement) {
    Geometry geometry;
    for (const aiVector3D& v : std::span(mesh.mVertices, mesh.mNumVertices)) geometry.points.push_back({v.x, v.y, v.z});
    for (const aiFace& face : std::span(mesh.mFaces, mesh.mNumFaces)) {
      if (face.mNumIndices < 3) continue;
      const unsigned* const corners = face.mIndices;
      const auto position = [&](std::size_t corner) { return geometry.points[corners[corner]]; };
      for (const auto& t : polygons_.divide(face.mNumIndices, position)) {
        geometry.triangles.push_back({corners[t[0]], corners[t[1]], corners[t[2]]});
      }
    }
    const unsigned channel = mesh.HasTextureCoords(placement.channel) ? placement.channel : 0;
    if (!mesh.HasTextureCoords(channel)) return geometry;
    for (const aiVector3D& uv : std::span(mesh.mTextureCoords[channel], mesh.mNumVertices)) {
      geometry.uvs.push_back(placement.apply({uv.x, uv.y}));
    }
    return geometry;
  }

  const std::filesystem::path& file_;
  const AssetOptions& options_;
  const std::string& kind_;
  const bool isCollada_;  // false: AC3D
  ImporterLog log_;
  Assimp::Importer importer_;
  const aiScene* scene_ = nullptr;  // owned by importer_
  std::uint64_t triangles_ = 0;
  Triangulator polygons_{Location()};  // without the file's name, which the parent process adds
  ColladaFacts facts_;
  ImportedFile imported_;
};

}  // namespace

ImportedFile readByAssimp(const std::filesystem::path& file, const std::string& kind, const AssetOptions& options) {
  return Importer(file, kind, options).read();
}

std::string remedyFor(const std::string& kind) {
  return kind == ".dae" ? "check that the file is complete, or convert it to glTF, for example with Blender"
                        : "remove objects without surfaces, or convert it to glTF or OBJ";
}

}  // namespace scanmill
