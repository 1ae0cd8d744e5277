#include "town/placer.h"

#include <cmath>

namespace scanmill::town {

Placer::Placer(SceneBuilder& sceneBuilder, const Layout& townLayout, const Affine& frame)
    : builder(sceneBuilder), layout(townLayout), worldFromTown(frame) {
  for (const Footprint& cover : layout.covers()) occupancy.add(cover);
  for (const Patch& patch : layout.patches()) driveways.add(patch.place);
}

Vec3d Placer::onGround(const Point2& p, double sink) const {
  return {p.x, p.y, layout.heightAt(p) - sink};
}

Footprint Placer::footprint(const Model& m, const Spot& s, double grow) {
  const Vec3d c = m.bounds.center() * s.scale;
  const double cy = std::cos(s.yaw);
  const double sy = std::sin(s.yaw);
  return {{s.at.x + cy * c.x - sy * c.y, s.at.y + sy * c.x + cy * c.y},
          (m.bounds.high.x - m.bounds.low.x) / 2 * s.scale + grow,
          (m.bounds.high.y - m.bounds.low.y) / 2 * s.scale + grow,
          s.yaw};
}

void Placer::put(const Model& m, const Spot& s, const std::string& name, double sink) {
  Affine place = models::at(onGround(s.at, sink), s.yaw);
  place.linear = place.linear * toMatrix(fromYawPitchRoll(0, 0, s.lean)) * Mat3::scale(Vec3d{1, 1, 1} * s.scale);
  builder.place(m.mesh, worldFromTown * place, name);
}

bool Placer::tryPut(const Model& m, const Spot& s, const std::string& name, double sink) {
  if (!isFree(footprint(m, s, kGap))) return false;
  occupancy.add(footprint(m, s, 0));
  put(m, s, name, sink);
  return true;
}

bool Placer::tryPark(const Model& m, const Spot& s, const std::string& name) {
  if (!isFree(footprint(m, s, kGap)) || !noParking.isFree(footprint(m, s, 0))) return false;
  park(m, s, name);
  return true;
}

void Placer::park(const Model& m, const Spot& s, const std::string& name) {
  occupancy.add(footprint(m, s, 0));
  const double halfX = 0.3 * (m.bounds.high.x - m.bounds.low.x);
  const double halfY = 0.4 * (m.bounds.high.y - m.bounds.low.y);
  const Point2 ahead{std::cos(s.yaw), std::sin(s.yaw)};
  const auto ground = [&](double u, double v) {
    return onGround({s.at.x + u * ahead.x - v * ahead.y, s.at.y + u * ahead.y + v * ahead.x}, 0);
  };
  const Vec3d x = normalized(ground(halfX, 0) - ground(-halfX, 0));
  const Vec3d left = ground(0, halfY) - ground(0, -halfY);
  const Vec3d z = normalized(cross(x, left));
  const Vec3d middle = (ground(halfX, 0) + ground(-halfX, 0)) * 0.5;
  builder.place(m.mesh, worldFromTown * Affine{{x, cross(z, x), z}, middle}, name);
}

Spot besideRoad(const Road& road, double along, double lateral) {
  const Point2 p = road.point(along);
  const Point2 h = road.heading(along);
  return {{p.x - h.y * lateral, p.y + h.x * lateral}, std::atan2(h.y, h.x), 1, 0};
}

}  // namespace scanmill::town
