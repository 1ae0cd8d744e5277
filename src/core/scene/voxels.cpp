#include "scene/voxels.h"

#include <algorithm>
#include <array>
#include <unordered_map>
#include <utility>

#include "base/parallel.h"
#include "scene/triangle_pieces.h"

namespace scanmill {

namespace {

constexpr std::size_t kBlock = 128;    // number of consecutive triangles that share a box
constexpr std::uint32_t kSlab = 8;     // number of layers of voxels along x that a thread processes at a time
constexpr double kTie = 1e-9;          // areas that differ by at most this fraction count as equal
constexpr double kEnlargement = 1e-6;  // voxels; boxes are enlarged by this margin, which exceeds rounding errors

bool meets(const Box& box, const VoxelRange& range) {
  const auto along = [&](double low, double high, std::size_t axis) {
    return high + kEnlargement >= static_cast<double>(range.low[axis]) &&
           low - kEnlargement < static_cast<double>(range.high[axis]);
  };
  return along(box.low.x, box.high.x, 0) && along(box.low.y, box.high.y, 1) && along(box.low.z, box.high.z, 2);
}

// Returns the transform from a mesh's frame to the grid's frame, in units of voxels. It subtracts the translations
// first, so that a scene far from the origin gets the same labels.
Affine voxelsFromMesh(const VoxelGrid& grid, const Pose& worldFromGrid, const Affine& worldFromMesh) {
  const Mat3 gridFromWorld = transposed(toMatrix(worldFromGrid.rotation));
  const Vec3d inGrid = gridFromWorld * (worldFromMesh.translation - worldFromGrid.translation);
  const double perMetre = 1 / grid.size;
  return {Mat3::scale({perMetre, perMetre, perMetre}) * (gridFromWorld * worldFromMesh.linear), grid.inVoxels(inGrid)};
}

// The area of each class in each voxel of a slab. Most voxels have a single class and need no entry in the map.
class ClassAreas {
 public:
  explicit ClassAreas(std::size_t voxels) : area_(voxels, 0.0), class_(voxels, 0) {}

  void add(std::size_t voxel, std::uint16_t semantic, double area) {
    if (area_[voxel] == 0) class_[voxel] = semantic;
    if (class_[voxel] == semantic) {
      area_[voxel] += area;
    } else {
      others_[voxel << 16 | semantic] += area;
    }
  }

  bool empty(std::size_t voxel) const { return area_[voxel] == 0; }

  // Returns the class with the largest area in each voxel.
  const std::vector<std::uint16_t>& decide() {
    std::vector<std::pair<std::uint64_t, double>> sorted(others_.begin(), others_.end());
    std::ranges::sort(sorted);
    for (auto other = sorted.begin(); other != sorted.end();) {
      const std::size_t voxel = other->first >> 16;
      std::map<std::uint16_t, double> areas{{class_[voxel], area_[voxel]}};
      for (; other != sorted.end() && other->first >> 16 == voxel; ++other) {
        areas.emplace(other->first & 0xFFFF, other->second);
      }
      double largest = 0;
      for (const auto& [semantic, area] : areas) {
        if (area <= largest * (1 + kTie)) continue;
        largest = area;
        class_[voxel] = semantic;
      }
    }
    return class_;
  }

 private:
  std::vector<double> area_;
  std::vector<std::uint16_t> class_;
  std::unordered_map<std::uint64_t, double> others_;  // areas of the voxels' further classes, by voxel << 16 | class
};

}  // namespace

// Consecutive triangles of an instance that may be in the grid.
struct SceneVoxels::PlacedBlock {
  std::uint32_t instance = 0;  // index into Near::instances
  std::uint32_t first = 0;     // index of the first of these triangles in the mesh
  std::uint32_t last = 0;      // index of the last of these triangles, plus one
  Box box;                     // in units of voxels
};

struct SceneVoxels::Near {
  struct Placed {
    const Mesh& mesh;
    Affine voxelsFromMesh;
    std::vector<std::uint16_t> classOfSurface;
  };
  std::vector<Placed> instances;
  std::vector<PlacedBlock> blocks;
};

SceneVoxels::SceneVoxels(const Scene& scene) : scene_(scene), blocks_(scene.meshes.size()), bounds_(blocks_.size()) {
  parallelFor(scene.meshes.size(), 1, [&](std::size_t from, std::size_t to) {
    for (std::size_t m = from; m < to; ++m) {
      const Mesh& mesh = scene.meshes[m];
      blocks_[m].resize((mesh.triangles.size() + kBlock - 1) / kBlock);
      for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        for (const std::uint32_t corner : mesh.triangles[t]) blocks_[m][t / kBlock].add(Vec3d(mesh.positions[corner]));
      }
      for (const Box& block : blocks_[m]) bounds_[m].add(block);
    }
  });
  for (const SemanticClass& c : scene.ontology.classes) {
    if (c.movingOf) movingClasses_.emplace(*c.movingOf, c.id);
  }
  if (movingClasses_.empty()) return;
  for (const Instance& instance : scene.instances) {
    if (!instance.everMoves()) continue;
    for (std::uint32_t object = 1; object <= scene.meshes[instance.mesh].objects; ++object) {
      moving_.insert(instanceId(instance.firstInstanceId, object));
    }
  }
}

std::uint64_t SceneVoxels::memoryBytes() const {
  std::uint64_t bytes = bounds_.size() * sizeof(Box);
  for (const std::vector<Box>& boxes : blocks_) bytes += boxes.size() * sizeof(Box);
  return bytes;
}

// Returns the class of each surface of an instance's mesh. Objects that ever move get their class for moving objects.
std::vector<std::uint16_t> SceneVoxels::classesOf(const Instance& instance, const Mesh& mesh) const {
  std::vector<std::uint16_t> classes;
  classes.reserve(mesh.surfaces.size());
  for (const Surface& surface : mesh.surfaces) {
    classes.push_back(surface.semantic);
    if (surface.object == 0 || !moving_.contains(instanceId(instance, surface))) continue;
    const auto moving = movingClasses_.find(surface.semantic);
    if (moving != movingClasses_.end()) classes.back() = moving->second;
  }
  return classes;
}

SceneVoxels::Near SceneVoxels::nearOf(const VoxelGrid& grid, const Pose& worldFromGrid, double time) const {
  const VoxelRange all{{0, 0, 0}, {grid.counts[0], grid.counts[1], grid.counts[2]}};
  Near near;
  for (const Instance& instance : scene_.instances) {
    const std::uint32_t m = instance.meshAt(time);
    if (bounds_[m].empty()) continue;
    const Affine fromMesh = voxelsFromMesh(grid, worldFromGrid, instance.worldFromMeshAt(time));
    if (!meets(boxAround(fromMesh, bounds_[m]), all)) continue;
    const Mesh& mesh = scene_.meshes[m];
    const auto number = static_cast<std::uint32_t>(near.instances.size());
    near.instances.push_back({mesh, fromMesh, classesOf(instance, mesh)});
    for (std::size_t b = 0; b < blocks_[m].size(); ++b) {
      const Box box = boxAround(fromMesh, blocks_[m][b]);
      if (!meets(box, all)) continue;
      const std::size_t last = std::min((b + 1) * kBlock, mesh.triangles.size());
      near.blocks.push_back({number, static_cast<std::uint32_t>(b * kBlock), static_cast<std::uint32_t>(last), box});
    }
  }
  return near;
}

VoxelLabels SceneVoxels::labels(const VoxelGrid& grid, const Pose& worldFromGrid, double time) const {
  const Near near = nearOf(grid, worldFromGrid, time);
  const std::size_t layer = grid.index(1, 0, 0);
  const std::size_t slabs = (grid.counts[0] + kSlab - 1) / kSlab;
  VoxelLabels labels;
  labels.label.resize(grid.voxels());
  std::vector<std::vector<std::uint32_t>> unlabeled(slabs);
  // A single thread processes a slab, in the order of the triangles, so that sums are always rounded in the same way.
  parallelFor(slabs, 1, [&](std::size_t from, std::size_t to) {
    for (std::size_t slab = from; slab < to; ++slab) {
      const std::size_t firstX = slab * kSlab;
      const std::size_t lastX = std::min<std::size_t>(firstX + kSlab, grid.counts[0]);
      const VoxelRange range{{static_cast<std::int64_t>(firstX), 0, 0},
                             {static_cast<std::int64_t>(lastX), grid.counts[1], grid.counts[2]}};
      const std::size_t first = firstX * layer;
      ClassAreas areas((lastX - firstX) * layer);
      for (const PlacedBlock& block : near.blocks) {
        if (!meets(block.box, range)) continue;
        const Near::Placed& own = near.instances[block.instance];
        for (std::uint32_t t = block.first; t < block.last; ++t) {
          std::array<Vec3d, 3> corners;
          for (std::size_t k = 0; k < 3; ++k) {
            corners[k] = own.voxelsFromMesh * Vec3d(own.mesh.positions[own.mesh.triangles[t][k]]);
          }
          const std::uint16_t semantic = own.classOfSurface[own.mesh.surfaceOf[t]];
          forEachPiece(corners, range, [&](const std::array<std::int64_t, 3>& voxel, double area) {
            const std::size_t index =
                grid.index(static_cast<std::uint32_t>(voxel[0]), static_cast<std::uint32_t>(voxel[1]),
                           static_cast<std::uint32_t>(voxel[2]));
            areas.add(index - first, semantic, area);
          });
        }
      }
      const std::vector<std::uint16_t>& decided = areas.decide();
      std::ranges::copy(decided, labels.label.begin() + static_cast<std::ptrdiff_t>(first));
      for (std::size_t i = 0; i < decided.size(); ++i) {
        if (decided[i] == 0 && !areas.empty(i)) unlabeled[slab].push_back(static_cast<std::uint32_t>(first + i));
      }
    }
  });
  for (const std::vector<std::uint32_t>& own : unlabeled) {
    labels.unlabeled.insert(labels.unlabeled.end(), own.begin(), own.end());
  }
  return labels;
}

}  // namespace scanmill
