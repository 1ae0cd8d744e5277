#include "methods/depth_camera/views.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "base/error.h"

namespace scanmill {
namespace {

constexpr double kEdge = 1e-6;       // px; margin, so that a beam along the border of two images is in one of them
constexpr double kInFront = 1e-9;    // smallest depth in front of a camera: m for points, without unit for directions
constexpr double kNoViewYet = 1000;  // stands for kNoView while views' indices are doubles, so that g++ can vectorise

// The range to a tangent plane is used if it is from 1 / kPlaneErrorBound to kPlaneErrorBound times the distance of the
// pixel's point. Otherwise the plane is seen edge-on, and the range is unreliable.
constexpr double kPlaneErrorBound = 2;

// Rounds the points that the pixels show (camera axes) to DepthFormat::Half500.
void roundToHalf(std::size_t begin, std::size_t end, ImageHits& hits) {
  const auto rounded = [](double coordinate) {
    return double{storedDepth(static_cast<float>(coordinate), DepthFormat::Half500, 0, 0)};
  };
  for (std::size_t i = begin; i < end; ++i) {
    const double z = rounded(hits.depth[i]);
    hits.a[i] = rounded(hits.a[i] * hits.depth[i]) / z;
    hits.b[i] = rounded(hits.b[i] * hits.depth[i]) / z;
    hits.depth[i] = z;
  }
}

// Computes the points that the pixels show, in rig axes.
void findHitPoints(const CameraView& view, std::size_t begin, std::size_t end, ImageHits& hits) {
  for (std::size_t i = begin; i < end; ++i) {
    const double a = hits.a[i];
    const double b = hits.b[i];
    const double z = hits.depth[i];
    hits.px[i] = (view.right.x * a + view.down.x * b + view.forward.x) * z + view.position.x;
    hits.py[i] = (view.right.y * a + view.down.y * b + view.forward.y) * z + view.position.y;
    hits.pz[i] = (view.right.z * a + view.down.z * b + view.forward.z) * z + view.position.z;
  }
}

// Sets each range to the distance from the beam's origin to the point that the pixel shows.
void usePointRanges(std::size_t begin, std::size_t end, const BeamBlock& block, ImageHits& hits) {
  for (std::size_t i = begin; i < end; ++i) {
    const double x = hits.px[i] - block.ox[i];
    const double y = hits.py[i] - block.oy[i];
    const double z = hits.pz[i] - block.oz[i];
    hits.range[i] = std::sqrt(x * x + y * y + z * z);
    hits.cosine[i] = 0;
  }
}

// Rotates the pixels' normals (world axes) into rig axes.
void rotateNormals(const Vec3f* normal, const Mat3& rigFromWorld, std::size_t begin, std::size_t end,
                   const BeamBlock& block, ImageHits& hits) {
  const Mat3& m = rigFromWorld;
  for (std::size_t i = begin; i < end; ++i) {
    const auto x = double{normal[i].x};
    const auto y = double{normal[i].y};
    const auto z = double{normal[i].z};
    hits.nx[i] = m.x.x * x + m.y.x * y + m.z.x * z;
    hits.ny[i] = m.x.y * x + m.y.y * y + m.z.y * z;
    hits.nz[i] = m.x.z * x + m.y.z * y + m.z.z * z;
    hits.cosine[i] = hits.nx[i] * block.dx[i] + hits.ny[i] * block.dy[i] + hits.nz[i] * block.dz[i];
  }
}

// Replaces each range by the range to the tangent plane at the pixel's point if kPlaneErrorBound allows that range.
void usePlaneRanges(std::size_t begin, std::size_t end, const BeamBlock& block, ImageHits& hits) {
  for (std::size_t i = begin; i < end; ++i) {
    const double height = hits.nx[i] * (hits.px[i] - block.ox[i]) + hits.ny[i] * (hits.py[i] - block.oy[i]) +
                          hits.nz[i] * (hits.pz[i] - block.oz[i]);
    const double range = height / hits.cosine[i];
    const double pointRange = hits.range[i];
    // Also false if the beam does not hit the plane in front of the sensor: `range` is then NaN, infinite or negative.
    const bool isReliable = (range <= pointRange * kPlaneErrorBound) & (range * kPlaneErrorBound >= pointRange);
    hits.range[i] = isReliable ? range : pointRange;
  }
}

}  // namespace

std::vector<CameraView> viewsOf(const std::vector<Camera>& cameras, const Pose& worldFromRig) {
  std::vector<CameraView> views;
  const Mat3 rigFromWorld = transposed(toMatrix(worldFromRig.rotation));
  PixelAddress firstPixel = 0;
  for (const Camera& camera : cameras) {
    const Mat3 axes = rigFromWorld * toMatrix(camera.worldFromCamera.rotation);
    // Subtract before rotating: far from the world's origin this keeps a precision of micrometres.
    const Vec3d position = rigFromWorld * (camera.worldFromCamera.translation - worldFromRig.translation);
    views.push_back({.right = axes.x,
                     .down = axes.y,
                     .forward = axes.z,
                     .position = position,
                     .fx = camera.fx,
                     .fy = camera.fy,
                     .cx = camera.cx,
                     .cy = camera.cy,
                     .width = static_cast<double>(camera.width),
                     .height = static_cast<double>(camera.height),
                     .lastU = std::nextafter(static_cast<double>(camera.width), 0.0),
                     .lastV = std::nextafter(static_cast<double>(camera.height), 0.0),
                     .rowLength = camera.width,
                     .firstPixel = firstPixel});
    firstPixel += static_cast<PixelAddress>(camera.pixels());
  }
  if (views.size() >= kNoView)
    throw InputError("a shot has " + std::to_string(views.size()) + " images, which are too many");
  return views;
}

void project(std::span<const CameraView> views, const double* x, const double* y, const double* z, std::size_t count,
             ProjectedAs kind, ImagePositions positions) {
  // The position (px) and the depth (m) of each point in the best image so far, and the image's index, as a double.
  alignas(64) double bestU[kBlock], bestV[kBlock], bestDepth[kBlock], bestView[kBlock];
  for (std::size_t i = 0; i < count; ++i) {
    bestU[i] = bestV[i] = bestDepth[i] = 0;
    bestView[i] = kNoViewYet;
  }
  for (std::size_t k = 0; k < views.size(); ++k) {
    // Local copies, because g++ does not vectorise the loop over points with references.
    const CameraView view = views[k];
    const auto index = static_cast<double>(k);
    const Vec3d origin = kind == ProjectedAs::Points ? view.position : Vec3d{};
    const Vec3d right = view.right * view.fx;
    const Vec3d down = view.down * view.fy;
    const Vec3d forward = view.forward;
    const double widest = view.width + kEdge;
    const double highest = view.height + kEdge;
    for (std::size_t i = 0; i < count; ++i) {
      const double px = x[i] - origin.x;
      const double py = y[i] - origin.y;
      const double pz = z[i] - origin.z;
      const double depth = forward.x * px + forward.y * py + forward.z * pz;
      const double scale = 1 / depth;
      double u = (right.x * px + right.y * py + right.z * pz) * scale + view.cx;
      double v = (down.x * px + down.y * py + down.z * pz) * scale + view.cy;
      const bool isBetter =
          (depth > kInFront) & (depth > bestDepth[i]) & (u >= -kEdge) & (u <= widest) & (v >= -kEdge) & (v <= highest);
      u = u > 0 ? u : 0;
      u = u < view.lastU ? u : view.lastU;
      v = v > 0 ? v : 0;
      v = v < view.lastV ? v : view.lastV;
      bestU[i] = isBetter ? u : bestU[i];
      bestV[i] = isBetter ? v : bestV[i];
      bestDepth[i] = isBetter ? depth : bestDepth[i];
      bestView[i] = isBetter ? index : bestView[i];
    }
  }
  std::copy_n(bestU, count, positions.u);
  std::copy_n(bestV, count, positions.v);
  for (std::size_t i = 0; i < count; ++i) {
    const int view = static_cast<int>(bestView[i]);
    positions.view[i] = static_cast<std::uint8_t>(view < int{kNoView} ? view : int{kNoView});
  }
}

void measure(const SampleOptions& options, const CameraView& view, const Mat3& rigFromWorld, const BlockPixels& pixels,
             std::size_t begin, std::size_t end, const BeamBlock& block, ImageHits& hits) {
  const double* u = pixels.u;
  const double* v = pixels.v;
  const float* depth = &pixels.planes->depth[pixels.first];
  const double perFx = 1 / view.fx;
  const double perFy = 1 / view.fy;
  for (std::size_t i = begin; i < end; ++i) {
    hits.a[i] = (std::floor(u[i]) + 0.5 - view.cx) * perFx;
    hits.b[i] = (std::floor(v[i]) + 0.5 - view.cy) * perFy;
    hits.depth[i] = double{depth[i]};
  }
  if (options.depth == DepthFormat::Half500) roundToHalf(begin, end, hits);
  findHitPoints(view, begin, end, hits);
  usePointRanges(begin, end, block, hits);
  if (pixels.planes->normal.empty()) return;
  rotateNormals(&pixels.planes->normal[pixels.first], rigFromWorld, begin, end, block, hits);
  if (options.sampling == Sampling::Plane) usePlaneRanges(begin, end, block, hits);
}

}  // namespace scanmill
