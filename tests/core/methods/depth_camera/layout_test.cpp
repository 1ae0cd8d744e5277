#include "base/random.h"
#include "methods/depth_camera/depth_camera.h"
#include "sensors/sensor.h"
#include "tests/support/message_of.h"
#include "tests/support/test_scene.h"

namespace scanmill {
namespace {

Vec3d direction(double azimuthDeg, double elevationDeg) {
  const double a = radians(azimuthDeg);
  const double e = radians(elevationDeg);
  return {std::cos(e) * std::cos(a), std::cos(e) * std::sin(a), std::sin(e)};
}

// How many pixels inside of the image the direction falls; negative: outside.
double inside(const Camera& camera, const Vec3d& d) {
  const Vec3d c = transposed(toMatrix(camera.worldFromCamera.rotation)) * d;
  if (!(c.z > 0)) return -INFINITY;
  const double u = camera.cx + camera.fx * c.x / c.z;
  const double v = camera.cy + camera.fy * c.y / c.z;
  return std::min({u, v, camera.width - u, camera.height - v});
}

double inside(const std::vector<Camera>& cameras, const Vec3d& d) {
  double best = -INFINITY;
  for (const Camera& camera : cameras) best = std::max(best, inside(camera, d));
  return best;
}

std::size_t pixels(const std::vector<Camera>& cameras) {
  std::size_t sum = 0;
  for (const Camera& camera : cameras) sum += camera.pixels();
  return sum;
}

void expectHeld(const std::vector<Vec3d>& directions, std::uint32_t resolution = 1024) {
  const std::vector<Camera> cameras = layOutCameras(directions, {CameraLayout::Auto, resolution});
  ASSERT_LE(cameras.size(), 8u);
  for (const Camera& camera : cameras) {
    EXPECT_LT(camera.horizontalField(), radians(170.0));
    EXPECT_LT(camera.verticalField(), radians(170.0));
    EXPECT_NEAR(camera.fx, resolution / 2.0, 1e-9);
    EXPECT_EQ(camera.fx, camera.fy);
    EXPECT_EQ(camera.worldFromCamera.translation, Vec3d{});
  }
  for (const Vec3d& d : directions) {
    ASSERT_GE(inside(cameras, d), 0.5) << d.x << " " << d.y << " " << d.z;
  }
}

TEST(CameraLayout, AutoHoldsAllBeamsOfTheShippedSensorsInFewPixels) {
  int sensors = 0;
  for (const auto& file : std::filesystem::directory_iterator(SCANMILL_SOURCE_DIR "/pipelines/sensors")) {
    SCOPED_TRACE(file.path().string());
    const Value value = readYaml(file.path());
    const auto beams = makeBeams(value);
    expectHeld(beams->direction, 2048);
    const std::size_t taken = pixels(layOutCameras(beams->direction, {CameraLayout::Auto, 2048}));
    const std::size_t four = pixels(layOutCameras(beams->direction, {CameraLayout::Four90, 2048}));
    // Those that look far up or down fill the squares, or more than four of them.
    double steepest = 0;
    for (const Vec3d& d : beams->direction) steepest = std::max(steepest, std::fabs(std::asin(d.z)));
    const double most = steepest > radians(45.5) ? 1.5 : steepest > radians(35) ? 1.01 : 0.5;
    EXPECT_LT(static_cast<double>(taken), static_cast<double>(four) * most)
        << "the same pixels at the centre, cropped to the beams";
    ++sensors;
  }
  EXPECT_GE(sensors, 25);
}

TEST(CameraLayout, AutoHoldsAnyFan) {
  for (std::uint32_t i = 0; i < 300; ++i) {
    const RandomBlock b = randomBlock({5, 0, 0, 0, i, 0, Purpose::Test});
    const RandomBlock c = randomBlock({6, 0, 0, 0, i, 0, Purpose::Test});
    const double start = 360 * uniform(b[0]);
    const double width = 360 * std::pow(uniform(b[1]), 2.0);
    const double low = -90 + 180 * uniform(b[2]);
    const double high = low + (90 - low) * uniform(b[3]);
    const int columns = 1 + static_cast<int>(60 * uniform(c[0]));
    const int rings = 1 + static_cast<int>(12 * uniform(c[1]));
    std::vector<Vec3d> directions;
    for (int r = 0; r < rings; ++r) {
      for (int k = 0; k < columns; ++k) {
        directions.push_back(direction(start + width * k / columns, low + (high - low) * r / rings));
      }
    }
    SCOPED_TRACE(testing::Message() << start << " + " << width << ", " << low << " to " << high);
    expectHeld(directions);
    if (testing::Test::HasFatalFailure()) return;
  }
}

TEST(CameraLayout, AutoHoldsWhatHasNoAzimuth) {
  expectHeld({{0, 0, 1}});
  expectHeld({{0, 0, -1}, {1, 0, 0}});
  expectHeld({{0, 0, 1}, {0, 0, -1}});
  expectHeld({{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}});
  EXPECT_TRUE(layOutCameras({}, {}).empty());
}

TEST(CameraLayout, AutoHoldsTheWholeSphere) {
  std::vector<Vec3d> directions;
  for (int e = -90; e <= 90; e += 3) {
    for (int a = 0; a < 360; a += 3) directions.push_back(direction(a, e));
  }
  expectHeld(directions);
}

TEST(CameraLayout, AFewColumnsTakeOneSmallImage) {
  std::vector<Vec3d> directions;
  for (int e = -25; e <= 2; ++e) {
    for (int k = 0; k < 20; ++k) directions.push_back(direction(178 + 0.2 * k, e));
  }
  const std::vector<Camera> cameras = layOutCameras(directions, {CameraLayout::Auto, 2048});
  ASSERT_EQ(cameras.size(), 1u);
  // 4 x 27 degrees of 1024 pixels a radian: 72 x 483.
  EXPECT_LT(cameras[0].width, 90u);
  EXPECT_LT(cameras[0].height, 560u);
}

TEST(CameraLayout, ThreeSquaresReach41DegreesAtTheirSeams) {
  std::vector<Vec3d> revolution;
  for (int a = 0; a < 360; ++a) revolution.push_back(direction(a, 0));
  const std::vector<Camera> cameras = layOutCameras(revolution, {CameraLayout::Three120, 1024});
  ASSERT_EQ(cameras.size(), 3u);
  // At azimuth a off the axis, an image whose edge is at tan(60) sees up to atan(tan(60) cos(a)).
  const double seam = degrees(std::atan(std::tan(radians(60.0)) * std::cos(radians(60.0))));
  EXPECT_NEAR(seam, 40.9, 0.05);
  for (const double azimuth : {60.0, 180.0, 300.0}) {
    for (const double sign : {-1.0, 1.0}) {
      EXPECT_GT(inside(cameras, direction(azimuth, sign * (seam - 0.01))), -1e-6);
      EXPECT_LT(inside(cameras, direction(azimuth, sign * (seam + 0.01))), -1e-3);
    }
  }
  EXPECT_GT(inside(cameras, direction(120, 59.99)), 0);
}

TEST(CameraLayout, FixedOnesLeaveOutWhatNobodyLooksThrough) {
  std::vector<Vec3d> revolution;
  for (int a = 0; a < 360; ++a) revolution.push_back(direction(a, 5));
  EXPECT_EQ(layOutCameras(revolution, {CameraLayout::Four90, 256}).size(), 4u);
  EXPECT_EQ(layOutCameras(revolution, {CameraLayout::Cube6, 256}).size(), 4u) << "nobody looks up or down";
  revolution.push_back(direction(0, 80));
  EXPECT_EQ(layOutCameras(revolution, {CameraLayout::Cube6, 256}).size(), 5u);
  EXPECT_EQ(layOutCameras(revolution, {CameraLayout::Four90, 256}).size(), 4u);
  const std::vector<Vec3d> ahead = {direction(10, 0), direction(-10, 3)};
  EXPECT_EQ(layOutCameras(ahead, {CameraLayout::Three120, 256}).size(), 1u);
  EXPECT_EQ(layOutCameras(ahead, {CameraLayout::Three120, 256}).front().name, "front");
  const std::vector<Vec3d> above = {direction(0, 85)};
  EXPECT_TRUE(layOutCameras(above, {CameraLayout::Three120, 256}).empty());
}

}  // namespace
}  // namespace scanmill
