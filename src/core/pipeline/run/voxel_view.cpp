#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "base/parallel.h"
#include "pipeline/run/sample_maker.h"

namespace scanmill {

namespace {

constexpr std::size_t kBeamsAtOnce = 1024;  // number of beams that a thread processes at a time

// Bits of a voxel's mark. kEnds: the axis of a beam ends in the voxel; kPasses: an axis passes through the voxel.
constexpr std::uint8_t kEnds = 1;
constexpr std::uint8_t kPasses = 2;

// Sets a bit of a voxel's mark. Several threads may mark the same voxel at once; bits are never cleared.
void setBit(std::uint8_t& mark, std::uint8_t bit) {
  const std::atomic_ref<std::uint8_t> shared(mark);
  if ((shared.load(std::memory_order_relaxed) & bit) == 0) shared.fetch_or(bit, std::memory_order_relaxed);
}

// Marks the voxels that a ray of the given length (m) passes through, and the voxel in which the ray ends (Amanatides
// and Woo, "A fast voxel traversal algorithm for ray tracing", Eurographics 1987). `origin` (m) and `direction` (unit
// vector) are in the grid's frame.
void markRay(const VoxelGrid& grid, const Vec3d& origin, const Vec3d& direction, double length,
             std::vector<std::uint8_t>& marks) {
  if (const auto end = grid.at(origin + direction * length)) setBit(marks[*end], kEnds);
  const Vec3d o = grid.inVoxels(origin);
  const std::array<double, 3> start{o.x, o.y, o.z};  // in units of voxels
  const std::array<double, 3> perMetre{direction.x / grid.size, direction.y / grid.size, direction.z / grid.size};
  double enter = 0;  // m, distance along the ray at which it enters the grid
  double leave = length;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double count = grid.counts[axis];
    if (perMetre[axis] == 0) {
      if (!(start[axis] >= 0 && start[axis] < count)) return;
      continue;
    }
    const double toLow = -start[axis] / perMetre[axis];
    const double toHigh = (count - start[axis]) / perMetre[axis];
    enter = std::max(enter, std::min(toLow, toHigh));
    leave = std::min(leave, std::max(toLow, toHigh));
  }
  if (!(enter < leave)) return;
  const std::array<std::int64_t, 3> stride{std::int64_t{grid.counts[1]} * grid.counts[2], grid.counts[2], 1};
  std::array<std::int64_t, 3> cell{};    // indices of the current voxel
  std::array<std::int64_t, 3> step{};    // 1 or -1, of the index along each axis
  std::array<double, 3> nextFace{};      // m, distance along the ray to the next face of each axis
  std::array<double, 3> betweenFaces{};  // m, distance along the ray between faces of each axis
  std::int64_t voxel = 0;                // index of the current voxel in the grid
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto last = std::int64_t{grid.counts[axis]} - 1;
    cell[axis] =
        std::clamp(static_cast<std::int64_t>(std::floor(start[axis] + perMetre[axis] * enter)), std::int64_t{0}, last);
    voxel += cell[axis] * stride[axis];
    step[axis] = perMetre[axis] < 0 ? -1 : 1;
    const double face = static_cast<double>(cell[axis] + (perMetre[axis] < 0 ? 0 : 1));
    nextFace[axis] =
        perMetre[axis] == 0 ? std::numeric_limits<double>::infinity() : (face - start[axis]) / perMetre[axis];
    betweenFaces[axis] = std::abs(1 / perMetre[axis]);
  }
  for (;;) {
    const std::size_t nearest01 = nextFace[0] < nextFace[1] ? 0 : 1;
    const std::size_t axis = nextFace[nearest01] < nextFace[2] ? nearest01 : 2;
    if (nextFace[axis] > length) return;
    setBit(marks[static_cast<std::size_t>(voxel)], kPasses);
    cell[axis] += step[axis];
    if (cell[axis] < 0 || cell[axis] >= grid.counts[axis]) return;
    voxel += step[axis] * stride[axis];
    nextFace[axis] += betweenFaces[axis];
  }
}

// Returns the length of each beam's axis (m): the distance to its hit or, if it hits nothing, the maximum range. If
// each beam has one ray, the axis passes through glass to the farthest hit. The length is 0 if the axis is unresolved,
// or if it has no hit because the ego vehicle blocks it.
std::vector<double> beamLengths(const Shot& shot, std::uint32_t raysPerBeam, const Hits& hits) {
  std::vector<double> lengths(hits.size());
  for (std::size_t beam = 0; beam < hits.size(); ++beam) {
    const std::size_t axis = beam * raysPerBeam;
    const bool blocked = !hits.pathOfRay.empty() && hits.pathOfRay[axis] == RayPath::EgoVehicle;
    if (hits.hit(axis)) {
      lengths[beam] = hits.range[axis];
    } else if (!blocked && !std::ranges::binary_search(hits.unresolved, axis)) {
      lengths[beam] = shot.beams->maxRange;
    }
  }
  // The rays with indices from hits.size() on continue other rays behind glass or off mirrors, and have hits. If a beam
  // has several rays, a hit behind glass cannot be assigned to its axis; therefore only axes of single-ray beams are
  // extended.
  const std::size_t end = raysPerBeam == 1 ? hits.rays() : 0;
  for (std::size_t ray = hits.size(); ray < end; ++ray) {
    if (hits.pathOfRay[ray] != RayPath::ThroughGlass) continue;
    double& length = lengths[hits.beamOfRay[ray]];
    if (length > 0) length = std::max(length, double{hits.range[ray]});
  }
  return lengths;
}

// Returns, for each pose of the shot, the transform from the sensor's frame at this pose to the grid's frame.
std::vector<Affine> gridFromSteps(const Shot& shot) {
  const Pose& front = shot.worldFromSensor.front();
  const Mat3 frontFromWorld = transposed(toMatrix(front.rotation));
  // Translations are subtracted before they are rotated: rotating large world coordinates would lose precision.
  std::vector<Affine> gridFromStep;
  for (const Pose& pose : shot.worldFromSensor) {
    gridFromStep.push_back(
        {frontFromWorld * toMatrix(pose.rotation), frontFromWorld * (pose.translation - front.translation)});
  }
  return gridFromStep;
}

// Returns for each voxel 1 if it contains a point, otherwise 0. The points of a moving sensor are in the sensor's frame
// at the time of their column, unless they are deskewed.
std::vector<std::uint8_t> voxelsWithPoints(const VoxelGrid& grid, const Shot& shot, const Scan& scan) {
  const std::vector<Affine> gridFromStep = gridFromSteps(shot);
  const bool skewed = gridFromStep.size() > 1 && !shot.deskew;
  std::vector<std::uint8_t> input(grid.voxels());
  for (std::size_t row = 0; row < scan.size(); ++row) {
    Vec3d position(scan.position[row]);
    if (skewed) {
      const auto column =
          scan.organised ? static_cast<std::uint32_t>(row % scan.columns) : std::uint32_t{scan[kColumn][row]};
      position = gridFromStep[shot.stepOf(column)] * position;
    }
    if (const auto voxel = grid.at(position)) input[*voxel] = 1;
  }
  return input;
}

// Returns the mark of each voxel (kEnds, kPasses), set by the axes of all beams.
std::vector<std::uint8_t> beamMarks(const VoxelGrid& grid, const Shot& shot, std::uint32_t raysPerBeam,
                                    const Hits& hits) {
  const BeamTable& beams = *shot.beams;
  const std::vector<Affine> gridFromStep = gridFromSteps(shot);
  const std::vector<double> lengths = beamLengths(shot, raysPerBeam, hits);
  std::vector<std::uint8_t> marks(grid.voxels());
  parallelForEach(lengths.size(), kBeamsAtOnce, [&](std::size_t beam) {
    if (!(lengths[beam] > 0)) return;
    const Affine& gridFromSensor = gridFromStep[shot.stepOf(static_cast<std::uint32_t>(beam % beams.columns))];
    const Vec3d origin = beams.originOf(beam);
    markRay(grid, gridFromSensor * origin, gridFromSensor.linear * beams.direction[beam], lengths[beam], marks);
  });
  return marks;
}

// Calls visit(index) for each voxel of the grid that shares a face with `voxel`.
template <class Visit>
void forEachNeighbor(const VoxelGrid& grid, std::size_t voxel, const Visit& visit) {
  std::size_t remainder = voxel;
  std::size_t stride = 1;
  for (const std::size_t axis : {2u, 1u, 0u}) {
    const std::size_t index = remainder % grid.counts[axis];
    if (index > 0) visit(voxel - stride);
    if (index + 1 < grid.counts[axis]) visit(voxel + stride);
    remainder /= grid.counts[axis];
    stride *= grid.counts[axis];
  }
}

// Returns for each voxel 1 if it is open, otherwise 0. An empty voxel is open if a chain of empty voxels that share
// faces connects it to a voxel that a beam passes through. `solid`: not 0 for voxels with surfaces. `marks`: as
// beamMarks() returns them.
std::vector<std::uint8_t> openVoxels(const VoxelGrid& grid, const std::vector<std::uint8_t>& solid,
                                     const std::vector<std::uint8_t>& marks) {
  std::vector<std::uint8_t> open(solid.size());
  std::vector<std::uint32_t> frontier;
  const auto reach = [&](std::size_t voxel) {
    if (solid[voxel] != 0 || open[voxel] != 0) return;
    open[voxel] = 1;
    frontier.push_back(static_cast<std::uint32_t>(voxel));
  };
  for (std::size_t voxel = 0; voxel < solid.size(); ++voxel) {
    if ((marks[voxel] & kPasses) == 0) continue;
    reach(voxel);
    while (!frontier.empty()) {
      const std::size_t current = frontier.back();
      frontier.pop_back();
      forEachNeighbor(grid, current, reach);
    }
  }
  return open;
}

}  // namespace

ScanVoxels viewVoxels(const VoxelGrid& grid, VoxelLabels labels, const Shot& shot, std::uint32_t raysPerBeam,
                      const Hits& hits, const Scan& scan) {
  const std::size_t count = grid.voxels();
  ScanVoxels voxels{grid, std::move(labels.label), voxelsWithPoints(grid, shot, scan), std::vector<std::uint8_t>(count),
                    std::vector<std::uint8_t>(count)};
  const std::vector<std::uint8_t> marks = beamMarks(grid, shot, raysPerBeam, hits);
  std::vector<std::uint8_t> solid(count);
  for (std::size_t i = 0; i < count; ++i) solid[i] = voxels.label[i] != 0 ? 1 : 0;
  for (const std::uint32_t voxel : labels.unlabeled) solid[voxel] = 1;
  const std::vector<std::uint8_t> open = openVoxels(grid, solid, marks);
  for (std::size_t i = 0; i < count; ++i) {
    voxels.unseen[i] = marks[i] == 0 ? 1 : 0;
    bool visible = marks[i] != 0 || open[i] != 0;  // true: a sensor could see the voxel
    if (!visible && solid[i] != 0)
      forEachNeighbor(grid, i, [&](std::size_t neighbor) { visible = visible || open[neighbor] != 0; });
    voxels.invalid[i] = visible ? 0 : 1;
  }
  for (const std::uint32_t voxel : labels.unlabeled) voxels.invalid[voxel] = 1;
  return voxels;
}

}  // namespace scanmill
