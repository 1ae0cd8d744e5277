#pragma once

// Turns the triangles that beams hit into hits: ranges, normals, labels. Computes in double, 16 beams at a time.

#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "base/vec.h"
#include "methods/world/world.h"
#include "scan/hits.h"
#include "scene/reflectance.h"
#include "sensors/shot.h"

namespace scanmill {

constexpr int kPacket = 16;

// A shot's poses, relative to the world's origin, and the steps and times of its columns.
struct ShotFrame {
  std::vector<Mat3> rotation;  // one rotation per step of the revolution
  std::vector<Vec3d> position;
  std::vector<std::uint32_t> step;  // by column: the step of the revolution, Shot::stepOf()
  // Time at which each column fires, as a fraction (0 to 1) of the revolution. Empty if nothing moves, or if the table
  // gives each ray a time of its own.
  std::vector<float> columnFraction;
};

// Returns a shot's frame in a world with this origin (m). `duration`: seconds of the revolution, 0 if nothing moves.
ShotFrame frameOf(const Shot& shot, const Vec3d& origin, double duration = 0);

// A rectangle of at most 16 beams: rings [ring, ring + rows) x columns [column, column + width).
struct Tile {
  std::uint32_t ring, column, rows, width;
};

using Lane = double[kPacket];

// Origins (m, relative to the world's origin) and unit directions of a tile's beams; surplus lanes repeat beam 0.
struct Rays {
  int count = 0;
  alignas(64) Lane ox, oy, oz, dx, dy, dz;

  Vec3d origin(int lane) const { return {ox[lane], oy[lane], oz[lane]}; }
  Vec3d direction(int lane) const { return {dx[lane], dy[lane], dz[lane]}; }
};

// The triangle that a ray hits.
struct HitTriangle {
  const TriangleBlock* block = nullptr;  // null: the ray hits nothing
  const PlacedBlock* placed = nullptr;   // null: the triangle is baked
  std::uint32_t index = 0;               // index into TriangleBlock::triangles
  float firedAt = 0;  // time at which the ray fires, as a fraction of the revolution (0 to 1), which determines the
                      // pose of a moving mesh

  // Returns true if both rays hit the same triangle of the same object.
  bool sameTriangle(const HitTriangle& other) const {
    return index == other.index && placed == other.placed && block == other.block;
  }
};

// The planes of the hit triangles, relative to the world's origin, and the ranges and cosines that follow from them.
struct HitPlanes {
  alignas(64) Lane nx, ny, nz;  // unit normals
  alignas(64) Lane offset;      // m, normal . p for points p of the plane
  alignas(64) Lane traced;      // m, the range that Embree or the particle found; infinite for a miss
  alignas(64) Lane range;       // m, the range that follows from the plane; infinite for a miss
  alignas(64) Lane cosine;      // dot product of normal and beam direction
};

// Returns the time at which a ray of the table fires, as a fraction (0 to 1) of a revolution of `duration` seconds; 0
// if `duration` is 0, which means that nothing in the scene moves.
float firingFraction(const BeamTable& beams, std::size_t ray, double duration);

// Sets `rays` to the rays of a tile. `frame`: the shot's frame.
void setUpRays(const Shot& shot, const ShotFrame& frame, const Tile& tile, Rays& rays);

// Sets `fractions`, by lane, to the values of firingFraction() for a tile's rays; 0 in lanes without a ray.
void fillFiringFractions(const Shot& shot, const ShotFrame& frame, const Tile& tile, double duration, float* fractions);

// Sets the lane's plane to the plane of the triangle that the lane's ray hits, and its traced range to `traced` (m).
inline void loadPlane(const HitTriangle& hit, float traced, HitPlanes& planes, int lane) {
  const BlockTriangle& triangle = hit.block->triangles[hit.index];
  Vec3d normal = triangle.normal;
  double offset = triangle.offset;
  if (hit.placed != nullptr) {
    const bool moves = hit.placed->moves;
    const Affine originFromMesh = moves ? hit.placed->at(double{hit.firedAt}) : hit.placed->originFromMesh;
    normal = (moves ? transposed(inverse(originFromMesh.linear)) : hit.placed->normalFromMesh) * normal;
    const double scale = 1 / length(normal);
    normal = normal * scale;
    offset = offset * scale + dot(normal, originFromMesh.translation);
  }
  planes.nx[lane] = normal.x;
  planes.ny[lane] = normal.y;
  planes.nz[lane] = normal.z;
  planes.offset[lane] = offset;
  planes.traced[lane] = double{traced};
}

// Like loadPlane() for a ray that hits the same triangle as the ray of the lane before: copies that lane's plane.
inline void loadSamePlane(float traced, HitPlanes& planes, int lane) {
  planes.nx[lane] = planes.nx[lane - 1];
  planes.ny[lane] = planes.ny[lane - 1];
  planes.nz[lane] = planes.nz[lane - 1];
  planes.offset[lane] = planes.offset[lane - 1];
  planes.traced[lane] = double{traced};
}

inline void loadMiss(HitPlanes& planes, int lane) {
  planes.nx[lane] = planes.ny[lane] = planes.nz[lane] = planes.offset[lane] = 0;
  planes.traced[lane] = std::numeric_limits<double>::infinity();
}

// The nearest and the farthest range that a sensor reports (m).
struct RangeLimits {
  double nearest, farthest;  // m
};

RangeLimits limitsOf(const BeamTable& beams);
// Returns the length of the paths of rays and particles (m): slightly more than the maximum range, so that float32
// rounding does not decide about hits at exactly the maximum.
inline double searchDistance(const BeamTable& beams) {
  return beams.maxRange * (1 + 1e-4) + 1e-3;
}

// Largest difference between the range to a triangle's plane and the traced range: kRangeErrorBound times the traced
// range, plus kRangeErrorBound metres. The plane of a triangle that is seen edge-on gives an unreliable range.
constexpr double kRangeErrorBound = 1e-2;  // both a fraction and a length (m)

// Sets each range to the distance along the ray to its triangle's plane, clamped to differ from the traced range by no
// more than kRangeErrorBound allows. A hit outside of the sensor's range limits becomes a miss.
void usePlaneRanges(const Rays& rays, const BeamTable& beams, HitPlanes& planes);
// Sets each range to the traced range. A hit outside of the sensor's range limits becomes a miss.
void useTracedRanges(const Rays& rays, const BeamTable& beams, HitPlanes& planes);

// Writes a tile's hits to the channels that `hits` has. `materials`: the scene's materials; `triangles`: one per lane.
void store(const std::vector<CompactMaterial>& materials, const Tile& tile, const Rays& rays, const HitPlanes& planes,
           const HitTriangle* triangles, Hits& hits);

// Prefetches the memory that store() will write.
void prefetchStore(const Tile& tile, Hits& hits);

// Returns the barycentric coordinates (scene/reflectance.h) of a point (m, from the world's origin) in a triangle.
Vec2d barycentric(const HitTriangle& hit, const Vec3d& point);

inline void prefetch(const BlockTriangle& triangle) {
  const auto* bytes = reinterpret_cast<const char*>(&triangle);
  __builtin_prefetch(bytes);
  __builtin_prefetch(bytes + sizeof triangle - 1);  // a record may extend over two cache lines
}

}  // namespace scanmill
