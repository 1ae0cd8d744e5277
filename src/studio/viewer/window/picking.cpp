#include "viewer/window/picking.h"

#include <algorithm>
#include <mutex>
#include <tuple>

#include "base/parallel.h"

namespace scanmill {

namespace {

// A linear map from a point of the item to three values: its depth, and w times its distance (pixels) to the right of
// the pointer and below the pointer. w is the depth, or 1 for an orthographic camera.
struct ToPointer {
  Vec3f right, down, depth;
  float rightAt, downAt, depthAt;
  bool orthographic;

  ToPointer(const ViewCamera& camera, const Affine& canvasFromItem, double x, double y)
      : orthographic(camera.orthographic) {
    const Affine& a = canvasFromItem;
    const Vec3d start = a.translation - camera.eye;
    const auto row = [&](const Vec3d& axis, Vec3d& linear, double& constant) {
      linear = {dot(axis, a.linear.x), dot(axis, a.linear.y), dot(axis, a.linear.z)};
      constant = dot(axis, start);
    };
    Vec3d r, d, f;
    double rc = 0, dc = 0, fc = 0;
    row(camera.right * camera.focal, r, rc);
    row(camera.down * camera.focal, d, dc);
    row(camera.forward, f, fc);
    const double px = x - camera.centerX;
    const double py = y - camera.centerY;
    depth = Vec3f(f);
    depthAt = static_cast<float>(fc);
    if (orthographic) {
      right = Vec3f(r);
      down = Vec3f(d);
      rightAt = static_cast<float>(rc - px);
      downAt = static_cast<float>(dc - py);
    } else {
      right = Vec3f(r - f * px);
      down = Vec3f(d - f * py);
      rightAt = static_cast<float>(rc - fc * px);
      downAt = static_cast<float>(dc - fc * py);
    }
  }
};

struct Best {
  bool covers = false;
  PointHit hit;
  bool any = false;

  void take(bool nowCovers, const PointHit& found) {
    if (any && !better(nowCovers, found)) return;
    covers = nowCovers;
    hit = found;
    any = true;
  }
  bool better(bool nowCovers, const PointHit& found) const {
    if (nowCovers != covers) return nowCovers;
    const auto key = [&](const PointHit& h) {
      return covers ? std::tuple(h.depth, h.distance, h.cloud, h.point)
                    : std::tuple(h.distance, h.depth, h.cloud, h.point);
    };
    return key(found) < key(hit);
  }
};

}  // namespace

std::optional<PointHit> pickPoint(std::span<const PickCloud> clouds, const ViewCamera& camera, double x, double y,
                                  double size, double reach) {
  constexpr std::size_t kGrain = 1 << 16;
  constexpr std::size_t kBlock = 64;
  Best best;
  std::mutex merging;
  const auto half = static_cast<float>(size / 2 + 0.5);
  const float far = std::max(half, static_cast<float>(reach));
  const auto nearest = static_cast<float>(camera.nearest);
  for (std::size_t c = 0; c < clouds.size(); ++c) {
    const PickCloud& cloud = clouds[c];
    const ToPointer m(camera, cloud.canvasFromItem, x, y);
    const Vec3f* const points = cloud.positions.data();
    parallelFor(cloud.positions.size(), kGrain, [&](std::size_t first, std::size_t last) {
      Best own;
      for (std::size_t begin = first; begin < last; begin += kBlock) {
        const std::size_t end = std::min(begin + kBlock, last);
        // Test if any point of the block is near the pointer, without a branch, so that the compiler can use SIMD.
        int near = 0;
        for (std::size_t i = begin; i < end; ++i) {
          const float w = points[i].x * m.depth.x + points[i].y * m.depth.y + points[i].z * m.depth.z + m.depthAt;
          const float scale = far * (m.orthographic ? 1.0F : w);
          const float r = points[i].x * m.right.x + points[i].y * m.right.y + points[i].z * m.right.z + m.rightAt;
          const float d = points[i].x * m.down.x + points[i].y * m.down.y + points[i].z * m.down.z + m.downAt;
          near |= static_cast<int>(std::fabs(r) <= scale) & static_cast<int>(std::fabs(d) <= scale) &
                  static_cast<int>(w >= nearest);
        }
        if (near == 0) continue;
        for (std::size_t i = begin; i < end; ++i) {
          if (!cloud.shown.empty() && cloud.shown[i] == 0) continue;
          const Vec3f& p = points[i];
          const float depth = dot(p, m.depth) + m.depthAt;
          const float w = m.orthographic ? 1.0F : depth;
          const float r = std::fabs(dot(p, m.right) + m.rightAt) / w;
          const float d = std::fabs(dot(p, m.down) + m.downAt) / w;
          if (!(depth >= nearest && r <= far && d <= far)) continue;
          const float distance = std::hypot(r, d);
          const bool covers = r <= half && d <= half;
          if (!covers && !(distance <= far)) continue;
          own.take(covers, {c, i, depth, distance});
        }
      }
      if (!own.any) return;
      const std::lock_guard lock(merging);
      best.take(own.covers, own.hit);
    });
  }
  if (!best.any) return {};
  return best.hit;
}

SightLine sightLine(const ViewCamera& camera, double x, double y) {
  const Vec3d offset =
      camera.right * ((x - camera.centerX) / camera.focal) + camera.down * ((y - camera.centerY) / camera.focal);
  if (camera.orthographic) return {camera.eye + offset, camera.forward};
  return {camera.eye, normalized(camera.forward + offset)};
}

}  // namespace scanmill
