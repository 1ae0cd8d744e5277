#include "viewer/window/orbit_camera.h"

#include <random>

#include "tests/support/message_of.h"

namespace scanmill {
namespace {

constexpr std::pair<int, int> kSizes[] = {{1600, 900}, {640, 640}, {300, 900}, {64, 64}};

OrbitCamera randomCamera(std::mt19937& random) {
  std::uniform_real_distribution<double> unit(-1, 1);
  return {.target = {50 * unit(random), 50 * unit(random), 5 * unit(random)},
          .yaw = kPi * unit(random),
          .pitch = kPi / 2 * unit(random),
          .distance = std::pow(10, 1 + unit(random)),
          .orthographic = unit(random) > 0.3};
}

// A named view would miss points far below the sensor, but sees the same points around it.
TEST(OrbitCamera, ANamedViewThatWouldMissThePointsSeesThem) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> unit(-1, 1);
  const auto shareSeen = [](const OrbitCamera& camera, const std::vector<Vec3d>& points, int width, int height) {
    const ViewCamera view = camera.camera(width, height);
    const auto seen = std::ranges::count_if(points, [&](const Vec3d& point) {
      const Projected p = view.project(point);
      return p.depth > view.nearest && p.x >= 0 && p.y >= 0 && p.x < width && p.y < height;
    });
    return static_cast<double>(seen) / static_cast<double>(points.size());
  };
  std::vector<Vec3d> ahead;
  std::vector<Vec3d> below;
  for (int i = 0; i < 1000; ++i) {
    ahead.push_back({20 + 18 * unit(random), 12 * unit(random), -2});
    below.push_back({2.5 * unit(random), 30 * unit(random), -40 + 0.2 * unit(random)});
  }
  below.push_back({4000, 0, 900});  // one of fog or dust
  for (const View view : {View::Driver, View::Above, View::Chase}) {
    for (const auto& [width, height] : kSizes) {
      SCOPED_TRACE(std::string(kViewNames[static_cast<std::size_t>(view)]) + " " + std::to_string(width));
      const OrbitCamera preset = presetCamera(view);
      EXPECT_EQ(preset.seeing(ahead, view, width, height), preset);
      EXPECT_EQ(preset.seeing({}, view, width, height), preset);
      const OrbitCamera moved = preset.seeing(below, view, width, height);
      if (view != View::Chase || height > width) continue;  // an upright picture shows what is below
      EXPECT_LT(shareSeen(preset, below, width, height), 0.01);
      EXPECT_GT(shareSeen(moved, below, width, height), 0.9);
      EXPECT_LT(moved.distance, 120) << "they fill the picture";
      EXPECT_EQ(moved.yaw, preset.yaw);
    }
  }
}

TEST(OrbitCamera, ItsAxesAreSquareAndTheTargetIsInTheMiddle) {
  std::mt19937 random(2);
  for (int i = 0; i < 100; ++i) {
    const OrbitCamera camera = randomCamera(random);
    const ViewCamera view = camera.camera(800, 600);
    EXPECT_NEAR(dot(view.right, view.down), 0, 1e-12);
    EXPECT_NEAR(dot(view.right, view.forward), 0, 1e-12);
    EXPECT_NEAR(length(view.down), 1, 1e-12);
    EXPECT_NEAR(view.right.z, 0, 1e-12);  // the horizon is level
    const Projected middle = view.project(camera.target);
    EXPECT_NEAR(middle.x, 400, 1e-6);
    EXPECT_NEAR(middle.y, 300, 1e-6);
    if (!camera.orthographic) {
      EXPECT_NEAR(middle.depth, camera.distance, 1e-9);
    }
  }
}

TEST(OrbitCamera, BothProjectionsShowTheTargetAtTheSameSize) {
  std::mt19937 random(3);
  OrbitCamera camera = randomCamera(random);
  camera.orthographic = false;
  const auto pixelsPerMetre = [&] {
    const ViewCamera view = camera.camera(800, 600);
    return view.project(camera.target + view.right).x - view.project(camera.target).x;
  };
  const double scale = pixelsPerMetre();
  camera.orthographic = true;
  EXPECT_NEAR(pixelsPerMetre(), scale, 1e-9 * scale);
}

TEST(OrbitCamera, ADragOverTwiceTheHeightIsAWholeTurn) {
  std::mt19937 random(4);
  for (int i = 0; i < 20; ++i) {
    const OrbitCamera before = randomCamera(random);
    OrbitCamera after = before;
    for (int k = 0; k < 12; ++k) after.orbit(100, 0, 600);
    EXPECT_NEAR(std::remainder(after.yaw - before.yaw, 2 * kPi), 0, 1e-9);
    EXPECT_EQ(after.target, before.target);
    after.orbit(0, 1e6, 600);
    EXPECT_DOUBLE_EQ(after.pitch, kPi / 2);
    after.orbit(0, -1e7, 600);
    EXPECT_DOUBLE_EQ(after.pitch, -kPi / 2);
  }
}

TEST(OrbitCamera, WhatIsNearFollowsTheDrag) {
  OrbitCamera camera = presetCamera(View::Chase);
  const Vec3d near = camera.target - camera.camera(800, 600).forward;
  const Projected before = camera.camera(800, 600).project(near);
  camera.orbit(5, 3, 600);
  const Projected after = camera.camera(800, 600).project(near);
  EXPECT_GT(after.x, before.x);
  EXPECT_GT(after.y, before.y);
}

TEST(OrbitCamera, PanningFollowsThePointer) {
  std::mt19937 random(5);
  for (int i = 0; i < 50; ++i) {
    OrbitCamera camera = randomCamera(random);
    const Vec3d held = camera.target;
    camera.pan(37, -21, 800, 600);
    const Projected now = camera.camera(800, 600).project(held);
    EXPECT_NEAR(now.x, 437, 1e-6);
    EXPECT_NEAR(now.y, 279, 1e-6);
  }
}

TEST(OrbitCamera, ZoomStepsAreUndoneAndEndSomewhere) {
  OrbitCamera camera;
  const double before = camera.distance;
  camera.zoom(1);
  EXPECT_NEAR(camera.distance, 0.9 * before, 1e-12);
  camera.zoom(-1);
  EXPECT_NEAR(camera.distance, before, 1e-12);
  camera.zoom(1e9);
  EXPECT_DOUBLE_EQ(camera.distance, 0.1);
  camera.zoom(-1e9);
  EXPECT_DOUBLE_EQ(camera.distance, 1e4);
}

TEST(OrbitCamera, LooksAtAPlaceFromWhereItStands) {
  std::mt19937 random(6);
  for (int i = 0; i < 100; ++i) {
    OrbitCamera camera = randomCamera(random);
    const Vec3d eye = camera.eye();
    const Vec3d place = camera.target + Vec3d{3, -2, 1};
    camera.lookAt(place);
    if (!camera.orthographic) {
      EXPECT_NEAR(length(camera.eye() - eye), 0, 1e-6 * length(eye) + 1e-9);
    }
    const Projected middle = camera.camera(800, 600).project(place);
    EXPECT_NEAR(middle.x, 400, 1e-6);
    EXPECT_NEAR(middle.y, 300, 1e-6);
  }
}

TEST(OrbitCamera, MovesWithItsFrame) {
  std::mt19937 random(8);
  for (int i = 0; i < 50; ++i) {
    const OrbitCamera before = randomCamera(random);
    const Affine newFromOld = toAffine(Pose{fromYawPitchRoll(0.1 * i, 0, 0), {3, 4, 5}});
    OrbitCamera after = before;
    after.moveBy(newFromOld);
    const Vec3d place = before.target + Vec3d{0.3, 0.2, 0.1};
    const Projected a = before.camera(800, 600).project(place);
    const Projected b = after.camera(800, 600).project(newFromOld * place);
    EXPECT_NEAR(a.x, b.x, 1e-6);
    EXPECT_NEAR(a.y, b.y, 1e-6);
  }
}

TEST(OrbitCamera, ItsTextIsReadAgain) {
  std::mt19937 random(9);
  std::vector<OrbitCamera> cameras{presetCamera(View::Chase), presetCamera(View::Driver), presetCamera(View::Above)};
  for (int i = 0; i < 100; ++i) cameras.push_back(randomCamera(random));
  for (const OrbitCamera& camera : cameras) {
    const OrbitCamera again = parseCamera(camera.text()).camera;
    EXPECT_NEAR(std::remainder(again.yaw - camera.yaw, 2 * kPi), 0, 1e-5) << camera.text();
    EXPECT_NEAR(again.pitch, camera.pitch, 1e-5);
    EXPECT_NEAR(again.distance, camera.distance, 1e-5 * camera.distance);
    EXPECT_NEAR(length(again.target - camera.target), 0, 1e-3);
    EXPECT_NEAR(again.focal, camera.focal, 1e-5);
    EXPECT_EQ(again.orthographic, camera.orthographic);
    EXPECT_EQ(again.text(), camera.text());
  }
}

TEST(OrbitCamera, TextsSayWhatTheyName) {
  EXPECT_EQ(parseCamera("above").view, View::Above);
  EXPECT_FALSE(parseCamera("above").placed);
  EXPECT_FALSE(parseCamera("30,20,25").view.has_value());
  EXPECT_FALSE(parseCamera("30,20,25,ortho").placed);
  const CameraChoice grid = parseCamera("30,20,25,691234.125,5334567.25,512.5");  // metres of a grid of the earth
  EXPECT_TRUE(grid.placed);
  EXPECT_EQ(grid.camera.target, (Vec3d{691234.125, 5334567.25, 512.5}));
  EXPECT_EQ(parseCamera(grid.camera.text()).camera.target, grid.camera.target);
}

TEST(OrbitCamera, WrongTextsAreRefusedWithAnExample) {
  const std::vector<std::string> texts{"",
                                       "behind",
                                       "1,2",
                                       "1,2,3,4",
                                       "1,2,3,4,5",
                                       "1,2,nan",
                                       "1,91,3",
                                       "1,2,0",
                                       "1,2,-5",
                                       "1,2,1e9",
                                       "1,2,3,",
                                       ",1,2,3",
                                       "1;2;3",
                                       "1,2,3,4,5,6,0",
                                       "1,2,3,4,5,6,7,8",
                                       "1,2,3 ",
                                       "Chase",
                                       "1,2,3,1e9,0,0",
                                       "1,2,3,ortho,ortho",
                                       "ortho"};
  for (const std::string& text : texts) {
    EXPECT_THAT(messageOf([&] { parseCamera(text); }), testing::HasSubstr("YAW,PITCH,DISTANCE")) << text;
  }
}

// x = c + f X / Z, from the driver's seat: left is +y, up is +z.
TEST(ViewCamera, DriverIsAPinholeAtTheSensor) {
  const ViewCamera camera = presetCamera(View::Driver).camera(1600, 900);
  const Projected p = camera.project({20, 3, -2});
  EXPECT_NEAR(p.x, 800 - camera.focal * 3 / 20, 1e-9);
  EXPECT_NEAR(p.y, 450 + camera.focal * 2 / 20, 1e-9);
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
