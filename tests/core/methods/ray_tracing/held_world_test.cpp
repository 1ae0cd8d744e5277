#include "methods/ray_tracing/held_world.h"

#include <gtest/gtest.h>

#include <memory>

#include "methods/world/worlds.h"
#include "scene/movement.h"
#include "tests/support/gl.h"
#include "tests/support/test_scene.h"

namespace scanmill {
namespace {

Scene drivingBox() {
  SceneBuilder builder = testBuilder();
  Mesh box = meshOf(builder, "thing");
  appendBox(box, 0, {}, {1, 2, 3});
  builder.place(builder.addMesh(box), at(5, 0, 0), "box", {}, std::make_shared<Movement>(Vec3d{0, 4, 0}));
  return builder.finish();
}

// Who waits for a revolution says where its meshes stand, once they are there.
TEST(HeldWorld, RevolutionsOfHeldMeshesArePlacedByAnyThread) {
  SKIP_WITHOUT_GL();
  const ComputeDevice device({"the test cannot run", "there is nothing instead"});
  HeldWorld held(device, 1 << 30);
  DeviceResolver resolver(device, 1 << 30);
  const Scene scene = drivingBox();
  const Worlds worlds(scene, Instancing::Auto, {});
  const auto first = worlds.near({}, 0, 0.1);
  const auto second = worlds.near({}, 0.1, 0.1);
  EXPECT_EQ(held.placesOf(first), nullptr) << "no mesh is there";
  held.hold(first, nullptr, resolver);
  EXPECT_EQ(held.placesOf(first), nullptr) << "all is there";
  const auto places = held.placesOf(second);
  ASSERT_NE(places, nullptr);
  EXPECT_EQ(places->stands.size(), 2u);
  held.hold(second, places, resolver);
  EXPECT_EQ(held.placesOf(second), nullptr);
  EXPECT_NE(held.placesOf(first), nullptr);
  // The meshes of another scene take their room.
  const Scene other = drivingBox();
  const Worlds others(other, Instancing::Auto, {});
  held.hold(others.near({}, 0, 0.1), nullptr, resolver);
  EXPECT_EQ(held.placesOf(first), nullptr);
}

}  // namespace
}  // namespace scanmill
