#include "assets/meshes/gltf/reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <optional>
#include <set>

#include "assets/meshes/asset_parts.h"
#include "assets/meshes/child_process.h"
#include "assets/meshes/gltf/data.h"
#include "assets/meshes/gltf/model.h"
#include "assets/meshes/gltf/pose.h"
#include "base/earth.h"
#include "base/error.h"
#include "base/input_budget.h"
#include "base/memory.h"
#include "base/short_text.h"
#include "scene/builder.h"

namespace scanmill::gltf {
namespace {

// Limits, since a small file can require any amount of memory and time. kTrialMemory (bytes) and kTrialSeconds limit
// the child process of decodeDracoInChild(); the memory limit grows by 256 bytes for every compressed byte.
constexpr std::uint64_t kTrialMemory = std::uint64_t{2} << 30;
constexpr unsigned kTrialSeconds = 300;

// Returns the triangles of a list, a strip or a fan of vertices.
std::vector<Triangle> trianglesOf(Primitive::Mode mode, const std::vector<std::uint32_t>& at) {
  std::vector<Triangle> triangles;
  const std::size_t count = at.size();
  if (mode == Primitive::Mode::Triangles) {
    triangles.reserve(count / 3);
    for (std::size_t i = 0; i + 2 < count; i += 3) triangles.push_back({at[i], at[i + 1], at[i + 2]});
    return triangles;
  }
  for (std::size_t i = 0; i + 2 < count; ++i) {
    triangles.push_back(mode == Primitive::Mode::Fan ? Triangle{at[i + 1], at[i + 2], at[0]}
                                                     : Triangle{at[i], at[i + 1 + i % 2], at[i + 2 - i % 2]});
  }
  return triangles;
}

class Reader {
 public:
  Reader(Model model, const Affine& assetFromFile, const AssetOptions& options)
      : model_(std::move(model)), data_(model_), assetFromFile_(assetFromFile), options_(options) {
    if (options.clip) apply(*options.clip, data_, model_);
    placed_ = placeNodes(model_);
    uses_.resize(model_.meshes.size(), 0);
    for (const PlacedNode& p : placed_) {
      if (model_.nodes[p.node].mesh) ++uses_[*model_.nodes[p.node].mesh];
    }
    poser_.emplace(model_, data_, placed_);
  }

  Asset read(LeftOut& leftOut) {
    checkCosts();
    decodeDracoInChild();
    materials_ = readMaterials(model_, data_, options_);
    for (std::uint32_t i = 0; i < placed_.size(); ++i) {
      const PlacedNode& placed = placed_[i];
      const Node& node = model_.nodes[placed.node];
      if (node.mesh && !placed.visible) model_.leftOut.add("hidden nodes");
      if (!placed.visible || !node.mesh) continue;
      node.instances ? addInstances(placed, i, *node.instances)
                     : append(asset_.parts, placed, i, assetFromFile_ * frameOf(placed));
    }
    leftOut.add(model_.leftOut);
    return std::move(asset_);
  }

 private:
  // Returns the transform of posed vertices to the scene's frame. Skinned vertices are already in that frame.
  Affine frameOf(const PlacedNode& placed) const {
    return model_.nodes[placed.node].skin ? Affine{} : placed.sceneFromNode;
  }

  // Throws InputError if the file would take too much memory: a small file may place its meshes any number of times.
  void checkCosts() const {
    double triangles = 0, stored = 0;                          // with all copies, and as the file stores them
    std::set<std::pair<Index, std::optional<Index>>> counted;  // accessors of positions and indices
    for (const PlacedNode& placed : placed_) {
      const Node& node = model_.nodes[placed.node];
      if (!placed.visible || !node.mesh) continue;
      double copies = 1;
      if (node.instances && options_.clip && !node.instances->empty()) {
        copies = static_cast<double>(model_.accessors[node.instances->begin()->second].count);
      }
      for (const Primitive& primitive : model_.meshes[*node.mesh].primitives) {
        const Index listed = primitive.indices.value_or(primitive.attributes.at("POSITION"));
        const auto corners = static_cast<double>(model_.accessors[listed].count);
        chargeCopies(static_cast<std::uint64_t>(copies), {model_.file.string()});
        const double count = primitive.mode == Primitive::Mode::Triangles ? corners / 3 : corners;
        triangles += copies * count;
        if (counted.emplace(primitive.attributes.at("POSITION"), primitive.indices).second) stored += count;
      }
    }
    chargeBytes(kBytesPerTriangle * (triangles - stored), {model_.file.string()});
    const double bytes = triangles * static_cast<double>(sizeof(Triangle));
    if (bytes > static_cast<double>(memoryLimitBytes())) {
      model_.fail(
          fmt::format("has triangles that take {}, which is more than the memory: split it", shortBytes(bytes)));
    }
    if (triangles > static_cast<double>(kMostTriangles)) {
      model_.fail(fmt::format("has more than {} triangles, with all copies: split it", kMostTriangles));
    }
  }

  // Decodes all Draco data in a child process first, since damaged data can require any amount of memory.
  void decodeDracoInChild() const {
    std::vector<Primitive::Draco> compressed;
    std::uint64_t bytes = 0;
    for (const Mesh& mesh : model_.meshes) {
      for (const Primitive& p : mesh.primitives) {
        if (!p.draco) continue;
        compressed.push_back(*p.draco);
        bytes += model_.views[p.draco->view].length;
      }
    }
    if (bytes == 0) return;
    const auto decodeAll = [&] {
      for (const Primitive::Draco& draco : compressed) decodeDraco(data_.view(draco.view), draco.attributes);
      return std::string();
    };
    try {
      inChildProcess(decodeAll, kTrialMemory + 256 * bytes, kTrialSeconds);
    } catch (const Error& e) {
      model_.fail(fmt::format("has damaged meshes: {}; export it again", e.what()));
    }
  }

  // Appends the parts of a node, one part per material.
  void append(std::vector<AssetPart>& parts, const PlacedNode& placed, std::uint32_t number,
              const Affine& assetFromNode) {
    const std::size_t first = parts.size();
    for (const Primitive& primitive : model_.meshes[*model_.nodes[placed.node].mesh].primitives) {
      const std::size_t material = primitive.material.value_or(materials_.size() - 1);
      const std::optional<TextureUse>& texture = materials_[material].placed;
      const std::shared_ptr<const Geometry> geometry = sharedGeometry(primitive, placed, texture);
      asset_.dropped.outOfRange += geometry->dropped;
      triangles_ += geometry->triangles.size();
      if (triangles_ > kMostTriangles)
        model_.fail(fmt::format("has more than {} triangles, with all copies: split it", kMostTriangles));
      scanmill::append(*geometry, assetFromNode, static_cast<std::uint32_t>(material), texture.has_value(), first,
                       parts);
    }
    finishNode(placed.name, number, first, parts);
    for (std::size_t i = first; i < parts.size(); ++i) {
      ReadMaterial& material = materials_[parts[i].materialIndex];
      static_cast<Look&>(parts[i]) = material;
      checkTexture(parts[i], !material.placed || material.placed->repeats, model_.leftOut);
      model_.leftOut.add(std::exchange(material.leftOut, {}));  // once, however many parts have the material
    }
  }

  // Returns the geometry of a primitive. A mesh that is placed several times without skin or morphing is read only
  // once.
  std::shared_ptr<const Geometry> sharedGeometry(const Primitive& primitive, const PlacedNode& placed,
                                                 const std::optional<TextureUse>& texture) {
    const bool shares = poser_->isRigid(placed) && uses_[*model_.nodes[placed.node].mesh] > 1;
    if (!shares) return std::make_shared<const Geometry>(geometryOf(primitive, placed, texture));
    std::shared_ptr<const Geometry>& shared = sharedGeometry_[&primitive];
    if (shared == nullptr) shared = std::make_shared<const Geometry>(geometryOf(primitive, placed, texture));
    return shared;
  }

  Geometry geometryOf(const Primitive& primitive, const PlacedNode& placed, const std::optional<TextureUse>& texture) {
    const std::string what = fmt::format("the mesh of '{}'", placed.name);
    chargeTime({model_.file.string()});  // many primitives may share one long list of vertices
    std::optional<DracoMesh> draco;
    if (primitive.draco) draco = decodeDraco(data_.view(primitive.draco->view), primitive.draco->attributes);
    const AttributeNumbers numbers = [&](const std::string& name) {
      const auto found = primitive.attributes.find(name);
      if (draco && draco->attributes.contains(name)) {
        return found == primitive.attributes.end()
                   ? draco->attributes.at(name).numbers
                   : normalizedAs(model_.accessors[found->second], draco->attributes.at(name));
      }
      if (found == primitive.attributes.end()) return std::vector<float>();
      if (name.starts_with("WEIGHTS_")) return data_.fractions(found->second, what);
      if (!name.starts_with("JOINTS_")) return data_.floats(found->second, what);
      const std::vector<std::uint32_t> joints = data_.integers(found->second, what);
      return std::vector<float>(joints.begin(), joints.end());
    };
    Geometry g;
    g.points = toPoints(numbers("POSITION"));
    if (!poser_->isRigid(placed)) poser_->pose(placed, primitive, numbers, what, g.points);
    readUvs(numbers, texture, g);

    std::vector<std::uint32_t> indices;
    if (draco) {
      indices = std::move(draco->indices);
    } else if (primitive.indices) {
      indices = data_.integers(*primitive.indices, what);
    } else {
      for (std::uint32_t i = 0; i < g.points.size(); ++i) indices.push_back(i);
    }
    g.triangles = trianglesOf(draco ? Primitive::Mode::Triangles : primitive.mode, indices);
    const auto isOutOfRange = [&](const Triangle& t) { return std::max({t[0], t[1], t[2]}) >= g.points.size(); };
    g.dropped = static_cast<std::uint64_t>(std::erase_if(g.triangles, isOutOfRange));
    dropUnusedVertices(g);
    return g;
  }

  // Drops unused vertices, since primitives often share one long list of vertices.
  static void dropUnusedVertices(Geometry& g) {
    constexpr std::uint32_t kUnused = UINT32_MAX;
    std::vector<std::uint32_t> moved(g.points.size(), kUnused);
    for (const Triangle& t : g.triangles) {
      for (const std::uint32_t corner : t) moved[corner] = 0;
    }
    std::uint32_t kept = 0;
    for (std::size_t i = 0; i < moved.size(); ++i) {
      if (moved[i] == kUnused) continue;
      g.points[kept] = g.points[i];
      if (!g.uvs.empty()) g.uvs[kept] = g.uvs[i];
      moved[i] = kept++;
    }
    if (kept == g.points.size()) return;
    g.points.resize(kept);
    if (!g.uvs.empty()) g.uvs.resize(kept);
    for (Triangle& t : g.triangles) {
      for (std::uint32_t& corner : t) corner = moved[corner];
    }
  }

  // Returns the decoded numbers, normalized if the accessor that they replace is normalized.
  static std::vector<float> normalizedAs(const Accessor& accessor, DracoMesh::Values values) {
    if (!accessor.normalized || values.normalized || accessor.component.kind == 'F') {
      return std::move(values.numbers);
    }
    const bool isSigned = accessor.component.kind == 'I';
    const double most = std::pow(2.0, 8.0 * static_cast<double>(accessor.component.size) - (isSigned ? 1 : 0)) - 1;
    for (float& v : values.numbers) v = std::max(static_cast<float>(static_cast<double>(v) / most), -1.0f);
    return std::move(values.numbers);
  }

  static void readUvs(const AttributeNumbers& numbers, const std::optional<TextureUse>& texture, Geometry& g) {
    std::vector<float> values = numbers(fmt::format("TEXCOORD_{}", texture ? texture->coordinates : 0));
    if (values.size() != 2 * g.points.size()) return;
    const TextureUse use = texture.value_or(TextureUse{});
    const double c = std::cos(use.rotation);
    const double s = std::sin(use.rotation);
    g.uvs.reserve(g.points.size());
    for (std::size_t i = 0; i < g.points.size(); ++i) {
      const double u = static_cast<double>(values[2 * i]) * use.scale[0];
      const double v = static_cast<double>(values[2 * i + 1]) * use.scale[1];
      // The rotation is counter-clockwise as seen with v pointing down (KHR_texture_transform).
      g.uvs.push_back(
          {static_cast<float>(use.offset[0] + c * u + s * v), 1 - static_cast<float>(use.offset[1] - s * u + c * v)});
    }
  }

  // Adds the instances of EXT_mesh_gpu_instancing: as InstancedParts, or as separate parts if a clip is loaded or if
  // fewer than two instances remain.
  void addInstances(const PlacedNode& placed, std::uint32_t number, const Attributes& attributes) {
    const Affine assetFromNode = assetFromFile_ * frameOf(placed);
    std::vector<Affine> nodeFromInstance = instanceTransforms(placed, attributes);
    // Singular transforms would flatten the mesh to a plane, a line or a point.
    std::erase_if(nodeFromInstance, [&](const Affine& t) { return isSingular((assetFromNode * t).linear); });
    if (options_.clip || nodeFromInstance.size() < 2) {
      uses_[*model_.nodes[placed.node].mesh] += nodeFromInstance.size();
      // Each copy gets a separate node index.
      const auto nodes = static_cast<std::uint32_t>(placed_.size());
      for (std::uint32_t i = 0; i < nodeFromInstance.size(); ++i) {
        append(asset_.parts, placed, number + i * nodes, assetFromNode * nodeFromInstance[i]);
      }
      return;
    }
    InstancedParts instanced;
    append(instanced.parts, placed, number, assetFromFile_);
    if (instanced.parts.empty()) return;
    const Affine fileFromAsset = inverse(assetFromFile_);
    for (const Affine& t : nodeFromInstance) instanced.assetFromParts.push_back(assetFromNode * t * fileFromAsset);
    asset_.instanced.push_back(std::move(instanced));
  }

  // Returns nodeFromInstance for each instance of a node.
  std::vector<Affine> instanceTransforms(const PlacedNode& placed, const Attributes& attributes) const {
    const std::string what = fmt::format("the instances of '{}'", placed.name);
    const auto numbers = [&](const char* name, std::size_t width) {
      const auto found = attributes.find(name);
      if (found == attributes.end()) return std::vector<float>();
      std::vector<float> values = data_.fractions(found->second, what);
      if (model_.accessors[found->second].width != width) {
        model_.fail(fmt::format("is not valid glTF: each {} of {} must have {} numbers", name, what, width));
      }
      return values;
    };
    const std::vector<float> translations = numbers("TRANSLATION", 3);
    const std::vector<float> rotations = numbers("ROTATION", 4);
    const std::vector<float> scales = numbers("SCALE", 3);
    const std::size_t count = std::max({translations.size() / 3, rotations.size() / 4, scales.size() / 3});
    chargeCopies(count, {model_.file.string()});
    std::vector<Affine> transforms;
    for (std::size_t i = 0; i < count; ++i) {
      Node node;  // an instance has the transform of a node without the attributes that are absent
      const auto take = [&](const std::vector<float>& values, auto& to) {
        const std::size_t first = to.size() * i;
        if (first < values.size()) std::copy_n(values.begin() + std::ptrdiff_t(first), to.size(), to.begin());
      };
      take(translations, node.translation);
      take(rotations, node.rotation);
      take(scales, node.scale);
      transforms.push_back(localOf(node));
    }
    return transforms;
  }

  Model model_;
  Data data_;
  Affine assetFromFile_;
  const AssetOptions& options_;
  std::vector<PlacedNode> placed_;
  std::optional<Poser> poser_;
  std::vector<ReadMaterial> materials_;
  std::vector<std::size_t> uses_;  // number of times that a mesh is placed, by mesh
  std::map<const Primitive*, std::shared_ptr<const Geometry>> sharedGeometry_;
  Asset asset_;
  std::uint64_t triangles_ = 0;
};

}  // namespace

Asset readAsset(const std::filesystem::path& file, const std::filesystem::path& name, const Affine& assetFromFile,
                const AssetOptions& options) {
  Model model = readModel(file, name, options.allowOutside);
  Affine frame = assetFromFile;
  if (model.center) {
    if (isOnEarth(*model.center)) {
      // The file is earth-centred; loaded alone, it is rotated to east-north-up.
      frame = {eastNorthUp(*model.center).linear * assetFromFile.linear, {}};
    } else {
      frame.translation = *model.center * options.metresPerUnit;
    }
  }
  LeftOut leftOut;
  Asset asset = Reader(std::move(model), frame, options).read(leftOut);
  leftOut.warn(name.string());
  return asset;
}

Asset readTile(const std::filesystem::path& file, const Affine& assetFromTile, const Mat3& zUpFromGltf,
               const AssetOptions& options, LeftOut& leftOut) {
  Model model = readModel(file, file, options.allowOutside);
  const Vec3d center = model.center.value_or(Vec3d{});
  return Reader(std::move(model), assetFromTile * Affine{zUpFromGltf, center}, options).read(leftOut);
}

std::vector<Clip> readClips(const std::filesystem::path& file) {
  const Model model = readModel(file, file, true);  // true: references may lead outside; readAsset() checked them
  const Data data(model);
  std::vector<Clip> clips;
  for (Index i = 0; i < model.animations.size(); ++i) {
    if (const auto span = spanOf(model, data, i)) clips.push_back({nameOf(model, i), span->first, span->second});
  }
  return clips;
}

std::pair<double, double> clipSpan(const std::filesystem::path& file, const std::string& clip) {
  const Model model = readModel(file, file, true);  // true: references may lead outside; readAsset() checked them
  const Index animation = animationNamed(model, clip);
  const auto span = spanOf(model, Data(model), animation);
  if (!span) model.fail(fmt::format("is not valid glTF: animations[{}] has no key frames", animation));
  return *span;
}

}  // namespace scanmill::gltf
