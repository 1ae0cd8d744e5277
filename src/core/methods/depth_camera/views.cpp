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

// The range to a tangent plane is used if the beam hits it at less than kPlaneErrorBound times the distance of the
// pixel's point, and at more than 1 / kPlaneErrorBound times that distance. Otherwise the plane is seen edge-on, and
// the range to it is unreliable.
constexpr double kPlaneErrorBound = 2;

// Returns the nearest half-precision number, ties to even. Finite values beyond the largest one are clamped to it.
double asHalf(double value) {
  constexpr double kLargest = 65504;
  constexpr int kBits = 11;            // bits of the significand
  constexpr int kSmallestPower = -24;  // exponent of the spacing of subnormal numbers
  if (!std::isfinite(value)) return value;
  int power = 0;
  std::frexp(value, &power);
  const double step = std::ldexp(1.0, std::max(power - kBits, kSmallestPower));
  return std::clamp(std::nearbyint(value / step) * step, -kLargest, kLargest);
}

double asUnorm(double depth, int bits, double nearest, double farthest) {
  const double steps = std::ldexp(1.0, bits) - 1;
  const double clamped = std::clamp(depth, nearest, farthest);
  const double window = (1 / nearest - 1 / clamped) / (1 / nearest - 1 / farthest);
  const double stored = std::nearbyint(window * steps) / steps;
  return 1 / (1 / nearest - stored * (1 / nearest - 1 / farthest));
}

// Rounds the hit points as LiDAR-GEIL's images of coordinates do.
void roundToHalf(std::size_t begin, std::size_t end, ImageHits& found) {
  const auto rounded = [](double coordinate) {
    return double{storedDepth(static_cast<float>(coordinate), DepthFormat::Half500, 0, 0)};
  };
  for (std::size_t i = begin; i < end; ++i) {
    const double z = rounded(found.depth[i]);
    found.a[i] = rounded(found.a[i] * found.depth[i]) / z;
    found.b[i] = rounded(found.b[i] * found.depth[i]) / z;
    found.depth[i] = z;
  }
}

void findHitPoints(const CameraView& view, std::size_t begin, std::size_t end, ImageHits& found) {
  for (std::size_t i = begin; i < end; ++i) {
    const double a = found.a[i];
    const double b = found.b[i];
    const double z = found.depth[i];
    found.px[i] = (view.right.x * a + view.down.x * b + view.forward.x) * z + view.position.x;
    found.py[i] = (view.right.y * a + view.down.y * b + view.forward.y) * z + view.position.y;
    found.pz[i] = (view.right.z * a + view.down.z * b + view.forward.z) * z + view.position.z;
  }
}

void usePointRanges(std::size_t begin, std::size_t end, const BeamBlock& block, ImageHits& found) {
  for (std::size_t i = begin; i < end; ++i) {
    const double x = found.px[i] - block.ox[i];
    const double y = found.py[i] - block.oy[i];
    const double z = found.pz[i] - block.oz[i];
    found.range[i] = std::sqrt(x * x + y * y + z * z);
    found.along[i] = 0;
  }
}

void rotateNormals(const Vec3f* normal, const Mat3& rigFromWorld, std::size_t begin, std::size_t end,
                   const BeamBlock& block, ImageHits& found) {
  const Mat3& m = rigFromWorld;
  for (std::size_t i = begin; i < end; ++i) {
    const auto x = double{normal[i].x};
    const auto y = double{normal[i].y};
    const auto z = double{normal[i].z};
    found.nx[i] = m.x.x * x + m.y.x * y + m.z.x * z;
    found.ny[i] = m.x.y * x + m.y.y * y + m.z.y * z;
    found.nz[i] = m.x.z * x + m.y.z * y + m.z.z * z;
    found.along[i] = found.nx[i] * block.dx[i] + found.ny[i] * block.dy[i] + found.nz[i] * block.dz[i];
  }
}

void usePlaneRanges(std::size_t begin, std::size_t end, const BeamBlock& block, ImageHits& found) {
  for (std::size_t i = begin; i < end; ++i) {
    const double height = found.nx[i] * (found.px[i] - block.ox[i]) + found.ny[i] * (found.py[i] - block.oy[i]) +
                          found.nz[i] * (found.pz[i] - block.oz[i]);
    const double range = height / found.along[i];
    const double nearest = found.range[i];
    // Also false if the beam does not hit the plane in front of the sensor: `range` is NaN, infinite or negative.
    const bool inBound = (range <= nearest * kPlaneErrorBound) & (range * kPlaneErrorBound >= nearest);
    found.range[i] = inBound ? range : nearest;
  }
}

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

void project(std::span<const CameraView> views, const double* x, const double* y, const double* z, std::size_t count,
             ProjectedAs what, ImagePositions positions) {
  alignas(64) double u[kBlock], v[kBlock], depth[kBlock], seenBy[kBlock];
  for (std::size_t i = 0; i < count; ++i) {
    u[i] = v[i] = depth[i] = 0;
    seenBy[i] = kNoViewYet;
  }
  double number = 0;
  for (const CameraView& view : views) {
    const Vec3d from = what == ProjectedAs::Points ? view.position : Vec3d{};
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
  std::copy_n(u, count, positions.u);
  std::copy_n(v, count, positions.v);
  for (std::size_t i = 0; i < count; ++i) {
    const int view = static_cast<int>(seenBy[i]);
    positions.view[i] = static_cast<std::uint8_t>(view < int{kNoView} ? view : int{kNoView});
  }
}

float storedDepth(float depth, DepthFormat format, double nearest, double farthest) {
  constexpr double kShift = 500;  // m, added to coordinates by DepthFormat::Half500
  if (!(depth < kNoDepth)) return depth;
  switch (format) {
    case DepthFormat::Float32:
      break;
    case DepthFormat::Unorm24:
      return static_cast<float>(asUnorm(double{depth}, 24, nearest, farthest));
    case DepthFormat::Unorm16:
      return static_cast<float>(asUnorm(double{depth}, 16, nearest, farthest));
    case DepthFormat::Half500:
      return static_cast<float>(asHalf(double{depth} + kShift) - kShift);
  }
  return depth;
}

void measure(const SampleOptions& options, const CameraView& view, const Mat3& rigFromWorld, const BlockPixels& pixels,
             std::size_t begin, std::size_t end, const BeamBlock& block, ImageHits& found) {
  const double* u = pixels.u;
  const double* v = pixels.v;
  const float* depth = &pixels.planes->depth[pixels.first];
  const double perFx = 1 / view.fx;
  const double perFy = 1 / view.fy;
  for (std::size_t i = begin; i < end; ++i) {
    found.a[i] = (std::floor(u[i]) + 0.5 - view.cx) * perFx;
    found.b[i] = (std::floor(v[i]) + 0.5 - view.cy) * perFy;
    found.depth[i] = double{depth[i]};
  }
  if (options.depth == DepthFormat::Half500) roundToHalf(begin, end, found);
  findHitPoints(view, begin, end, found);
  usePointRanges(begin, end, block, found);
  if (pixels.planes->normal.empty()) return;
  rotateNormals(&pixels.planes->normal[pixels.first], rigFromWorld, begin, end, block, found);
  if (options.sampling == Sampling::Plane) usePlaneRanges(begin, end, block, found);
}

}  // namespace scanmill
