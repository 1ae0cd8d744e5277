#include <algorithm>
#include <array>
#include <cmath>

#include "methods/particle/particles.h"

namespace scanmill {

namespace {

// Returns the inverse of a component of a direction; finite, because absolute values below 1e-12 count as 1e-12.
double inverseOf(double component) {
  constexpr double kSmallest = 1e-12;
  return 1 / (std::fabs(component) < kSmallest ? kSmallest : component);
}

// Clips lines' sections to low <= x <= high (m), where x may be any axis. `origin`, `direction`: components along x.
void clip(double low, double high, const Lane& origin, const Lane& direction, Sections& sections) {
  for (int i = 0; i < kPacket; ++i) {
    const double inverse = inverseOf(direction[i]);
    const double a = (low - origin[i]) * inverse;
    const double b = (high - origin[i]) * inverse;
    sections.begin[i] = std::max(sections.begin[i], std::min(a, b));
    sections.end[i] = std::min(sections.end[i], std::max(a, b));
  }
}

}  // namespace

Sections sectionsInsideBox(const MarchJob& job, const Rays& rays) {
  const Box& box = job.sensorField.box;
  Sections inside;
  std::fill_n(inside.begin, kPacket, 0.0);
  std::fill_n(inside.end, kPacket, job.pathLength());
  clip(box.low.x, box.high.x, rays.ox, rays.dx, inside);
  clip(box.low.y, box.high.y, rays.oy, rays.dy, inside);
  clip(box.low.z, box.high.z, rays.oz, rays.dz, inside);
  return inside;
}

void launch(const MarchJob& job, std::span<const Tile> tiles, Particles& particles) {
  const bool lists = job.field().shape.lists;
  particles.resize(tiles.size() * kPacket, lists);
  const Vec3d centre = job.field().shape.centre;
  const double perVoxel = 1 / job.field().shape.voxel;
  Rays rays;
  for (std::size_t t = 0; t < tiles.size(); ++t) {
    setUpRays(job.shot, job.frame, tiles[t], rays);
    Sections inside = sectionsInsideBox(job, rays);
    std::fill(inside.end + rays.count, inside.end + kPacket, 0.0);  // surplus particles are misses
    // In one column of the particles, sets the values of the tile's lanes to valueOf(lane).
    const auto fill = [t](std::vector<float>& column, const auto& valueOf) {
      float* values = column.data() + t * kPacket;
      for (int lane = 0; lane < kPacket; ++lane) values[lane] = static_cast<float>(valueOf(lane));
    };
    const std::array<const Lane*, 3> origins{&rays.ox, &rays.oy, &rays.oz};
    const std::array<const Lane*, 3> directions{&rays.dx, &rays.dy, &rays.dz};
    const std::array<double, 3> centres{centre.x, centre.y, centre.z};
    for (std::size_t k = 0; k < 3; ++k) {
      const Lane& origin = *origins[k];
      const Lane& direction = *directions[k];
      fill(particles.origin[k], [&](int lane) { return (origin[lane] - centres[k]) * perVoxel; });
      fill(particles.direction[k], [&](int lane) { return direction[lane]; });
      if (!lists) continue;
      fill(particles.worldOrigin[k], [&](int lane) { return origin[lane]; });
      fill(particles.inverse[k], [&](int lane) { return inverseOf(direction[lane]); });
    }
    fill(particles.begin, [&](int lane) { return inside.begin[lane] * perVoxel; });
    fill(particles.end, [&](int lane) { return inside.end[lane] * perVoxel; });
  }
}

}  // namespace scanmill
