#include "viewer/view_camera.h"

#include "viewer/window/orbit_camera.h"

namespace scanmill {

namespace {

constexpr std::array kViews{View::Driver, View::Above, View::Chase};

TEST(ViewCamera, LookingAtTheMiddle) {
  for (const View view : kViews) {
    const ViewCamera camera = presetCamera(view).camera(640, 360);
    for (const double distance : {1.0, 7.5, 300.0}) {
      const Projected p = camera.project(camera.eye + camera.forward * distance);
      EXPECT_NEAR(p.x, 320, 1e-9);
      EXPECT_NEAR(p.y, 180, 1e-9);
      EXPECT_NEAR(p.depth, distance, 1e-9);
    }
  }
}

TEST(ViewCamera, AxesAreOrthonormalAndRightHanded) {
  for (const View view : kViews) {
    const ViewCamera camera = presetCamera(view).camera(640, 360);
    EXPECT_NEAR(length(camera.right), 1, 1e-12);
    EXPECT_NEAR(length(camera.forward), 1, 1e-12);
    const Vec3d forward = cross(camera.right, camera.down);
    EXPECT_NEAR(length(forward - camera.forward), 0, 1e-12);
  }
}

// x = c + f X / Z, from the driver's seat: left is +y, up is +z.
TEST(ViewCamera, DriverIsAPinholeAtTheSensor) {
  const ViewCamera camera = presetCamera(View::Driver).camera(1600, 900);
  const Projected p = camera.project({20, 3, -2});
  EXPECT_NEAR(p.x, 800 - camera.focal * 3 / 20, 1e-9);
  EXPECT_NEAR(p.y, 450 + camera.focal * 2 / 20, 1e-9);
  EXPECT_NEAR(p.scale, camera.focal / 20, 1e-9);
  const Projected twiceAsFar = camera.project({40, 3, -2});
  EXPECT_NEAR(twiceAsFar.x - 800, (p.x - 800) / 2, 1e-9);
}

TEST(ViewCamera, AboveIsAMap) {
  const ViewCamera camera = presetCamera(View::Above).camera(1600, 900);
  const Projected origin = camera.project({0, 0, 0});
  const Projected p = camera.project({10, 5, -1.7});
  EXPECT_NEAR(origin.x, 800, 1e-9);
  EXPECT_NEAR(origin.y, 450, 1e-9);
  EXPECT_NEAR(p.x - origin.x, 10 * camera.focal, 1e-9);
  EXPECT_NEAR(p.y - origin.y, -5 * camera.focal, 1e-9);
  EXPECT_GT(p.depth, origin.depth) << "lower is farther";
  EXPECT_NEAR(camera.project({10, 5, 30}).x, p.x, 1e-9);
}

TEST(ViewCamera, ChaseSeesTheSensorBelowAndForwardAbove) {
  const ViewCamera camera = presetCamera(View::Chase).camera(1600, 900);
  const Projected sensor = camera.project({0, 0, 0});
  const Projected ahead = camera.project({40, 0, 0});
  EXPECT_NEAR(sensor.x, 800, 1e-9);
  EXPECT_GT(sensor.depth, 0);
  EXPECT_GT(ahead.depth, sensor.depth);
  EXPECT_LT(ahead.y, sensor.y);
  EXPECT_LT(camera.project({10, 5, -2}).x, 800) << "left of the vehicle is left on the picture";
}

}  // namespace

}  // namespace scanmill
