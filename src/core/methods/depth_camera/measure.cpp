#include "methods/depth_camera/measure.h"

#include <algorithm>
#include <cmath>

namespace scanmill {

namespace {

// A tangent plane is trusted if the beam hits it at less than kPlaneTrust times the distance of the pixel's point, and
// at more than 1 / kPlaneTrust times that distance. Otherwise the plane is seen edge-on, and the range to it is
// unreliable.
constexpr double kPlaneTrust = 2;

// Four pixels are blended if the largest of their depths exceeds the smallest by at most this fraction. The ground 2 m
// below the sensor satisfies this at up to 120 m (2048 pixels over 120 degrees), a leaf in front of a wall does not.
constexpr double kDepthStep = 0.1;

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

// Blends the four depths around each beam if they belong to one surface. Their inverses 1 / z are interpolated, because
// 1 / z is linear across the image of a plane.
void blendCorners(const SampleOptions& options, const CameraView& view, const BlockPixels& pixels, std::size_t begin,
                  std::size_t end, Met& met) {
  const PassPlanes& planes = *pixels.corners;
  for (std::size_t i = begin; i < end; ++i) {
    const double u = pixels.u[i];
    const double v = pixels.v[i];
    const double right = u - 0.5 - firstCorner(u, view.width);
    const double down = v - 0.5 - firstCorner(v, view.height);
    const double weights[] = {(1 - right) * (1 - down), right * (1 - down), (1 - right) * down, right * down};
    double least = INFINITY;
    double most = 0;
    double inverse = 0;
    bool one = true;
    for (std::size_t k = 0; k < 4; ++k) {
      const std::size_t at = k * pixels.stride + pixels.first + i;
      float kept = planes.depth[at];
      if (options.depth == DepthFormat::Half500) {
        kept = storedDepth(kept, DepthFormat::Half500, options.nearest, options.farthest);
      }
      const auto z = double{kept};
      one = one && planes.instance[at] == planes.instance[pixels.first + i] &&
            planes.material[at] == planes.material[pixels.first + i];
      least = std::min(least, z);
      most = std::max(most, z);
      inverse += weights[k] / z;
    }
    if (!one || !(most <= least * (1 + kDepthStep)) || !(inverse > 0)) continue;
    met.a[i] = (u - view.cx) / view.fx;
    met.b[i] = (v - view.cy) / view.fy;
    met.depth[i] = 1 / inverse;
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
  if (options.sampling == Sampling::Bilinear) blendCorners(options, view, pixels, begin, end, met);
  placePoints(view, begin, end, met);
  measureNearest(begin, end, block, met);
  if (pixels.planes->normal.empty()) return;
  turnNormals(&pixels.planes->normal[pixels.first], rigFromWorld, begin, end, block, met);
  if (options.sampling == Sampling::Plane) meetPlanes(begin, end, block, met);
}

double firstCorner(double u, double size) {
  return std::clamp(std::floor(u - 0.5), 0.0, std::max(size - 2, 0.0));
}

}  // namespace scanmill
