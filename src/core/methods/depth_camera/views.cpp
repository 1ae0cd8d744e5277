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

// A tangent plane is trusted if the beam hits it at less than kPlaneTrust times the distance of the pixel's point, and
// at more than 1 / kPlaneTrust times that distance. Otherwise the plane is seen edge-on, and the range to it is
// unreliable.
constexpr double kPlaneTrust = 2;

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
void keepHalves(std::size_t begin, std::size_t end, Met& met) {
  const auto kept = [](double coordinate) {
    return double{storedDepth(static_cast<float>(coordinate), DepthFormat::Half500, 0, 0)};
  };
  for (std::size_t i = begin; i < end; ++i) {
    const double z = kept(met.depth[i]);
    met.a[i] = kept(met.a[i] * met.depth[i]) / z;
    met.b[i] = kept(met.b[i] * met.depth[i]) / z;
    met.depth[i] = z;
  }
}

void placePoints(const CameraView& view, std::size_t begin, std::size_t end, Met& met) {
  for (std::size_t i = begin; i < end; ++i) {
    const double a = met.a[i];
    const double b = met.b[i];
    const double z = met.depth[i];
    met.px[i] = (view.right.x * a + view.down.x * b + view.forward.x) * z + view.position.x;
    met.py[i] = (view.right.y * a + view.down.y * b + view.forward.y) * z + view.position.y;
    met.pz[i] = (view.right.z * a + view.down.z * b + view.forward.z) * z + view.position.z;
  }
}

void measureNearest(std::size_t begin, std::size_t end, const BeamBlock& block, Met& met) {
  for (std::size_t i = begin; i < end; ++i) {
    const double x = met.px[i] - block.ox[i];
    const double y = met.py[i] - block.oy[i];
    const double z = met.pz[i] - block.oz[i];
    met.range[i] = std::sqrt(x * x + y * y + z * z);
    met.along[i] = 0;
  }
}

void turnNormals(const Vec3f* normal, const Mat3& rigFromWorld, std::size_t begin, std::size_t end,
                 const BeamBlock& block, Met& met) {
  const Mat3& m = rigFromWorld;
  for (std::size_t i = begin; i < end; ++i) {
    const auto x = double{normal[i].x};
    const auto y = double{normal[i].y};
    const auto z = double{normal[i].z};
    met.nx[i] = m.x.x * x + m.y.x * y + m.z.x * z;
    met.ny[i] = m.x.y * x + m.y.y * y + m.z.y * z;
    met.nz[i] = m.x.z * x + m.y.z * y + m.z.z * z;
    met.along[i] = met.nx[i] * block.dx[i] + met.ny[i] * block.dy[i] + met.nz[i] * block.dz[i];
  }
}

void meetPlanes(std::size_t begin, std::size_t end, const BeamBlock& block, Met& met) {
  for (std::size_t i = begin; i < end; ++i) {
    const double height = met.nx[i] * (met.px[i] - block.ox[i]) + met.ny[i] * (met.py[i] - block.oy[i]) +
                          met.nz[i] * (met.pz[i] - block.oz[i]);
    const double range = height / met.along[i];
    const double nearest = met.range[i];
    // Also false if the beam does not hit the plane in front of the sensor: `range` is NaN, infinite or negative.
    const bool trusted = (range <= nearest * kPlaneTrust) & (range * kPlaneTrust >= nearest);
    met.range[i] = trusted ? range : nearest;
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
             std::size_t begin, std::size_t end, const BeamBlock& block, Met& met) {
  const double* u = pixels.u;
  const double* v = pixels.v;
  const float* depth = &pixels.planes->depth[pixels.first];
  const double perFx = 1 / view.fx;
  const double perFy = 1 / view.fy;
  for (std::size_t i = begin; i < end; ++i) {
    met.a[i] = (std::floor(u[i]) + 0.5 - view.cx) * perFx;
    met.b[i] = (std::floor(v[i]) + 0.5 - view.cy) * perFy;
    met.depth[i] = double{depth[i]};
  }
  if (options.depth == DepthFormat::Half500) keepHalves(begin, end, met);
  placePoints(view, begin, end, met);
  measureNearest(begin, end, block, met);
  if (pixels.planes->normal.empty()) return;
  turnNormals(&pixels.planes->normal[pixels.first], rigFromWorld, begin, end, block, met);
  if (options.sampling == Sampling::Plane) meetPlanes(begin, end, block, met);
}

}  // namespace scanmill
