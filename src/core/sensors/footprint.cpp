#include "sensors/footprint.h"

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "base/parallel.h"
#include "base/random.h"

namespace scanmill {

namespace {

struct GridPoint {
  double x = 0;  // coordinates in half widths of the beam
  double y = 0;
  double weight = 1;
};

// The mean of r^2 over the beam's power, with r the distance from the beam's axis in half widths. It is the same for
// both beam shapes: the power exp(-2 r^2) in the plane, and a constant power in the unit disc.
constexpr double kSecondMoment = 0.5;

// Returns the points of a hexagonal grid about the beam's axis, the point on the axis first. Their weights add up to 1.
// `rays`: one of kFootprintRays.
std::vector<GridPoint> hexagon(std::uint32_t rays, bool uniform) {
  int rings = 0;  // rings of points around the middle point; k rings have 1 + 3 k (k + 1) points
  while (1 + 3 * rings * (rings + 1) < static_cast<int>(rays)) ++rings;
  // With k rings of points, the corners of the hexagon are 2 k / (k + 1) half widths from the axis, before `scale` is
  // applied. Thus more rays sample a wider part of the beam.
  const double spacing = 2.0 / (rings + 1);
  std::vector<GridPoint> points;
  double sum = 0;     // sum of the weights
  double moment = 0;  // sum of the weights times r^2
  // q and r count the steps along two axes of the grid, which are 60 degrees apart.
  for (int q = -rings; q <= rings; ++q) {
    for (int r = std::max(-rings, -q - rings); r <= std::min(rings, -q + rings); ++r) {
      GridPoint p{(q + 0.5 * r) * spacing, std::sqrt(0.75) * r * spacing, 1};
      const double radiusSquared = p.x * p.x + p.y * p.y;
      if (!uniform) p.weight = std::exp(-2 * radiusSquared);
      sum += p.weight;
      moment += p.weight * radiusSquared;
      points.push_back(p);
    }
  }
  // Moves the point on the axis from the middle of the list to its start.
  std::iter_swap(points.begin(), points.begin() + static_cast<std::ptrdiff_t>(points.size() / 2));
  const double scale = moment > 0 ? std::sqrt(kSecondMoment * sum / moment) : 1;
  for (GridPoint& p : points) p = {p.x * scale, p.y * scale, p.weight / sum};
  return points;
}

}  // namespace

double beamArea(const BeamTable& beams, double range) {
  const double across = beams.exitWidth[0] + beams.divergence[0] * range;
  const double up = beams.exitWidth[1] + beams.divergence[1] * range;
  return kPi / 4 * across * up * (beams.uniformBeam ? 1 : 0.5);
}

Footprint makeFootprint(const BeamTable& beams, std::uint32_t raysPerBeam) {
  if (std::find(std::begin(kFootprintRays), std::end(kFootprintRays), raysPerBeam) == std::end(kFootprintRays)) {
    throw Error("a beam cannot have {} rays: they must form a hexagon", raysPerBeam);
  }
  const std::vector<GridPoint> grid = hexagon(raysPerBeam, beams.uniformBeam);
  auto table = std::make_shared<BeamTable>(beams);
  table->raysPerBeam = raysPerBeam;
  table->columns = beams.columns * raysPerBeam;
  table->time.clear();  // all rings of a column fire at BeamTable::columnTime(): see BeamTable::time
  table->direction.assign(table->size(), {});
  const bool wideExit = beams.exitWidth[0] > 0 || beams.exitWidth[1] > 0;
  table->origin.assign(wideExit || !beams.origin.empty() ? table->size() : 0, {});
  parallelForEach(beams.size(), 1024, [&](std::size_t beam) {
    const Vec3d direction = beams.direction[beam];
    const Vec3d origin = beams.originOf(beam);
    // Two unit vectors perpendicular to the beam: one horizontal, one upwards.
    const double horizontal = std::hypot(direction.x, direction.y);
    const Vec3d across =
        horizontal > 1e-9 ? Vec3d{-direction.y / horizontal, direction.x / horizontal, 0} : Vec3d{0, 1, 0};
    const Vec3d up = cross(direction, across);
    const RandomBlock words = randomBlock({.beam = static_cast<std::uint32_t>(beam), .purpose = Purpose::Footprint});
    const double rotation = 2 * kPi * uniform(words[0]);
    const double c = std::cos(rotation);
    const double s = std::sin(rotation);
    for (std::uint32_t k = 0; k < raysPerBeam; ++k) {
      const double x = c * grid[k].x - s * grid[k].y;
      const double y = s * grid[k].x + c * grid[k].y;
      const std::size_t ray = beam * raysPerBeam + k;
      table->direction[ray] =
          normalized(direction + across * (x * beams.divergence[0] / 2) + up * (y * beams.divergence[1] / 2));
      if (table->origin.empty()) continue;
      table->origin[ray] = Vec3f(origin + across * (x * beams.exitWidth[0] / 2) + up * (y * beams.exitWidth[1] / 2));
    }
  });
  Footprint footprint{std::move(table), {}};
  for (const GridPoint& p : grid) footprint.weight.push_back(static_cast<float>(p.weight));
  return footprint;
}

void joinRays(const Footprint& footprint, Hits& hits) {
  const std::uint32_t rays = footprint.rays->raysPerBeam;
  hits.columns = footprint.rays->columns / rays;
  hits.beamOfRay.resize(hits.rays());
  hits.weightOfRay.resize(hits.rays());
  // Arrays for the rays of the first 64 beams are computed once and copied block by block, which is faster than a
  // division for each ray.
  constexpr std::size_t kBeams = 64;
  std::vector<std::uint32_t> beamOf;  // by ray of the block: index of its beam in the block
  std::vector<float> weights;
  for (std::uint32_t beam = 0; beam < kBeams; ++beam) {
    beamOf.insert(beamOf.end(), rays, beam);
    weights.insert(weights.end(), footprint.weight.begin(), footprint.weight.end());
  }
  for (std::size_t first = 0; first < hits.rays(); first += weights.size()) {
    const std::size_t count = std::min(weights.size(), hits.rays() - first);
    const auto firstBeam = static_cast<std::uint32_t>(first / rays);
    std::copy_n(weights.data(), count, &hits.weightOfRay[first]);
    for (std::size_t i = 0; i < count; ++i) hits.beamOfRay[first + i] = firstBeam + beamOf[i];
  }
}

}  // namespace scanmill
