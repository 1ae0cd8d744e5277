#include "town/placer.h"

namespace scanmill::town {

Placer::Placer(SceneBuilder& sceneBuilder, const Layout& townLayout, const Affine& frame)
    : builder(sceneBuilder), layout(townLayout), worldFromTown(frame) {
  for (const Footprint& cover : layout.covers) occupancy.add(cover);
  for (const Patch& patch : layout.patches) {
    if (patch.kind != GroundKind::Paved) driveways.add(patch.rectangle);
  }
}

void Placer::put(const Model& m, const Spot& s, const std::string& name, double sink) {
  builder.place(m.mesh, worldFromTown * models::poseOf(s, layout.heightAt(s.at) - sink), name);
}

bool Placer::tryPut(const Model& m, const Spot& s, const std::string& name) {
  if (!isFree(footprint(m, s, kGap))) return false;
  occupancy.add(footprint(m, s, 0));
  put(m, s, name);
  return true;
}

bool Placer::tryPark(const Model& m, const Spot& s, const std::string& name) {
  if (!isFree(footprint(m, s, kGap)) || !noParking.isFree(footprint(m, s, 0))) return false;
  park(m, s, name);
  return true;
}

// The pose follows from the ground's height at four points: at the front, the rear, the left and the right.
void Placer::park(const Model& m, const Spot& s, const std::string& name) {
  occupancy.add(footprint(m, s, 0));
  const double halfX = 0.3 * m.length();
  const double halfY = 0.4 * m.width();
  const Footprint wheels{s.at, halfX, halfY, s.yaw};
  const auto ground = [&](double u, double v) { return layout.onGround(wheels.at(u, v)); };
  const Vec3d x = normalized(ground(halfX, 0) - ground(-halfX, 0));
  const Vec3d left = ground(0, halfY) - ground(0, -halfY);
  const Vec3d z = normalized(cross(x, left));
  const Vec3d middle = (ground(halfX, 0) + ground(-halfX, 0)) * 0.5;
  builder.place(m.mesh, worldFromTown * Affine{{x, cross(z, x), z}, middle}, name);
}

void Placer::putMoving(std::uint32_t mesh, const std::string& name, const std::shared_ptr<const Movement>& movement,
                       const std::shared_ptr<const Animation>& animation) {
  if (!layout.character.plain) {
    builder.place(mesh, {}, name, {}, movement, animation);
    return;
  }
  constexpr double kBelow = -1;  // m; lower positions are below the ground of a plain town
  const Pose pose = movement->at(0);
  if ((inverse(worldFromTown) * pose.translation).z > kBelow) builder.place(mesh, toAffine(pose), name);
}

// Places objects in the order of priority: later objects are placed only on ground that is still free.
void populate(SceneBuilder& builder, const Layout& layout, const Affine& worldFromTown) {
  Placer placer(builder, layout, worldFromTown);
  placeHouses(placer);
  placeMapTrees(placer);
  placeBoundaries(placer);
  placeRails(placer);
  placeClutter(placer);
  placeMarkings(placer);
  placeCovers(placer);
  placeFixtures(placer);
  placeWires(placer);
  placeVehicles(placer);
  placeTraffic(placer);
  placeTrees(placer);
  placePeople(placer);
  placeAnimals(placer);
  placeBushes(placer);
  placeWoods(placer);
  placeGrass(placer);
}

}  // namespace scanmill::town
