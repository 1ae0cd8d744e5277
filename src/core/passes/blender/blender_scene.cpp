#include "passes/blender/blender_scene.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <nlohmann/json.hpp>
#include <span>

#include "base/error.h"
#include "base/file.h"
#include "scene/reflectance.h"

namespace scanmill {

namespace {

using Json = nlohmann::json;

static_assert(std::endian::native == std::endian::little, "the arrays are written as they lie in memory");

// Writes scene.bin: arrays one after the other, each of which starts at a multiple of 8 bytes.
class Arrays {
 public:
  explicit Arrays(const std::filesystem::path& file) : file_(file), out_(file, std::ios::binary | std::ios::trunc) {
    add<double>(std::vector<double>{0}, "f8", {1});  // so that the file of an empty scene is not empty
  }

  // Appends an array. Returns its entry in scene.json: offset in the file, type (numpy's name) and shape.
  template <class T>
  Json add(std::span<const T> values, const char* type, std::vector<std::size_t> shape) {
    static constexpr std::array<char, 8> kZeroes{};
    const std::size_t padding = (8 - writtenBytes_ % 8) % 8;
    out_.write(kZeroes.data(), static_cast<std::streamsize>(padding));
    writtenBytes_ += padding;
    Json entry{{"at", writtenBytes_}, {"type", type}, {"shape", std::move(shape)}};
    out_.write(reinterpret_cast<const char*>(values.data()), static_cast<std::streamsize>(values.size_bytes()));
    writtenBytes_ += values.size_bytes();
    return entry;
  }

  void finish() {
    out_.close();
    if (!out_) throw Error("{}: cannot be written: {}", file_.string(), std::strerror(errno));
  }

 private:
  std::filesystem::path file_;
  std::ofstream out_;
  std::size_t writtenBytes_ = 0;
};

class SceneWriter {
 public:
  // Takes the parameters of writeBlenderScene().
  SceneWriter(const Scene& scene, const Vec3d& origin, const std::filesystem::path& folder,
              std::uint32_t trianglesOfAnObject)
      : scene_(scene),
        origin_(origin),
        folder_(folder),
        trianglesOfAnObject_(trianglesOfAnObject),
        arrays_(folder / "scene.bin") {}

  // Writes scene.bin and scene.json, and returns the objects. Must be called only once.
  std::vector<BlenderObject> write(int threads) {
    addMaterials();
    std::vector<std::vector<std::uint32_t>> instancesOf(scene_.meshes.size());  // by mesh: indices of its instances
    for (std::uint32_t i = 0; i < scene_.instances.size(); ++i) instancesOf[scene_.instances[i].mesh].push_back(i);
    for (std::size_t m = 0; m < instancesOf.size(); ++m) {
      if (!scene_.meshes[m].triangles.empty() && !instancesOf[m].empty()) addMesh(scene_.meshes[m], instancesOf[m]);
    }
    const std::size_t count = objects_.size();
    index_["threads"] = threads;
    index_["objects"] = count;
    index_["matrices"] = arrays_.add<double>(matrices_, "f8", {count, 3, 4});
    index_["mesh_of"] = arrays_.add<std::uint32_t>(meshNumbers_, "u4", {count});
    arrays_.finish();
    writeFile(folder_ / "scene.json", index_.dump());
    return std::move(objects_);
  }

 private:
  // Writes an entry for each material: for an alpha-tested material the mask of its solid texels, otherwise null.
  void addMaterials() {
    Json& list = index_["materials"] = Json::array();
    std::vector<std::uint8_t> mask;
    for (const Material& material : scene_.materials) {
      list.push_back(nullptr);
      if (!material.alphaTested || !material.texture) continue;
      const Texture& texture = *material.texture;
      mask.resize(std::size_t{texture.width} * texture.height);
      for (std::size_t i = 0; i < mask.size(); ++i) {
        mask[i] = letsPass(material, &texture.rgba[i * 4]) ? 0 : 1;
      }
      list.back() = arrays_.add<std::uint8_t>(mask, "u1", {texture.height, texture.width});
    }
  }

  // Writes a mesh and its `instances`, divided into objects of at most trianglesOfAnObject_ triangles. The positions of
  // a mesh with one instance are relative to origin_, the positions of other meshes are in the mesh's frame.
  void addMesh(const Mesh& mesh, const std::vector<std::uint32_t>& instances) {
    const bool isPlacedOnce = instances.size() == 1;
    std::vector<Vec3f> positions = mesh.positions;
    if (isPlacedOnce) {
      const Affine originFromMesh = placement(instances[0]);
      for (Vec3f& p : positions) p = static_cast<Vec3f>(originFromMesh * static_cast<Vec3d>(p));
    }
    const Json positionsEntry = arrays_.add<Vec3f>(positions, "f4", {positions.size(), 3});
    const Json uvsEntry = mesh.uvs.empty() ? Json() : arrays_.add<Vec2f>(mesh.uvs, "f4", {mesh.uvs.size(), 2});
    std::vector<std::uint16_t> materials;
    for (std::size_t first = 0; first < mesh.triangles.size(); first += trianglesOfAnObject_) {
      const std::size_t count = std::min<std::size_t>(trianglesOfAnObject_, mesh.triangles.size() - first);
      materials.clear();
      for (std::size_t i = 0; i < count; ++i) {
        materials.push_back(mesh.surfaces[mesh.surfaceOf[first + i]].material);
      }
      const std::span<const Triangle> triangles(mesh.triangles.data() + first, count);
      const auto meshNumber = static_cast<std::uint32_t>(index_["meshes"].size());
      index_["meshes"].push_back({{"positions", positionsEntry},
                                  {"uvs", uvsEntry},
                                  {"triangles", arrays_.add<Triangle>(triangles, "u4", {count, 3})},
                                  {"materials", arrays_.add<std::uint16_t>(materials, "u2", {count})}});
      for (const std::uint32_t i : instances) {
        objects_.push_back({i + 1, static_cast<std::uint32_t>(first)});
        meshNumbers_.push_back(meshNumber);
        const std::array<double, 16> rows = matrixRows(isPlacedOnce ? Affine() : placement(i));
        matrices_.insert(matrices_.end(), rows.begin(), rows.begin() + 12);
      }
    }
  }

  // Returns originFromMesh of an instance.
  Affine placement(std::uint32_t instance) const {
    const Affine& worldFromMesh = scene_.instances[instance].worldFromMesh;
    return {worldFromMesh.linear, worldFromMesh.translation - origin_};
  }

  const Scene& scene_;
  Vec3d origin_;
  const std::filesystem::path& folder_;
  std::uint32_t trianglesOfAnObject_;
  Arrays arrays_;
  Json index_{{"meshes", Json::array()}};
  std::vector<BlenderObject> objects_;
  std::vector<std::uint32_t> meshNumbers_;  // by object: index in "meshes"
  std::vector<double> matrices_;            // by object: the first three rows of the matrix originFromMesh
};

}  // namespace

std::vector<BlenderObject> writeBlenderScene(const Scene& scene, const Vec3d& origin, int threads,
                                             const std::filesystem::path& folder, std::uint32_t trianglesOfAnObject) {
  return SceneWriter(scene, origin, folder, trianglesOfAnObject).write(threads);
}

}  // namespace scanmill
