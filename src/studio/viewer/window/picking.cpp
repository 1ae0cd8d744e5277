#include "viewer/window/picking.h"

#include <algorithm>
#include <compare>
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

// Functions of a point of the item: its depth, and w times its distance (pixels) to the right of the pointer and below
// the pointer. w is the depth, or 1 for an orthographic camera.
struct ToPointer {
  PointFunction right, down, depth;
  bool orthographic;

  ToPointer(const ViewCamera& camera, const Affine& canvasFromItem, double x, double y)
      : orthographic(camera.orthographic) {
    const Mat3 itemFromCanvas = transposed(canvasFromItem.linear);  // of directions
    const Vec3d start = canvasFromItem.translation - camera.eye;
    // Returns dot(axis, point) - pixels * w.
    const auto function = [&](const Vec3d& axis, double pixels) {
      const Vec3d towards = orthographic ? axis : axis - camera.forward * pixels;
      return PointFunction{Vec3f(itemFromCanvas * towards),
                           static_cast<float>(dot(towards, start) - (orthographic ? pixels : 0))};
    };
    right = function(camera.right * camera.focal, x - camera.centerX);
    down = function(camera.down * camera.focal, y - camera.centerY);
    depth = function(camera.forward, 0);
  }
};

// A point near the pointer. The lesser one is picked: of points that cover the pointer the nearest to the eye, of those
// beside it the nearest to the pointer.
struct Candidate {
  bool beside = false;
  double nearness = 0;  // depth or, if the point is beside the pointer, distance from the pointer
  double other = 0;     // the other of depth and distance
  std::size_t cloud = 0, point = 0;
  auto operator<=>(const Candidate&) const = default;
};

}  // namespace

std::optional<PointHit> pickPoint(std::span<const PickCloud> clouds, const ViewCamera& camera, double x, double y,
                                  double size, double reach) {
  constexpr std::size_t kGrain = 1 << 16;
  constexpr std::size_t kBlock = 64;
  std::optional<Candidate> best;
  std::mutex merging;
  const auto half = static_cast<float>(size / 2 + 0.5);
  const float far = std::max(half, static_cast<float>(reach));
  const auto nearest = static_cast<float>(camera.nearest);
  for (std::size_t c = 0; c < clouds.size(); ++c) {
    const PickCloud& cloud = clouds[c];
    const ToPointer m(camera, cloud.canvasFromItem, x, y);
    const Vec3f* const points = cloud.positions.data();
    parallelFor(cloud.positions.size(), kGrain, [&](std::size_t first, std::size_t last) {
      std::optional<Candidate> own;
      for (std::size_t begin = first; begin < last; begin += kBlock) {
        const std::size_t end = std::min(begin + kBlock, last);
        // Test if any point of the block is near the pointer, without a branch, so that the compiler can use SIMD.
        int near = 0;
        for (std::size_t i = begin; i < end; ++i) {
          const float w = m.depth(points[i]);
          const float scale = far * (m.orthographic ? 1.0F : w);
          const float r = m.right(points[i]);
          const float d = m.down(points[i]);
          near |= static_cast<int>(std::fabs(r) <= scale) & static_cast<int>(std::fabs(d) <= scale) &
                  static_cast<int>(w >= nearest);
        }
        if (near == 0) continue;
        for (std::size_t i = begin; i < end; ++i) {
          if (!cloud.shown.empty() && cloud.shown[i] == 0) continue;
          const Vec3f& p = points[i];
          const float depth = m.depth(p);
          const float w = m.orthographic ? 1.0F : depth;
          const float r = std::fabs(m.right(p)) / w;
          const float d = std::fabs(m.down(p)) / w;
          if (!(depth >= nearest && r <= far && d <= far)) continue;
          const float distance = std::hypot(r, d);
          const bool covers = r <= half && d <= half;
          if (!covers && !(distance <= far)) continue;
          const Candidate candidate =
              covers ? Candidate{false, depth, distance, c, i} : Candidate{true, distance, depth, c, i};
          if (!own || candidate < *own) own = candidate;
        }
      }
      const std::lock_guard lock(merging);
      if (own && (!best || *own < *best)) best = own;
    });
  }
  if (!best) return {};
  return PointHit{best->cloud, best->point, best->beside ? best->nearness : best->other};
}

SightLine sightLine(const ViewCamera& camera, double x, double y) {
  const Vec3d offset =
      camera.right * ((x - camera.centerX) / camera.focal) + camera.down * ((y - camera.centerY) / camera.focal);
  if (camera.orthographic) return {camera.eye + offset, camera.forward};
  return {camera.eye, normalized(camera.forward + offset)};
}

}  // namespace scanmill
