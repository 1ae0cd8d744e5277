#include <assimp/commonMetaData.h>
#include <assimp/config.h>
#include <assimp/scene.h>
#include <fmt/core.h>

#include <algorithm>
#include <assimp/DefaultLogger.hpp>
#include <assimp/Importer.hpp>
#include <assimp/LogStream.hpp>
#include <exception>
#include <new>
#include <stdexcept>
#include <string_view>
#include <utility>

#include "assets/meshes/asset_parts.h"
#include "assets/meshes/assimp/parts.h"
#include "assets/meshes/polygon.h"
#include "base/error.h"

namespace scanmill {

namespace {

Affine toAffine(const aiMatrix4x4& m) {
  return {{{m.a1, m.b1, m.c1}, {m.a2, m.b2, m.c2}, {m.a3, m.b3, m.c3}}, {m.a4, m.b4, m.c4}};
}

// Returns an entry of the metadata of a scene or a node.
template <class T>
T metadataOf(const auto& owner, const char* key, T fallback) {
  T value{};
  return owner.mMetaData != nullptr && owner.mMetaData->Get(key, value) ? value : fallback;
}

// Collects the errors that the library meets in files and reads past, as long as the object lives.
class ImporterLog {
 public:
  ImporterLog() {
    Assimp::DefaultLogger::create("", Assimp::Logger::NORMAL, 0, nullptr);
    Assimp::DefaultLogger::get()->attachStream(new Stream(problems), Assimp::Logger::Err);
  }
  ~ImporterLog() { Assimp::DefaultLogger::kill(); }
  ImporterLog(const ImporterLog&) = delete;
  ImporterLog& operator=(const ImporterLog&) = delete;

  std::vector<std::string> problems;  // the first ones

 private:
  class Stream final : public Assimp::LogStream {
   public:
    explicit Stream(std::vector<std::string>& problems) : problems_(problems) {}

    // Takes a line such as "Error, T0: AC3D: Unexpected EOF".
    void write(const char* message) override {
      constexpr std::size_t kMostProblems = 4;
      std::string_view text(message);
      text.remove_prefix(std::min(text.find(": ") + 2, text.size()));
      const std::string problem(text.substr(0, std::min<std::size_t>(text.find('\n'), 200)));
      const bool isKnown = std::find(problems_.begin(), problems_.end(), problem) != problems_.end();
      if (problems_.size() < kMostProblems && !isKnown) problems_.push_back(problem);
    }

   private:
    std::vector<std::string>& problems_;
  };
};

class Importer {
 public:
  Importer(const std::filesystem::path& file, const std::string& kind, const AssetOptions& options)
      : file_(file), options_(options), kind_(kind), collada_(kind == ".dae") {}

  ImportedFile read() {
    ImportedFile read;
    import();
    read.up = options_.up.value_or(collada_ ? facts_.up : 'y');
    read.upDeclared = true;
    read.statedUnit = facts_.unit;
    countUnread();
    read.dropped.outOfRange = dropBadFaces();
    read.materials = materialsOf(*scene_, leftOut_);
    takeColladaFacts(read.materials);
    walk(read);
    read.problems = log_.problems;
    read.leftOut = std::move(leftOut_);
    return read;
  }

 private:
  void import() {
    importer_.SetPropertyBool(AI_CONFIG_IMPORT_COLLADA_USE_COLLADA_NAMES, true);
    importer_.SetPropertyBool(AI_CONFIG_IMPORT_COLLADA_IGNORE_UP_DIRECTION, options_.up.has_value());
    importer_.SetPropertyBool(AI_CONFIG_IMPORT_NO_SKELETON_MESHES, true);
    std::string text;
    if (collada_) {
      facts_ = colladaFacts(file_);
      text = std::move(facts_.text);
      leftOut_.add(facts_.leftOut);
    } else {
      text = readAc3d(file_, leftOut_);
    }
    try {
      scene_ = importer_.ReadFileFromMemory(text.data(), text.size(), 0, collada_ ? "dae" : "ac");
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
    // The importer also recognises other kinds by their content.
    const std::string format = metadataOf(*scene_, AI_METADATA_SOURCE_FORMAT, aiString()).C_Str();
    if (format != (collada_ ? "Collada Importer" : "AC3D Importer")) failReading("it is of another kind");
  }

  [[noreturn]] void failReading(const std::string& why) const {
    throw Error(fmt::format("cannot be read: {}; {}", why, remedyFor(kind_)));
  }

  // Counts what the importer has read and is not used.
  void countUnread() {
    leftOut_.add("animations (the file's pose is taken)", scene_->mNumAnimations);
    for (unsigned m = 0; m < scene_->mNumMeshes; ++m) {
      const aiMesh& mesh = *scene_->mMeshes[m];
      if (mesh.HasVertexColors(0)) leftOut_.add("colours of vertices", mesh.mNumVertices);
      for (unsigned f = 0; f < mesh.mNumFaces; ++f) {
        if (mesh.mFaces[f].mNumIndices == 1) leftOut_.add("points");
        if (mesh.mFaces[f].mNumIndices == 2) leftOut_.add("lines");
      }
    }
  }

  // Adds to the materials what the importer does not report, and takes from them what it reads wrong.
  void takeColladaFacts(std::vector<ImportedMaterial>& materials) {
    for (std::size_t i = 0; i < std::min(materials.size(), facts_.materials.size()); ++i) {
      const ColladaMaterial& stated = facts_.materials[i];
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
        material.opacityMap.name.clear();  // opaque everywhere
      } else if (*stated.transparency != 1) {
        leftOut_.add("numbers of `transparency` beside images (the images alone count)");
      }
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

  // Returns the transform from the importer's frame to metres and z up.
  Affine assetFromImported(char up) const {
    if (collada_ && !options_.up) up = 'y';  // the importer has rotated the declared axis to y
    return {assetFromFile(up, options_.metresPerUnit), {}};
  }

  static std::string nodeName(const aiNode& node) {
    std::string name = node.mName.C_Str();
    return name.starts_with("$ColladaAutoName$") ? std::string() : name;  // which the importer invents
  }

  struct Placed {
    const aiNode* node;
    Affine assetFromNode;
    std::string name;  // name of the node or of its nearest named ancestor; the root's children do not inherit its
                       // name, which the importer often invents
  };

  void walk(ImportedFile& read) {
    std::uint32_t index = 0;  // of the node in the order of the file, depth first
    std::vector<Placed> pending{{scene_->mRootNode, assetFromImported(read.up), {}}};
    while (!pending.empty()) {
      Placed item = std::move(pending.back());
      pending.pop_back();
      if (std::string own = nodeName(*item.node); !own.empty()) item.name = std::move(own);
      item.assetFromNode = item.assetFromNode * toAffine(item.node->mTransformation);
      const std::string inherited = item.node == scene_->mRootNode ? std::string() : item.name;
      for (unsigned i = item.node->mNumChildren; i-- > 0;) {
        if (const aiNode* child = item.node->mChildren[i]) pending.push_back({child, item.assetFromNode, inherited});
      }
      addNode(read, *item.node, item.name, index++, item.assetFromNode);
    }
  }

  void addNode(ImportedFile& read, const aiNode& node, const std::string& name, std::uint32_t index,
               const Affine& assetFromNode) {
    static const ImportedMaterial kNone;
    const std::size_t first = read.parts.size();
    for (unsigned i = 0; i < node.mNumMeshes; ++i) {
      if (node.mMeshes[i] >= scene_->mNumMeshes) continue;
      const aiMesh& mesh = *scene_->mMeshes[node.mMeshes[i]];
      if (mesh.mNumVertices == 0 || mesh.mVertices == nullptr || mesh.mNumFaces == 0) continue;
      triangles_ += mesh.mNumFaces;
      if (triangles_ > kMostTriangles)
        throw Error(fmt::format("has more than {} triangles, with all copies: split it", kMostTriangles));
      const unsigned number = mesh.mMaterialIndex;
      const ImportedMaterial& material = number < read.materials.size() ? read.materials[number] : kNone;
      scanmill::append(geometryOf(mesh, material.placement()), assetFromNode, number, material.namesImages(), first,
                       read.parts);
    }
    finishNode(name, index, first, read.parts);
  }

  Geometry geometryOf(const aiMesh& mesh, const UvPlacement& placement) {
    Geometry geometry;
    for (unsigned i = 0; i < mesh.mNumVertices; ++i) {
      const aiVector3D& v = mesh.mVertices[i];
      geometry.points.push_back({v.x, v.y, v.z});
    }
    for (unsigned f = 0; f < mesh.mNumFaces; ++f) {
      const aiFace& face = mesh.mFaces[f];
      if (face.mNumIndices < 3) continue;
      const unsigned* at = face.mIndices;
      for (const auto& t : polygons_.divide(face.mNumIndices, [&](std::size_t i) { return geometry.points[at[i]]; })) {
        geometry.triangles.push_back({at[t[0]], at[t[1]], at[t[2]]});
      }
    }
    const unsigned wanted = placement.channel;
    const unsigned channel = wanted < AI_MAX_NUMBER_OF_TEXTURECOORDS && mesh.HasTextureCoords(wanted) ? wanted : 0;
    if (!mesh.HasTextureCoords(channel)) return geometry;
    for (unsigned i = 0; i < mesh.mNumVertices; ++i) {
      const aiVector3D& uv = mesh.mTextureCoords[channel][i];
      geometry.uvs.push_back(placement.apply({uv.x, uv.y}));
    }
    return geometry;
  }

  const std::filesystem::path& file_;
  const AssetOptions& options_;
  const std::string& kind_;
  const bool collada_;  // false: AC3D
  ImporterLog log_;
  Assimp::Importer importer_;
  const aiScene* scene_ = nullptr;  // owned by importer_
  std::uint64_t triangles_ = 0;
  Triangulator polygons_{Location()};  // without the file's name, which the parent process adds
  ColladaFacts facts_;
  LeftOut leftOut_;
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
