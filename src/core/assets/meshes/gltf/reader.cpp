#include "assets/meshes/gltf/reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <memory>
#include <numeric>
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

// Limits of the child process of decodeDracoInChild(), since a small file can require any amount of memory and time.
constexpr std::uint64_t kTrialMemory = std::uint64_t{2} << 30;  // bytes
constexpr std::uint64_t kTrialMemoryPerByte = 256;              // further bytes for every compressed byte
constexpr unsigned kTrialSeconds = 300;

// A function that returns all numbers of a primitive's attribute `name`, vertex by vertex; empty if the primitive lacks
// the attribute.
using AttributeNumbers = std::function<std::vector<float>(const std::string& name)>;

// Returns points, each from three successive numbers.
std::vector<Vec3d> toPoints(const std::vector<float>& numbers) {
  std::vector<Vec3d> points;
  points.reserve(numbers.size() / 3);
  for (std::size_t i = 0; i + 2 < numbers.size(); i += 3) {
    points.emplace_back(Vec3f{numbers[i], numbers[i + 1], numbers[i + 2]});
  }
  return points;
}

// Returns the triangles that the vertex indices `v` form as a list, a strip or a fan.
std::vector<Triangle> trianglesOf(Primitive::Mode mode, const std::vector<std::uint32_t>& v) {
  std::vector<Triangle> triangles;
  const std::size_t step = mode == Primitive::Mode::Triangles ? 3 : 1;
  triangles.reserve(v.size() / step);
  for (std::size_t i = 0; i + 2 < v.size(); i += step) {
    // In a strip, every second triangle has its vertices in the opposite order.
    const std::size_t swap = mode == Primitive::Mode::Strip ? i % 2 : 0;
    triangles.push_back(mode == Primitive::Mode::Fan ? Triangle{v[i + 1], v[i + 2], v[0]}
                                                     : Triangle{v[i], v[i + 1 + swap], v[i + 2 - swap]});
  }
  return triangles;
}

class Reader {
 public:
  Reader(Model model, const Affine& assetFromFile, const AssetOptions& options)
      : model_(std::move(model)), data_(model_), assetFromFile_(assetFromFile), options_(options) {
    if (options.clip) apply(*options.clip, data_, model_);
    placedNodes_ = placeNodes(model_);
    uses_.resize(model_.meshes.size(), 0);
    placedByNode_.resize(model_.nodes.size(), nullptr);
    for (const PlacedNode& placed : placedNodes_) {
      placedByNode_[placed.node] = &placed;
      if (const MaybeIndex mesh = model_.nodes[placed.node].mesh) ++uses_[*mesh];
    }
  }

  Asset read(LeftOut& leftOut) {
    checkCosts();
    decodeDracoInChild();
    materials_ = readMaterials(model_, data_, options_);
    for (std::uint32_t i = 0; i < placedNodes_.size(); ++i) {
      const PlacedNode& placed = placedNodes_[i];
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

  // Returns the weights of a node's morph targets; empty if all are 0.
  std::vector<double> targetWeights(const PlacedNode& placed) const {
    const Node& node = model_.nodes[placed.node];
    std::vector<double> weights = node.weights.empty() ? model_.meshes[*node.mesh].weights : node.weights;
    if (std::ranges::all_of(weights, [](double weight) { return weight == 0; })) weights.clear();
    return weights;
  }

  // Moves `points`, the vertices of a primitive of the node's mesh, by the weights of its morph targets. `what` is the
  // mesh's name in messages, here and below.
  void applyTargets(const PlacedNode& placed, const Primitive& primitive, const std::string& what,
                    std::vector<Vec3d>& points) const {
    const std::vector<double> weights = targetWeights(placed);
    for (std::size_t t = 0; t < std::min(primitive.targets.size(), weights.size()); ++t) {
      const auto target = primitive.targets[t].find("POSITION");
      if (weights[t] == 0 || target == primitive.targets[t].end()) continue;
      const std::vector<Vec3d> offsets = toPoints(data_.finiteFloats(target->second, what));
      if (offsets.size() != points.size()) {
        model_.fail("is not valid glTF: {} and its morph target have different numbers of vertices", what);
      }
      for (std::size_t i = 0; i < points.size(); ++i) points[i] = points[i] + offsets[i] * weights[t];
    }
  }

  // Returns for each joint the transform from the mesh's frame to the scene's frame for vertices that follow this joint
  // alone.
  std::vector<Affine> jointsOf(const Skin& skin, const std::string& what) const {
    std::vector<float> inverses;
    if (skin.inverseBindMatrices) inverses = data_.fractions(*skin.inverseBindMatrices, what);
    std::vector<Affine> joints;
    for (std::size_t j = 0; j < skin.joints.size(); ++j) {
      const PlacedNode* const placed = placedByNode_[skin.joints[j]];
      if (placed == nullptr) {
        model_.fail("is not valid glTF: a joint of the skin of {} is not a node of the scene", what);
      }
      joints.push_back(placed->sceneFromNode * (inverses.empty() ? Affine{} : toAffine(&inverses[16 * j])));
    }
    return joints;
  }

  // Moves the points of a primitive from the mesh's frame to the scene's by the node's skin: each vertex to the
  // weighted mean of the positions that its joints give it. A vertex whose weights are all 0 follows its first joint; a
  // vertex without joints follows the node.
  void applySkin(const PlacedNode& placed, const AttributeNumbers& numbers, const std::string& what,
                 std::vector<Vec3d>& points) const {
    const std::vector<Affine> joints = jointsOf(model_.skins[*model_.nodes[placed.node].skin], what);
    constexpr std::size_t kNoJoint = SIZE_MAX;
    // For each vertex: sums over its joints, and its first joint.
    std::vector<Vec3d> weightedPoints(points.size());
    std::vector<double> weightSums(points.size(), 0);
    std::vector<std::size_t> firstJoints(points.size(), kNoJoint);
    for (int set = 0;; ++set) {
      const std::vector<float> jointNumbers = numbers(fmt::format("JOINTS_{}", set));
      if (jointNumbers.empty()) break;
      const std::vector<float> weights = numbers(fmt::format("WEIGHTS_{}", set));
      if (jointNumbers.size() != 4 * points.size() || weights.size() != jointNumbers.size()) {
        model_.fail("is not valid glTF: {} must have four joints and four weights per vertex", what);
      }
      for (std::size_t i = 0; i < jointNumbers.size(); ++i) {
        const std::size_t vertex = i / 4;
        const auto joint = static_cast<std::size_t>(jointNumbers[i]);
        if (firstJoints[vertex] == kNoJoint && joint < joints.size()) firstJoints[vertex] = joint;
        if (weights[i] == 0) continue;
        if (joint >= joints.size()) {
          model_.fail("is not valid glTF: a vertex of {} refers to the joint {}, but its skin has {}", what, joint,
                      joints.size());
        }
        const auto weight = static_cast<double>(weights[i]);
        weightedPoints[vertex] = weightedPoints[vertex] + (joints[joint] * points[vertex]) * weight;
        weightSums[vertex] += weight;
      }
    }
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Affine& rigid = firstJoints[i] == kNoJoint ? placed.sceneFromNode : joints[firstJoints[i]];
      points[i] = weightSums[i] > 0 ? weightedPoints[i] * (1 / weightSums[i]) : rigid * points[i];
    }
  }

  // Throws InputError if the file would take too much memory: a small file may place its meshes any number of times.
  void checkCosts() const {
    double triangles = 0, storedTriangles = 0;                   // triangles: all copies; the stored ones
    std::set<std::pair<Index, std::optional<Index>>> accessors;  // accessors of positions and indices so far
    for (const PlacedNode& placed : placedNodes_) {
      const Node& node = model_.nodes[placed.node];
      if (!placed.visible || !node.mesh) continue;
      std::uint64_t copies = 1;  // instances become copies if a clip is loaded
      if (node.instances && options_.clip && !node.instances->empty()) {
        copies = model_.accessors[node.instances->begin()->second].count;
      }
      for (const Primitive& primitive : model_.meshes[*node.mesh].primitives) {
        const Index positions = primitive.attributes.at("POSITION");
        const auto corners = static_cast<double>(model_.accessors[primitive.indices.value_or(positions)].count);
        chargeCopies(copies, {model_.file.string()});
        const double count = primitive.mode == Primitive::Mode::Triangles ? corners / 3 : corners;
        triangles += static_cast<double>(copies) * count;
        if (accessors.emplace(positions, primitive.indices).second) storedTriangles += count;
      }
    }
    chargeBytes(kBytesPerTriangle * (triangles - storedTriangles), {model_.file.string()});
    const double bytes = triangles * static_cast<double>(sizeof(Triangle));
    if (bytes > static_cast<double>(memoryLimitBytes())) {
      model_.fail("has triangles that take {}, which is more than the memory: split it", shortBytes(bytes));
    }
    if (triangles > static_cast<double>(kMostTriangles)) {
      model_.fail("has more than {} triangles, with all copies: split it", kMostTriangles);
    }
  }

  // Decodes all Draco data in a child process first, since damaged data can require any amount of memory.
  void decodeDracoInChild() const {
    std::vector<Primitive::Draco> compressed;
    std::uint64_t bytes = 0;
    for (const Mesh& mesh : model_.meshes) {
      for (const Primitive& primitive : mesh.primitives) {
        if (!primitive.draco) continue;
        compressed.push_back(*primitive.draco);
        bytes += model_.views[primitive.draco->view].length;
      }
    }
    if (bytes == 0) return;
    const auto decodeAll = [&] {
      for (const Primitive::Draco& draco : compressed) decodeDraco(data_.view(draco.view), draco.attributes);
      return std::string();
    };
    try {
      inChildProcess(decodeAll, kTrialMemory + kTrialMemoryPerByte * bytes, kTrialSeconds);
    } catch (const Error& e) {
      model_.fail("has damaged meshes: {}; export it again", e.what());
    }
  }

  // Appends the parts of a node, one part per material. `nodeIndex`: AssetPart::nodeIndex of the parts.
  void append(std::vector<AssetPart>& parts, const PlacedNode& placed, std::uint32_t nodeIndex,
              const Affine& assetFromNode) {
    const std::size_t first = parts.size();
    for (const Primitive& primitive : model_.meshes[*model_.nodes[placed.node].mesh].primitives) {
      const std::size_t material = primitive.material.value_or(materials_.size() - 1);
      const std::optional<TextureUse>& texture = materials_[material].placed;
      const std::shared_ptr<const Geometry> geometry = sharedGeometry(primitive, placed, texture);
      asset_.dropped.outOfRange += geometry->dropped;
      triangles_ += geometry->triangles.size();
      if (triangles_ > kMostTriangles)
        model_.fail("has more than {} triangles, with all copies: split it", kMostTriangles);
      scanmill::append(*geometry, assetFromNode, static_cast<std::uint32_t>(material), texture.has_value(), first,
                       parts);
    }
    finishNode(placed.name, nodeIndex, first, parts);
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
    const Node& node = model_.nodes[placed.node];
    const bool isShared = !node.skin && targetWeights(placed).empty() && uses_[*node.mesh] > 1;
    if (!isShared) return std::make_shared<const Geometry>(geometryOf(primitive, placed, texture));
    std::shared_ptr<const Geometry>& shared = sharedGeometry_[&primitive];
    if (shared == nullptr) shared = std::make_shared<const Geometry>(geometryOf(primitive, placed, texture));
    return shared;
  }

  // Returns the numbers of an attribute of a primitive, vertex by vertex; see AttributeNumbers. `draco`: the decoded
  // primitive if it is compressed, else nullopt. `what` names the mesh in messages.
  std::vector<float> numbersOf(const std::string& attribute, const Primitive& primitive,
                               const std::optional<DracoMesh>& draco, const std::string& what) const {
    const auto accessor = primitive.attributes.find(attribute);
    if (draco && draco->attributes.contains(attribute)) {
      const DracoMesh::Values& values = draco->attributes.at(attribute);
      return accessor == primitive.attributes.end() ? values.numbers
                                                    : normalizedAs(model_.accessors[accessor->second], values);
    }
    if (accessor == primitive.attributes.end()) return {};
    if (attribute.starts_with("WEIGHTS_")) return data_.fractions(accessor->second, what);
    if (!attribute.starts_with("JOINTS_")) return data_.floats(accessor->second, what);
    const std::vector<std::uint32_t> joints = data_.integers(accessor->second, what);
    return {joints.begin(), joints.end()};
  }

  // Returns the geometry of a primitive: posed in the scene's frame if its node has a skin, else in the node's frame.
  Geometry geometryOf(const Primitive& primitive, const PlacedNode& placed, const std::optional<TextureUse>& texture) {
    const std::string what = fmt::format("the mesh of '{}'", placed.name);
    chargeTime({model_.file.string()});  // many primitives may share one long list of vertices
    std::optional<DracoMesh> draco;
    if (primitive.draco) draco = decodeDraco(data_.view(primitive.draco->view), primitive.draco->attributes);
    const AttributeNumbers numbers = [&](const std::string& name) { return numbersOf(name, primitive, draco, what); };
    Geometry geometry;
    geometry.points = toPoints(numbers("POSITION"));
    applyTargets(placed, primitive, what, geometry.points);
    if (model_.nodes[placed.node].skin) applySkin(placed, numbers, what, geometry.points);
    readUvs(numbers, texture, geometry);
    std::vector<std::uint32_t> indices(geometry.points.size());
    std::iota(indices.begin(), indices.end(), 0u);
    if (draco) {
      indices = std::move(draco->indices);
    } else if (primitive.indices) {
      indices = data_.integers(*primitive.indices, what);
    }
    geometry.triangles = trianglesOf(draco ? Primitive::Mode::Triangles : primitive.mode, indices);
    const std::size_t vertices = geometry.points.size();
    const auto isOutOfRange = [&](const Triangle& triangle) { return std::ranges::max(triangle) >= vertices; };
    geometry.dropped = static_cast<std::uint64_t>(std::erase_if(geometry.triangles, isOutOfRange));
    dropUnusedVertices(geometry);
    return geometry;
  }

  // Drops unused vertices, since primitives often share one long list of vertices.
  static void dropUnusedVertices(Geometry& geometry) {
    auto& [points, uvs, triangles, dropped] = geometry;
    constexpr std::uint32_t kUnused = UINT32_MAX;
    std::vector<std::uint32_t> newIndex(points.size(), kUnused);
    for (const Triangle& triangle : triangles) {
      for (const std::uint32_t corner : triangle) newIndex[corner] = 0;
    }
    std::uint32_t used = 0;
    for (std::size_t i = 0; i < newIndex.size(); ++i) {
      if (newIndex[i] == kUnused) continue;
      points[used] = points[i];
      if (!uvs.empty()) uvs[used] = uvs[i];
      newIndex[i] = used++;
    }
    points.resize(used);
    if (!uvs.empty()) uvs.resize(used);
    for (Triangle& triangle : triangles) {
      for (std::uint32_t& corner : triangle) corner = newIndex[corner];
    }
  }

  // Returns the decoded numbers, normalized if the accessor that they replace is normalized.
  static std::vector<float> normalizedAs(const Accessor& accessor, DracoMesh::Values values) {
    if (!accessor.normalized || values.normalized || accessor.component.kind == 'F') {
      return std::move(values.numbers);
    }
    const bool isSigned = accessor.component.kind == 'I';
    const double greatest = std::pow(2.0, 8.0 * static_cast<double>(accessor.component.size) - (isSigned ? 1 : 0)) - 1;
    for (float& number : values.numbers) {
      number = std::max(static_cast<float>(static_cast<double>(number) / greatest), -1.0f);
    }
    return std::move(values.numbers);
  }

  // Sets the texture coordinates of the geometry, transformed as the material demands. Leaves them empty if the file
  // does not have them for each point. The points of the geometry must be set before.
  static void readUvs(const AttributeNumbers& numbers, const std::optional<TextureUse>& texture, Geometry& geometry) {
    const TextureUse use = texture.value_or(TextureUse{});
    const std::vector<float> values = numbers(fmt::format("TEXCOORD_{}", use.coordinates));
    if (values.size() != 2 * geometry.points.size()) return;
    const double cosine = std::cos(use.rotation), sine = std::sin(use.rotation);
    geometry.uvs.reserve(geometry.points.size());
    for (std::size_t i = 0; i < values.size(); i += 2) {
      const double u = static_cast<double>(values[i]) * use.scale[0];
      const double v = static_cast<double>(values[i + 1]) * use.scale[1];
      // The rotation is counter-clockwise as seen with v pointing down (KHR_texture_transform).
      geometry.uvs.push_back({static_cast<float>(use.offset[0] + cosine * u + sine * v),
                              1 - static_cast<float>(use.offset[1] - sine * u + cosine * v)});
    }
  }

  // Adds the instances of EXT_mesh_gpu_instancing as InstancedParts. If a clip is loaded or there are fewer than two
  // instances, adds them as separate parts instead.
  void addInstances(const PlacedNode& placed, std::uint32_t nodeIndex, const Attributes& attributes) {
    const Affine assetFromNode = assetFromFile_ * frameOf(placed);
    std::vector<Affine> nodeFromInstance = instanceTransforms(placed, attributes);
    // Singular transforms would flatten the mesh to a plane, a line or a point.
    std::erase_if(nodeFromInstance, [&](const Affine& t) { return isSingular((assetFromNode * t).linear); });
    if (options_.clip || nodeFromInstance.size() < 2) {
      uses_[*model_.nodes[placed.node].mesh] += nodeFromInstance.size();
      // Each copy gets a separate node index.
      const auto nodes = static_cast<std::uint32_t>(placedNodes_.size());
      for (std::uint32_t i = 0; i < nodeFromInstance.size(); ++i) {
        append(asset_.parts, placed, nodeIndex + i * nodes, assetFromNode * nodeFromInstance[i]);
      }
      return;
    }
    InstancedParts instanced;
    append(instanced.parts, placed, nodeIndex, assetFromFile_);
    if (instanced.parts.empty()) return;
    const Affine fileFromAsset = inverse(assetFromFile_);
    for (const Affine& t : nodeFromInstance) instanced.assetFromParts.push_back(assetFromNode * t * fileFromAsset);
    asset_.instanced.push_back(std::move(instanced));
  }

  // Returns for each instance of a node the transform from the instance's frame to the node's frame.
  std::vector<Affine> instanceTransforms(const PlacedNode& placed, const Attributes& attributes) const {
    const std::string what = fmt::format("the instances of '{}'", placed.name);
    const auto numbers = [&](const char* name, std::size_t width) {
      const auto accessor = attributes.find(name);
      if (accessor == attributes.end()) return std::vector<float>();
      std::vector<float> values = data_.fractions(accessor->second, what);
      if (model_.accessors[accessor->second].width != width) {
        model_.fail("is not valid glTF: each {} of {} must have {} numbers", name, what, width);
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
      Node node;  // absent attributes of an instance have the defaults of a node
      const auto copyTo = [&](auto& member, const std::vector<float>& values) {
        const std::size_t first = member.size() * i;
        if (first < values.size()) std::copy_n(values.begin() + std::ptrdiff_t(first), member.size(), member.begin());
      };
      copyTo(node.translation, translations);
      copyTo(node.rotation, rotations);
      copyTo(node.scale, scales);
      transforms.push_back(localOf(node));
    }
    return transforms;
  }

  Model model_;
  Data data_;
  Affine assetFromFile_;
  const AssetOptions& options_;
  std::vector<PlacedNode> placedNodes_;
  std::vector<const PlacedNode*> placedByNode_;  // null for nodes that are not in the scene
  std::vector<ReadMaterial> materials_;
  std::vector<std::size_t> uses_;  // number of times that a mesh is placed, by mesh
  std::map<const Primitive*, std::shared_ptr<const Geometry>> sharedGeometry_;
  Asset asset_;
  std::uint64_t triangles_ = 0;  // number of triangles so far, with all copies
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
  if (!span) model.fail("is not valid glTF: animations[{}] has no key frames", animation);
  return *span;
}

}  // namespace scanmill::gltf
