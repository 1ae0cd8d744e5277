#include "viewer/window/picking.h"

#include <mutex>

#include "base/parallel.h"

namespace scanmill {

namespace {

// An affine function of a point.
struct PointFunction {
  Vec3f linear;
  float constant = 0;

  float operator()(const Vec3f& p) const { return dot(p, linear) + constant; }
};

// Affine functions of a point in the item's frame: `depth` is its depth (m); `right` and `down` are its distances from
// the pointer (pixels) times a weight w, which saves divisions. w is the depth, or 1 for an orthographic camera.
struct PointerFunctions {
  PointFunction right, down, depth;
  bool orthographic;

  // `x`, `y`: position of the pointer in the camera's picture (pixels).
  PointerFunctions(const ViewCamera& camera, const Affine& canvasFromItem, double x, double y)
      : orthographic(camera.orthographic) {
    // With the linear part L: dot(d, canvasFromItem * point - eye) = dot(transposed(L) * d, point) + dot(d, eyeToItem).
    const Mat3 transposedLinear = transposed(canvasFromItem.linear);
    const Vec3d eyeToItem = canvasFromItem.translation - camera.eye;  // to the item's origin, along the canvas axes
    // Returns the function dot(axis, canvasFromItem * point - eye) - pixels * w.
    const auto makeFunction = [&](const Vec3d& axis, double pixels) {
      const Vec3d direction = orthographic ? axis : axis - camera.forward * pixels;
      return PointFunction{Vec3f(transposedLinear * direction),
                           static_cast<float>(dot(direction, eyeToItem) - (orthographic ? pixels : 0))};
    };
    right = makeFunction(camera.right * camera.focal, x - camera.centerX);
    down = makeFunction(camera.down * camera.focal, y - camera.centerY);
    depth = makeFunction(camera.forward, 0);
  }
  float weight(float depthOfPoint) const { return orthographic ? 1.0F : depthOfPoint; }
};

// Limits for picking: a point within `half` pixels along both axes covers the pointer; other points are picked up to
// `far` pixels away. Points nearer than the depth `nearest` (m) are not drawn.
struct PickLimits {
  float half, far, nearest;
};

// A point near the pointer. The least candidate is picked: the point nearest to the eye among those that cover the
// pointer or, if none does, the point nearest to the pointer.
struct Candidate {
  bool beside = false;
  double first = 0;   // depth or, if the point is beside the pointer, distance from the pointer
  double second = 0;  // distance or, if the point is beside the pointer, depth
  std::size_t cloud = 0, point = 0;
  auto operator<=>(const Candidate&) const = default;
  double distance() const { return beside ? first : second; }
};

// True if one of the points may be near the pointer. The loop has no branch, so that the compiler can use SIMD.
bool isAnyNear(std::span<const Vec3f> points, const PointerFunctions& functions, const PickLimits& limits) {
  int near = 0;
  for (const Vec3f& p : points) {
    const float depth = functions.depth(p);
    const float scale = limits.far * functions.weight(depth);
    near |= static_cast<int>(std::fabs(functions.right(p)) <= scale) &
            static_cast<int>(std::fabs(functions.down(p)) <= scale) & static_cast<int>(depth >= limits.nearest);
  }
  return near != 0;
}

// Returns the point as a candidate, without its indices; nothing if it is not near the pointer.
std::optional<Candidate> candidateAt(const Vec3f& point, const PointerFunctions& functions, const PickLimits& limits) {
  const float depth = functions.depth(point);
  const float w = functions.weight(depth);
  const float right = std::fabs(functions.right(point)) / w;
  const float down = std::fabs(functions.down(point)) / w;
  if (!(depth >= limits.nearest && right <= limits.far && down <= limits.far)) return {};
  const float distance = std::hypot(right, down);
  if (right <= limits.half && down <= limits.half) return Candidate{false, depth, distance};
  if (!(distance <= limits.far)) return {};
  return Candidate{true, distance, depth};
}

}  // namespace

std::optional<PointHit> pickPoint(std::span<const PickCloud> clouds, const ViewCamera& camera, double x, double y,
                                  double size, double reach) {
  constexpr std::size_t kGrain = 1 << 16;  // points that a thread handles at a time
  constexpr std::size_t kBlock = 64;       // points that isAnyNear() tests together
  std::optional<Candidate> best;
  std::mutex merging;  // guards `best`
  const auto half = static_cast<float>(size / 2 + 0.5);
  const PickLimits limits{
      .half = half, .far = std::max(half, static_cast<float>(reach)), .nearest = static_cast<float>(camera.nearest)};
  for (std::size_t c = 0; c < clouds.size(); ++c) {
    const PickCloud& cloud = clouds[c];
    const PointerFunctions functions(camera, cloud.canvasFromItem, x, y);
    parallelFor(cloud.positions.size(), kGrain, [&](std::size_t first, std::size_t last) {
      std::optional<Candidate> bestInRange;
      for (std::size_t begin = first; begin < last; begin += kBlock) {
        const std::size_t end = std::min(begin + kBlock, last);
        if (!isAnyNear(cloud.positions.subspan(begin, end - begin), functions, limits)) continue;
        for (std::size_t i = begin; i < end; ++i) {
          if (!cloud.shown.empty() && cloud.shown[i] == 0) continue;
          std::optional<Candidate> candidate = candidateAt(cloud.positions[i], functions, limits);
          if (!candidate) continue;
          candidate->cloud = c;
          candidate->point = i;
          if (!bestInRange || *candidate < *bestInRange) bestInRange = candidate;
        }
      }
      const std::lock_guard lock(merging);
      if (bestInRange && (!best || *bestInRange < *best)) best = bestInRange;
    });
  }
  if (!best) return {};
  return PointHit{.cloud = best->cloud, .point = best->point, .distance = best->distance()};
}

SightLine sightLine(const ViewCamera& camera, double x, double y) {
  const Vec3d offset =
      camera.right * ((x - camera.centerX) / camera.focal) + camera.down * ((y - camera.centerY) / camera.focal);
  if (camera.orthographic) return {camera.eye + offset, camera.forward};
  return {camera.eye, normalized(camera.forward + offset)};
}

}  // namespace scanmill
