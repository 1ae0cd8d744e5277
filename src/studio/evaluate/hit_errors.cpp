#include "evaluate/hit_errors.h"

#include <fmt/core.h>

#include <cmath>
#include <memory>

#include "base/error.h"

namespace scanmill {

void requireOneRay(const Hits& hits) {
  if (hits.beamOfRay.empty() && hits.rays() == hits.size()) return;
  throw Error(
      fmt::format("{} beams have {} rays, but methods are compared with one ray per beam", hits.rays(), hits.size()));
}

HitErrors compareHits(const Hits& reference, const Hits& tested, std::span<const std::uint8_t> edges) {
  if (reference.size() != tested.size() || (!edges.empty() && edges.size() != reference.size())) {
    throw Error(fmt::format("hits of {} and of {} beams cannot be compared", reference.size(), tested.size()));
  }
  requireOneRay(reference);
  requireOneRay(tested);
  HitErrors e;
  e.beams = reference.size();
  std::vector<double> all;
  std::vector<double> same;
  std::vector<double> interior;
  for (std::size_t i = 0; i < reference.size(); ++i) {
    const bool inside = edges.empty() || edges[i] == 0;
    e.interior += inside ? 1 : 0;
    if (!reference.hit(i) || !tested.hit(i)) {
      e.falseNegatives += reference.hit(i) ? 1 : 0;
      e.falsePositives += tested.hit(i) ? 1 : 0;
      e.interiorAgree += inside && reference.hit(i) == tested.hit(i) ? 1 : 0;
      continue;
    }
    ++e.bothHit;
    const double error = std::abs(double{tested.range[i]} - double{reference.range[i]});
    const bool label = reference.semantic[i] == tested.semantic[i] && reference.instance[i] == tested.instance[i];
    all.push_back(error);
    if (label) same.push_back(error);
    if (inside) interior.push_back(error);
    e.sameLabel += label ? 1 : 0;
    e.interiorAgree += inside && label ? 1 : 0;
  }
  e.range = spreadOf(std::move(all));
  e.rangeSameSurface = spreadOf(std::move(same));
  e.rangeInterior = spreadOf(std::move(interior));
  return e;
}

std::vector<std::uint8_t> edgeBeams(const Method& method, const Shot& shot, double angle) {
  // Fraction of the range by which ranges of neighbouring beams may differ on one surface.
  constexpr double kStep = 0.1;
  const Channels channels = Channel::Range | Channel::Instance | Channels(Channel::Semantic);
  Hits middle;
  method.trace(shot, channels, middle);
  requireOneRay(middle);
  std::vector<std::uint8_t> edges(middle.size(), 0);
  Hits beside;
  for (int up = -1; up <= 1; ++up) {
    for (int left = -1; left <= 1; ++left) {
      if (up == 0 && left == 0) continue;
      auto turned = std::make_shared<BeamTable>(*shot.beams);
      for (Vec3d& d : turned->direction) {
        const Vec3d across = normalized(cross(Vec3d{0, 0, 1}, d));
        const Vec3d above = cross(d, across);
        d = normalized(d + (across * left + above * up) * std::tan(angle));
      }
      Shot other = shot;
      other.beams = turned;
      method.trace(other, channels, beside);
      for (std::size_t i = 0; i < edges.size(); ++i) {
        const bool differs = middle.hit(i) != beside.hit(i) || middle.instance[i] != beside.instance[i] ||
                             middle.semantic[i] != beside.semantic[i] ||
                             (middle.hit(i) && std::abs(middle.range[i] - beside.range[i]) > kStep * middle.range[i]);
        if (differs) edges[i] = 1;
      }
    }
  }
  return edges;
}

}  // namespace scanmill
