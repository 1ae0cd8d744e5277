#include "passes/pass_image.h"
#include "tests/support/message_of.h"

namespace scanmill {
namespace {

TEST(Camera, AFieldIsWhatItsEdgesSpan) {
  for (const double field : {1.0, 10.0, 60.0, 90.0, 120.0, 170.0, 179.0}) {
    const Camera camera = squareCamera(640, 320, radians(field));
    EXPECT_NEAR(degrees(camera.horizontalField()), field, 1e-9);
    EXPECT_EQ(camera.fx, camera.fy);
    const Vec3d left = normalized(camera.ray(0, 160));
    const Vec3d right = normalized(camera.ray(640, 160));
    EXPECT_NEAR(degrees(std::acos(dot(left, right))), field, 1e-6);
    EXPECT_LT(camera.verticalField(), camera.horizontalField());
  }
}

TEST(Camera, AnOffCentreFieldIsTheSumOfItsSides) {
  Camera camera = squareCamera(100, 100, radians(90));
  camera.cx = 0;
  EXPECT_NEAR(camera.horizontalField(), std::atan(2.0), 1e-12);
  camera.cx = -50;  // the axis lies outside of the image
  EXPECT_NEAR(camera.horizontalField(), std::atan(3.0) - std::atan(1.0), 1e-12);
}

TEST(Camera, TheRayOfAProjectedPointLeadsToIt) {
  Camera camera = squareCamera(1000, 700, radians(75));
  camera.cx = 321.5;
  camera.cy = 800.25;
  const Vec3d point{-3.5, 2.25, 17};
  const double u = camera.cx + camera.fx * point.x / point.z;
  const double v = camera.cy + camera.fy * point.y / point.z;
  EXPECT_LT(length(camera.ray(u, v) * point.z - point), 1e-12);
}

TEST(Camera, OpticalAxesInTheVehicle) {
  const Mat3 turn = toMatrix(vehicleFromOptical());
  EXPECT_LT(length(turn.z - Vec3d{1, 0, 0}), 1e-15);   // looks forward
  EXPECT_LT(length(turn.x - Vec3d{0, -1, 0}), 1e-15);  // right
  EXPECT_LT(length(turn.y - Vec3d{0, 0, -1}), 1e-15);  // down
  EXPECT_NEAR(determinant(turn), 1, 1e-15);
}

}  // namespace
}  // namespace scanmill
