#include "methods/depth_camera/views.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "base/error.h"

namespace scanmill {

namespace {

constexpr double kEdge = 1e-6;       // px; margin, so that a beam along the border of two images is in at least one
constexpr double kInFront = 1e-9;    // smallest depth in front of a camera: m for points, without unit for directions
constexpr double kNoViewYet = 1000;  // stands for kNoView while views' indices are doubles, so that g++ can vectorise

}  // namespace

std::vector<CameraView> viewsOf(const std::vector<Camera>& cameras, const Pose& worldFromRig) {
  std::vector<CameraView> views;
  const Mat3 rigFromWorld = transposed(toMatrix(worldFromRig.rotation));
  PixelAddress first = 0;
  for (const Camera& camera : cameras) {
    const Mat3 axes = rigFromWorld * toMatrix(camera.worldFromCamera.rotation);
    CameraView view;
    view.right = axes.x;
    view.down = axes.y;
    view.forward = axes.z;
    // Subtract before rotating: far from the world's origin this keeps a precision of micrometres.
    view.position = rigFromWorld * (camera.worldFromCamera.translation - worldFromRig.translation);
    view.fx = camera.fx;
    view.fy = camera.fy;
    view.cx = camera.cx;
    view.cy = camera.cy;
    view.width = camera.width;
    view.height = camera.height;
    view.lastU = std::nextafter(view.width, 0.0);
    view.lastV = std::nextafter(view.height, 0.0);
    view.rowLength = camera.width;
    view.first = first;
    views.push_back(view);
    first += static_cast<PixelAddress>(camera.pixels());
  }
  if (views.size() >= kNoView) throw InputError(fmt::format("a shot has {} images, which are too many", views.size()));
  return views;
}

void place(std::span<const CameraView> views, const double* x, const double* y, const double* z, std::size_t count,
           bool points, ImagePositions places) {
  alignas(64) double u[kBlock], v[kBlock], depth[kBlock], seenBy[kBlock];
  for (std::size_t i = 0; i < count; ++i) {
    u[i] = v[i] = depth[i] = 0;
    seenBy[i] = kNoViewYet;
  }
  double number = 0;
  for (const CameraView& view : views) {
    const Vec3d from = points ? view.position : Vec3d{};
    const Vec3d right = view.right * view.fx;
    const Vec3d down = view.down * view.fy;
    const Vec3d forward = view.forward;
    const double cx = view.cx;
    const double cy = view.cy;
    const double width = view.width + kEdge;
    const double height = view.height + kEdge;
    const double lastU = view.lastU;
    const double lastV = view.lastV;
    for (std::size_t i = 0; i < count; ++i) {
      const double px = x[i] - from.x;
      const double py = y[i] - from.y;
      const double pz = z[i] - from.z;
      const double ahead = forward.x * px + forward.y * py + forward.z * pz;
      const double scale = 1 / ahead;
      double a = (right.x * px + right.y * py + right.z * pz) * scale + cx;
      double b = (down.x * px + down.y * py + down.z * pz) * scale + cy;
      const bool better =
          (ahead > kInFront) & (ahead > depth[i]) & (a >= -kEdge) & (a <= width) & (b >= -kEdge) & (b <= height);
      a = a > 0 ? a : 0;
      a = a < lastU ? a : lastU;
      b = b > 0 ? b : 0;
      b = b < lastV ? b : lastV;
      u[i] = better ? a : u[i];
      v[i] = better ? b : v[i];
      depth[i] = better ? ahead : depth[i];
      seenBy[i] = better ? number : seenBy[i];
    }
    number += 1;
  }
  std::copy_n(u, count, places.u);
  std::copy_n(v, count, places.v);
  for (std::size_t i = 0; i < count; ++i) {
    const int view = static_cast<int>(seenBy[i]);
    places.view[i] = static_cast<std::uint8_t>(view < int{kNoView} ? view : int{kNoView});
  }
}

}  // namespace scanmill
