#include "viewer/splats.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "base/parallel.h"
#include "viewer/color_map.h"

namespace scanmill {

namespace {

// The picture is drawn this many times larger and averaged down: smooth edges.
constexpr int kOversampling = 2;
constexpr float kNothing = std::numeric_limits<float>::infinity();

// In the oversampled picture.
struct Canvas {
  int width = 0;
  int height = 0;
  std::vector<float> depth;
  std::vector<Rgb> color;
};

// A splat covers a disc of constant size in the world, which grows with the distance from the sensor as the gap between
// neighbouring beams does, so it shrinks on the picture with the distance from the camera. `unit` is a pixel of a
// picture 850 pixels high.
double splatRadius(double range, double scale, double size, double unit) {
  constexpr double kWorldRadius = 0.03;       // m
  constexpr double kRadiusPerMetre = 0.0018;  // rad; beams 0.2 degrees apart touch
  constexpr double kLeast = 0.65;             // units
  constexpr double kMost = 8;                 // units
  return size * std::clamp((kWorldRadius + kRadiusPerMetre * range) * scale, kLeast * unit, kMost * unit);
}

void drawDisc(Canvas& canvas, double x, double y, double radius, float depth, const Rgb& color) {
  const double squared = radius * radius;
  const int top = std::max(static_cast<int>(std::ceil(y - radius - 0.5)), 0);
  const int bottom = std::min(static_cast<int>(std::floor(y + radius - 0.5)), canvas.height - 1);
  for (int row = top; row <= bottom; ++row) {
    const double dy = row + 0.5 - y;
    const double half = std::sqrt(std::max(squared - dy * dy, 0.0));
    const int left = std::max(static_cast<int>(std::ceil(x - half - 0.5)), 0);
    const int right = std::min(static_cast<int>(std::floor(x + half - 0.5)), canvas.width - 1);
    for (int column = left; column <= right; ++column) {
      const std::size_t pixel = std::size_t(row) * std::size_t(canvas.width) + std::size_t(column);
      if (depth < canvas.depth[pixel]) {
        canvas.depth[pixel] = depth;
        canvas.color[pixel] = color;
      }
    }
  }
}

// Eye-dome lighting (C. Boucheny and A. Ribes, "Eye-dome lighting: a non-photorealistic shading technique", Kitware
// Source 17, 2011): a pixel is darker the more its neighbours stand in front of it. Empty neighbours do not count, or a
// sparse scan would be dark all over. `unit` is the depth difference (m) that means the same at any distance; with
// perspective it is the depth itself.
double depthShade(const Canvas& canvas, int x, int y, double unit) {
  constexpr double kStrength = 14;
  constexpr double kUnnoticed = 0.003;  // steps of a surface seen at a grazing angle
  constexpr double kLargest = 0.12;
  constexpr int kReach = 3;
  constexpr std::array<std::array<int, 2>, 8> kNeighbours{
      {{3, 0}, {2, 2}, {0, 3}, {-2, 2}, {-3, 0}, {-2, -2}, {0, -3}, {2, -2}}};
  if (x < kReach || y < kReach || x >= canvas.width - kReach || y >= canvas.height - kReach) return 1;
  const std::size_t pixel = std::size_t(y) * std::size_t(canvas.width) + std::size_t(x);
  const double own = canvas.depth[pixel];
  double sum = 0;
  for (const auto& [dx, dy] : kNeighbours) {
    const double other = canvas.depth[std::size_t(y + dy) * std::size_t(canvas.width) + std::size_t(x + dx)];
    sum += std::clamp((own - other) / unit - kUnnoticed, 0.0, kLargest);
  }
  return std::exp(-kStrength * sum / 2);
}

Image averagedDown(const Canvas& canvas, const ViewCamera& camera, int width, int height, bool depthEdges) {
  constexpr double kOrthographicUnit = 25;  // m
  constexpr double kDarkest = 0.3;
  Image image(width, height, kBackground);
  const auto rows = [&](std::size_t first, std::size_t last) {
    for (int y = static_cast<int>(first); y < static_cast<int>(last); ++y) {
      for (int x = 0; x < width; ++x) {
        std::array<double, 3> sum{};
        for (int s = 0; s < kOversampling * kOversampling; ++s) {
          const int cx = x * kOversampling + s % kOversampling;
          const int cy = y * kOversampling + s / kOversampling;
          const std::size_t pixel = std::size_t(cy) * std::size_t(canvas.width) + std::size_t(cx);
          const float depth = canvas.depth[pixel];
          double shade = 1;
          if (depthEdges && depth < kNothing) {
            shade = std::max(depthShade(canvas, cx, cy, camera.orthographic ? kOrthographicUnit : depth), kDarkest);
          }
          for (std::size_t c = 0; c < 3; ++c) sum[c] += shade * canvas.color[pixel][c];
        }
        for (std::size_t c = 0; c < 3; ++c) {
          image.at(x, y)[c] = static_cast<std::uint8_t>(std::lround(sum[c] / (kOversampling * kOversampling)));
        }
      }
    }
  };
  parallelFor(static_cast<std::size_t>(height), 32, rows);
  return image;
}

}  // namespace

Image drawSplats(std::span<const Vec3f> points, std::span<const Rgb> colors, const ViewCamera& camera, int width,
                 int height, const SplatStyle& style) {
  Canvas canvas;
  canvas.width = width * kOversampling;
  canvas.height = height * kOversampling;
  canvas.depth.assign(std::size_t(canvas.width) * std::size_t(canvas.height), kNothing);
  canvas.color.assign(canvas.depth.size(), kBackground);
  const double unit = std::max(height / 850.0, 0.5);
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!isFinite(points[i])) continue;
    const Vec3d point(points[i]);
    const Projected p = camera.project(point);
    if (!(p.depth >= camera.nearest)) continue;
    const double radius = splatRadius(length(point), p.scale, style.size, unit) * kOversampling;
    const double x = p.x * kOversampling;
    const double y = p.y * kOversampling;
    if (x < -radius || y < -radius || x > canvas.width + radius || y > canvas.height + radius) continue;
    drawDisc(canvas, x, y, radius, static_cast<float>(p.depth), colors[i]);
  }
  return averagedDown(canvas, camera, width, height, style.depthEdges);
}

}  // namespace scanmill
