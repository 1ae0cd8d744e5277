#include "viewer/view_camera.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace scanmill {

namespace {

constexpr std::array kViews{View::Driver, View::Above, View::Chase};

TEST(ViewCamera, LookingAtTheMiddle) {
  for (const View view : kViews) {
    const ViewCamera camera = makeCamera(view, 640, 360, 1);
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
    const ViewCamera camera = makeCamera(view, 640, 360, 1);
    EXPECT_NEAR(length(camera.right), 1, 1e-12);
    EXPECT_NEAR(length(camera.forward), 1, 1e-12);
    const Vec3d forward = cross(camera.right, camera.down);
    EXPECT_NEAR(length(forward - camera.forward), 0, 1e-12);
  }
}

// x = c + f X / Z, from the driver's seat: left is +y, up is +z.
TEST(ViewCamera, DriverIsAPinholeAtTheSensor) {
  const ViewCamera camera = makeCamera(View::Driver, 1600, 900, 1);
  const Projected p = camera.project({20, 3, -2});
  EXPECT_NEAR(p.x, 800 - camera.focal * 3 / 20, 1e-9);
  EXPECT_NEAR(p.y, 450 + camera.focal * 2 / 20, 1e-9);
  EXPECT_NEAR(p.scale, camera.focal / 20, 1e-9);
  const Projected twiceAsFar = camera.project({40, 3, -2});
  EXPECT_NEAR(twiceAsFar.x - 800, (p.x - 800) / 2, 1e-9);
}

TEST(ViewCamera, AboveIsAMap) {
  const ViewCamera camera = makeCamera(View::Above, 1600, 900, 1);
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
  const ViewCamera camera = makeCamera(View::Chase, 1600, 900, 1);
  const Projected sensor = camera.project({0, 0, 0});
  const Projected ahead = camera.project({40, 0, 0});
  EXPECT_NEAR(sensor.x, 800, 1e-9);
  EXPECT_GT(sensor.depth, 0);
  EXPECT_GT(ahead.depth, sensor.depth);
  EXPECT_LT(ahead.y, sensor.y);
  EXPECT_LT(camera.project({10, 5, -2}).x, 800) << "left of the vehicle is left on the picture";
}

TEST(ViewCamera, ZoomEnlargesAboutTheMiddle) {
  const Vec3d point{12, 4, -1};
  for (const View view : kViews) {
    const Projected p = makeCamera(view, 640, 360, 1).project(point);
    const Projected q = makeCamera(view, 640, 360, 2.5).project(point);
    EXPECT_NEAR(q.x - 320, 2.5 * (p.x - 320), 1e-9);
    EXPECT_NEAR(q.y - 180, 2.5 * (p.y - 180), 1e-9);
  }
}

TEST(ViewCamera, CloseUpKeepsTheDirectionAndLooksAtThePlace) {
  const CloseUp closeUp{{9, -4, -1}, 2.5};
  for (const View view : kViews) {
    const ViewCamera far = makeCamera(view, 640, 360, 1);
    const ViewCamera near = makeCamera(view, 640, 360, 1, closeUp);
    EXPECT_EQ(near.forward, far.forward);
    EXPECT_EQ(near.right, far.right);
    EXPECT_EQ(near.down, far.down);
    EXPECT_FALSE(near.orthographic);
    const Projected p = near.project(closeUp.at);
    EXPECT_NEAR(p.x, 320, 1e-9);
    EXPECT_NEAR(p.y, 180, 1e-9);
  }
}

// The outline of the ball, where lines of sight touch it, lies just within the shorter side of the picture, and all of
// the ball is before the camera.
TEST(ViewCamera, CloseUpFramesItsBall) {
  for (const auto& [width, height] : {std::pair{640, 360}, std::pair{300, 700}}) {
    for (const double within : {0.01, 1.0, 80.0}) {
      const CloseUp closeUp{{30, 5, 2}, within};
      const ViewCamera camera = makeCamera(View::Chase, width, height, 1, closeUp);
      double farthest = 0;
      for (int i = 0; i < 180; ++i) {
        for (int k = 0; k < 360; ++k) {
          const double polar = kPi * i / 180;
          const double turn = kPi * k / 180;
          const Vec3d direction{std::sin(polar) * std::cos(turn), std::sin(polar) * std::sin(turn), std::cos(polar)};
          const Projected p = camera.project(closeUp.at + direction * within);
          ASSERT_GE(p.depth, camera.nearest);
          farthest = std::max(farthest, std::hypot(p.x - width / 2.0, p.y - height / 2.0));
        }
      }
      const double half = std::min(width, height) / 2.0;
      EXPECT_LE(farthest, half);
      EXPECT_GE(farthest, half * 0.95);
    }
  }
}

// Half of the radius shows half as much: a point at the same share of it is at the same pixel.
TEST(ViewCamera, CloseUpOfHalfTheRadiusIsTwiceAsLarge) {
  const Vec3d at{9, -4, -1};
  const Vec3d offset{0.8, 0.3, -0.5};
  for (const View view : kViews) {
    const Projected wide = makeCamera(view, 640, 360, 1, CloseUp{at, 2}).project(at + offset * 2);
    const Projected tight = makeCamera(view, 640, 360, 1, CloseUp{at, 1}).project(at + offset);
    EXPECT_NEAR(wide.x, tight.x, 1e-9);
    EXPECT_NEAR(wide.y, tight.y, 1e-9);
    EXPECT_NEAR(tight.scale, 2 * wide.scale, 1e-9);
    const Projected zoomed = makeCamera(view, 640, 360, 3, CloseUp{at, 2}).project(at + offset * 2);
    EXPECT_NEAR(zoomed.x - 320, 3 * (wide.x - 320), 1e-9);
  }
}

}  // namespace

}  // namespace scanmill
