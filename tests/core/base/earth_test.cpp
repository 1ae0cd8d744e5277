#include "base/earth.h"

namespace scanmill {
namespace {

// The ellipsoid has two of them.
TEST(Earth, PlacesOnTheAxesAreItsRadii) {
  EXPECT_LT(length(earthCentred(0, 0, 0) - Vec3d{6378137, 0, 0}), 1e-6);
  EXPECT_LT(length(earthCentred(kPi / 2, 0, 100) - Vec3d{0, 6378237, 0}), 1e-6);
  EXPECT_LT(length(earthCentred(1, kPi / 2, 0) - Vec3d{0, 0, 6356752.314245}), 1e-5);
}

TEST(Earth, EastNorthAndUpAreThoseOfSmallSteps) {
  for (const double longitude : {-3.0, -0.3, 0.0, 1.2, 2.9}) {
    for (const double latitude : {-1.5, -0.7, 0.0, 0.4, 1.1, 1.55}) {
      for (const double height : {-100.0, 0.0, 5000.0}) {
        const Affine local = eastNorthUp(earthCentred(longitude, latitude, height));
        EXPECT_LT(length(local * earthCentred(longitude, latitude, height)), 1e-6);
        EXPECT_LT(length(local * earthCentred(longitude, latitude, height + 50) - Vec3d{0, 0, 50}), 1e-6);
        const Vec3d east = local * earthCentred(longitude + 1e-7, latitude, height);
        const Vec3d north = local * earthCentred(longitude, latitude + 1e-7, height);
        EXPECT_GT(normalized(east).x, 1 - 1e-6) << longitude << " " << latitude;
        EXPECT_GT(normalized(north).y, 1 - 1e-6) << longitude << " " << latitude;
        EXPECT_NEAR(determinant(local.linear), 1, 1e-12);
      }
    }
  }
}

TEST(Earth, TellsWhatIsNearItsSurface) {
  EXPECT_TRUE(isOnEarth(earthCentred(1, 1, 8000)));
  EXPECT_FALSE(isOnEarth({100, 200, 10}));
  EXPECT_FALSE(isOnEarth({4e7, 0, 0}));
}

}  // namespace
}  // namespace scanmill
