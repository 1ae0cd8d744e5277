#include "scene/voxels.h"

#include <algorithm>
#include <array>
#include <unordered_map>

#include "base/parallel.h"
#include "scene/triangle_pieces.h"
#include "scene/triangles.h"

namespace scanmill {

namespace {

constexpr std::size_t kBlock = 128;    // number of consecutive triangles that share a box
constexpr std::uint32_t kSlab = 8;     // number of layers of voxels along x that a thread processes at a time
constexpr double kTie = 1e-9;          // areas that differ by at most this fraction count as equal
constexpr double kEnlargement = 1e-6;  // voxels; boxes are enlarged by this margin, which exceeds rounding errors

// True if a box (in units of voxels), enlarged by kEnlargement, overlaps a range.
bool overlaps(const Box& box, const VoxelRange& range) {
  const auto overlapsAlong = [&](double low, double high, std::size_t axis) {
    return high + kEnlargement >= static_cast<double>(range.low[axis]) &&
           low - kEnlargement < static_cast<double>(range.high[axis]);
  };
  return overlapsAlong(box.low.x, box.high.x, 0) && overlapsAlong(box.low.y, box.high.y, 1) &&
         overlapsAlong(box.low.z, box.high.z, 2);
}

// Returns the transform from a mesh's frame (m) to the grid's frame in units of voxels. It subtracts the translations
// first, so that a scene far from the origin gets the same labels.
Affine voxelsFromMesh(const VoxelGrid& grid, const Pose& worldFromGrid, const Affine& worldFromMesh) {
  const Mat3 gridFromWorld = transposed(toMatrix(worldFromGrid.rotation));
  const Vec3d inGrid = gridFromWorld * (worldFromMesh.translation - worldFromGrid.translation);
  const double perMetre = 1 / grid.size;
  return {Mat3::scale({perMetre, perMetre, perMetre}) * (gridFromWorld * worldFromMesh.linear), grid.inVoxels(inGrid)};
}

// The area of each class in each voxel of a slab, in units of squared voxel edges. Most voxels have a single class and
// need no entry in `furtherAreas_`.
class ClassAreas {
 public:
  explicit ClassAreas(std::size_t voxels) : firstArea_(voxels, 0.0), firstClass_(voxels, 0) {}

  void add(std::size_t voxel, std::uint16_t semantic, double area) {
    if (firstArea_[voxel] == 0) firstClass_[voxel] = semantic;
    if (firstClass_[voxel] == semantic) {
      firstArea_[voxel] += area;
    } else {
      furtherAreas_[voxel << 16 | semantic] += area;
    }
  }

  bool empty(std::size_t voxel) const { return firstArea_[voxel] == 0; }

  // Returns the class with the largest area in each voxel, the smallest class id if areas are equal; 0 if the voxel is
  // empty.
  std::vector<std::uint16_t> largestClasses() const {
    std::unordered_map<std::size_t, std::map<std::uint16_t, double>> areasByVoxel;  // voxels of several classes
    for (const auto& [key, area] : furtherAreas_) {
      const std::size_t voxel = key >> 16;
      std::map<std::uint16_t, double>& areas = areasByVoxel[voxel];
      areas.emplace(firstClass_[voxel], firstArea_[voxel]);
      areas.emplace(key & 0xFFFF, area);
    }
    std::vector<std::uint16_t> classes = firstClass_;
    for (const auto& [voxel, areas] : areasByVoxel) {
      double largest = 0;
      for (const auto& [semantic, area] : areas) {
        if (area <= largest * (1 + kTie)) continue;
        largest = area;
        classes[voxel] = semantic;
      }
    }
    return classes;
  }

 private:
  std::vector<double> firstArea_;          // by voxel: area of the first class
  std::vector<std::uint16_t> firstClass_;  // by voxel: the class that was added first; 0: the voxel is empty
  std::unordered_map<std::uint64_t, double> furtherAreas_;  // areas of further classes, by voxel << 16 | class
};

// An instance that may have triangles in the grid.
struct Candidate {
  struct Block {
    std::uint32_t first = 0;  // index of the first of some consecutive triangles
    std::uint32_t last = 0;   // index of the last of these triangles, plus one
    Box box;                  // in units of voxels
  };
  const Mesh& mesh;
  Affine voxelsFromMesh;
  std::vector<std::uint16_t> classOfSurface;  // by index in Mesh::surfaces
  std::vector<Block> blocks = {};
};

// Labels the voxels of the layers `firstX` to `lastX` - 1 along x, and appends non-empty voxels without a class to
// `unlabeled`. Adds areas in the order of the triangles, so that sums are always rounded in the same way.
void labelLayers(const VoxelGrid& grid, const std::vector<Candidate>& candidates, std::uint32_t firstX,
                 std::uint32_t lastX, VoxelLabels& labels, std::vector<std::uint32_t>& unlabeled) {
  const VoxelRange range{.low = {firstX, 0, 0}, .high = {lastX, grid.counts[1], grid.counts[2]}};
  const std::size_t firstVoxel = grid.index(firstX, 0, 0);
  ClassAreas areas(grid.index(lastX, 0, 0) - firstVoxel);
  for (const auto& [mesh, voxelsFromMesh, classOfSurface, blocks] : candidates) {
    for (const Candidate::Block& block : blocks) {
      if (!overlaps(block.box, range)) continue;
      for (std::uint32_t t = block.first; t < block.last; ++t) {
        const std::uint16_t semantic = classOfSurface[mesh.surfaceOf[t]];
        forEachPiece(cornersOf(voxelsFromMesh, mesh, t), range,
                     [&](const std::array<std::int64_t, 3>& voxel, double area) {
                       const auto [x, y, z] = voxel;
                       areas.add(grid.index(static_cast<std::uint32_t>(x), static_cast<std::uint32_t>(y),
                                            static_cast<std::uint32_t>(z)) -
                                     firstVoxel,
                                 semantic, area);
                     });
      }
    }
  }
  const std::vector<std::uint16_t> classes = areas.largestClasses();
  std::ranges::copy(classes, labels.label.begin() + static_cast<std::ptrdiff_t>(firstVoxel));
  for (std::size_t i = 0; i < classes.size(); ++i) {
    if (classes[i] == 0 && !areas.empty(i)) unlabeled.push_back(static_cast<std::uint32_t>(firstVoxel + i));
  }
}

}  // namespace

SceneVoxels::SceneVoxels(const Scene& scene) : scene_(scene), blocks_(scene.meshes.size()), bounds_(blocks_.size()) {
  parallelForEach(scene.meshes.size(), 1, [&](std::size_t m) {
    const Mesh& mesh = scene.meshes[m];
    blocks_[m].resize((mesh.triangles.size() + kBlock - 1) / kBlock);
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
      for (const std::uint32_t corner : mesh.triangles[t]) blocks_[m][t / kBlock].add(Vec3d(mesh.positions[corner]));
    }
    for (const Box& block : blocks_[m]) bounds_[m].add(block);
  });
  for (const SemanticClass& c : scene.ontology.classes) {
    if (c.movingOf) movingClasses_.emplace(*c.movingOf, c.id);
  }
  if (movingClasses_.empty()) return;
  for (const Instance& instance : scene.instances) {
    if (!instance.everMoves()) continue;
    for (std::uint32_t object = 1; object <= scene.meshes[instance.mesh].objects; ++object) {
      movingIds_.insert(instanceId(instance.firstInstanceId, object));
    }
  }
}

std::uint64_t SceneVoxels::memoryBytes() const {
  std::uint64_t bytes = bounds_.size() * sizeof(Box);
  for (const std::vector<Box>& boxes : blocks_) bytes += boxes.size() * sizeof(Box);
  return bytes;
}

// Returns the class of each surface of a mesh; for an object that ever moves, its class for moving objects, if any.
std::vector<std::uint16_t> SceneVoxels::classesOf(const Instance& instance, const Mesh& mesh) const {
  std::vector<std::uint16_t> classes;
  for (const Surface& surface : mesh.surfaces) {
    classes.push_back(surface.semantic);
    if (surface.object == 0 || !movingIds_.contains(instanceId(instance, surface))) continue;
    const auto moving = movingClasses_.find(surface.semantic);
    if (moving != movingClasses_.end()) classes.back() = moving->second;
  }
  return classes;
}

VoxelLabels SceneVoxels::labels(const VoxelGrid& grid, const Pose& worldFromGrid, double time) const {
  const VoxelRange gridRange{{0, 0, 0}, {grid.counts[0], grid.counts[1], grid.counts[2]}};
  std::vector<Candidate> candidates;
  for (const Instance& instance : scene_.instances) {
    const std::uint32_t m = instance.meshAt(time);
    if (bounds_[m].empty()) continue;
    const Affine fromMesh = voxelsFromMesh(grid, worldFromGrid, instance.worldFromMeshAt(time));
    if (!overlaps(boxAround(fromMesh, bounds_[m]), gridRange)) continue;
    const Mesh& mesh = scene_.meshes[m];
    candidates.push_back({mesh, fromMesh, classesOf(instance, mesh)});
    for (std::size_t block = 0; block < blocks_[m].size(); ++block) {
      const Box box = boxAround(fromMesh, blocks_[m][block]);
      if (!overlaps(box, gridRange)) continue;
      const std::size_t last = std::min((block + 1) * kBlock, mesh.triangles.size());
      candidates.back().blocks.push_back(
          {static_cast<std::uint32_t>(block * kBlock), static_cast<std::uint32_t>(last), box});
    }
  }
  const std::uint32_t slabs = (grid.counts[0] + kSlab - 1) / kSlab;
  VoxelLabels labels;
  labels.label.resize(grid.voxels());
  std::vector<std::vector<std::uint32_t>> unlabeled(slabs);
  parallelForEach(slabs, 1, [&](std::size_t slab) {
    const auto firstX = static_cast<std::uint32_t>(slab * kSlab);
    labelLayers(grid, candidates, firstX, std::min(firstX + kSlab, grid.counts[0]), labels, unlabeled[slab]);
  });
  for (const std::vector<std::uint32_t>& slabVoxels : unlabeled) {
    labels.unlabeled.insert(labels.unlabeled.end(), slabVoxels.begin(), slabVoxels.end());
  }
  return labels;
}

}  // namespace scanmill
