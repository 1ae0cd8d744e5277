#include "base/vec.h"

#include "base/random.h"

namespace scanmill {
namespace {

// Numbers in (-1, 1) by address.
double symmetric(std::uint32_t beam, std::uint32_t frame) {
  return 2 * uniform(randomBlock({.seed = 11, .frame = frame, .beam = beam})[0]) - 1;
}

Vec3d randomVector(std::uint32_t i) {
  return {symmetric(i, 0), symmetric(i, 1), symmetric(i, 2)};
}

Quat randomRotation(std::uint32_t i) {
  const Quat q{symmetric(i, 3), symmetric(i, 4), symmetric(i, 5), symmetric(i, 6)};
  const double n = std::sqrt(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z);
  return {q.w / n, q.x / n, q.y / n, q.z / n};
}

Pose randomPose(std::uint32_t i) {
  return {randomRotation(i), randomVector(i + 1000) * 50.0};
}

void expectNear(const Vec3d& a, const Vec3d& b, double tolerance = 1e-12) {
  EXPECT_NEAR(a.x, b.x, tolerance);
  EXPECT_NEAR(a.y, b.y, tolerance);
  EXPECT_NEAR(a.z, b.z, tolerance);
}

double dot4(const Quat& a, const Quat& b) {
  return a.w * b.w + a.x * b.x + a.y * b.y + a.z * b.z;
}

TEST(Vec3, CrossIsOrthogonalAndRightHanded) {
  EXPECT_EQ(cross(Vec3d{1, 0, 0}, Vec3d{0, 1, 0}), (Vec3d{0, 0, 1}));
  for (std::uint32_t i = 0; i < 100; ++i) {
    const Vec3d a = randomVector(i);
    const Vec3d b = randomVector(i + 500);
    EXPECT_NEAR(dot(cross(a, b), a), 0, 1e-14);
    EXPECT_NEAR(dot(cross(a, b), b), 0, 1e-14);
    // Lagrange's identity.
    EXPECT_NEAR(dot(cross(a, b), cross(a, b)), dot(a, a) * dot(b, b) - dot(a, b) * dot(a, b), 1e-14);
  }
}

TEST(Vec3, NormalizedHasLengthOneAndZeroStaysZero) {
  EXPECT_NEAR(length(normalized(Vec3d{3, -4, 12})), 1, 1e-15);
  EXPECT_EQ(normalized(Vec3d{}), Vec3d{});
  EXPECT_TRUE(isFinite(Vec3d{1, 2, 3}));
  EXPECT_FALSE(isFinite(Vec3d{1, NAN, 3}));
  EXPECT_FALSE(isFinite(Vec3f{1, 2, -INFINITY}));
}

TEST(Mat3, InverseUndoes) {
  for (std::uint32_t i = 0; i < 100; ++i) {
    const Mat3 m{randomVector(i), randomVector(i + 200), randomVector(i + 400)};
    if (std::fabs(determinant(m)) < 0.05) continue;
    const Mat3 identity = m * inverse(m);
    expectNear(identity.x, {1, 0, 0});
    expectNear(identity.y, {0, 1, 0});
    expectNear(identity.z, {0, 0, 1});
    EXPECT_NEAR(determinant(m) * determinant(inverse(m)), 1, 1e-12);
    EXPECT_EQ(transposed(transposed(m)), m);
    EXPECT_NEAR(determinant(transposed(m)), determinant(m), 1e-14);
  }
}

TEST(Affine, ComposesAndInverts) {
  for (std::uint32_t i = 0; i < 50; ++i) {
    const Affine a = toAffine(randomPose(i)) * Affine{Mat3::scale({2, 0.5, -3}), randomVector(i)};
    const Affine b = toAffine(randomPose(i + 77));
    const Vec3d p = randomVector(i + 300) * 10.0;
    expectNear((a * b) * p, a * (b * p), 1e-10);
    expectNear(inverse(a) * (a * p), p, 1e-10);
  }
}

TEST(Quat, MatricesAreRotations) {
  for (std::uint32_t i = 0; i < 100; ++i) {
    const Mat3 m = toMatrix(randomRotation(i));
    EXPECT_NEAR(determinant(m), 1, 1e-14);
    const Mat3 identity = transposed(m) * m;
    expectNear(identity.x, {1, 0, 0}, 1e-14);
    expectNear(identity.y, {0, 1, 0}, 1e-14);
    expectNear(identity.z, {0, 0, 1}, 1e-14);
  }
}

TEST(Quat, ProductIsTheMatrixProduct) {
  for (std::uint32_t i = 0; i < 100; ++i) {
    const Quat a = randomRotation(i);
    const Quat b = randomRotation(i + 100);
    const Vec3d p = randomVector(i);
    expectNear(toMatrix(a * b) * p, toMatrix(a) * (toMatrix(b) * p), 1e-14);
  }
}

TEST(Quat, YawPitchRollFollowsRep103) {
  const Vec3d forward{1, 0, 0};
  const Vec3d left{0, 1, 0};
  const Vec3d up{0, 0, 1};
  expectNear(toMatrix(fromYawPitchRoll(kPi / 2, 0, 0)) * forward, left);
  expectNear(toMatrix(fromYawPitchRoll(0, kPi / 2, 0)) * forward, -up);
  expectNear(toMatrix(fromYawPitchRoll(0, 0, kPi / 2)) * left, up);
  // Rz * Ry * Rx: roll first, then pitch, then yaw.
  const Quat together = fromYawPitchRoll(0.3, -0.7, 1.1);
  const Quat oneByOne = fromYawPitchRoll(0.3, 0, 0) * fromYawPitchRoll(0, -0.7, 0) * fromYawPitchRoll(0, 0, 1.1);
  EXPECT_NEAR(std::fabs(dot4(together, oneByOne)), 1, 1e-15);
}

TEST(Slerp, TurnsAtConstantSpeed) {
  for (const double total : {1e-9, 1e-4, 0.02, 0.06, 0.0633, 0.5, 2.0, 3.1}) {
    const Quat end = fromYawPitchRoll(total, 0, 0);
    for (int k = 0; k <= 20; ++k) {
      const Quat q = slerp({}, end, k / 20.0);
      EXPECT_NEAR(2 * std::atan2(q.z, q.w), total * k / 20.0, 2e-6) << total;
    }
  }
}

TEST(Slerp, TakesTheShortArcWhateverTheSigns) {
  for (std::uint32_t i = 0; i < 100; ++i) {
    const Quat a = randomRotation(i);
    const Quat b = randomRotation(i + 100);
    const Quat middle = slerp(a, b, 0.5);
    const Quat other = slerp(a, {-b.w, -b.x, -b.y, -b.z}, 0.5);
    EXPECT_NEAR(std::fabs(dot4(middle, other)), 1, 1e-12);
    EXPECT_NEAR(std::fabs(dot4(a, middle)), std::fabs(dot4(middle, b)), 1e-12);
    EXPECT_GE(std::fabs(dot4(a, middle)), std::sqrt(0.5) - 1e-12);
    EXPECT_NEAR(std::fabs(dot4(slerp(b, a, 0.3), slerp(a, b, 0.7))), 1, 1e-12);
  }
}

TEST(Pose, ComposesInvertsAndKeepsDistances) {
  for (std::uint32_t i = 0; i < 100; ++i) {
    const Pose a = randomPose(i);
    const Pose b = randomPose(i + 200);
    const Vec3d p = randomVector(i) * 20.0;
    const Vec3d q = randomVector(i + 50) * 20.0;
    expectNear((a * b) * p, a * (b * p), 1e-11);
    expectNear(inverse(a) * (a * p), p, 1e-11);
    expectNear((inverse(a * b)) * p, (inverse(b) * inverse(a)) * p, 1e-11);
    expectNear(toAffine(a) * p, a * p, 1e-13);
    EXPECT_NEAR(length(a * p - a * q), length(p - q), 1e-11);
  }
}

TEST(Pose, InterpolationMovesOnALine) {
  const Pose a = randomPose(3);
  const Pose b = randomPose(4);
  expectNear(interpolate(a, b, 0).translation, a.translation);
  expectNear(interpolate(a, b, 1).translation, b.translation);
  expectNear(interpolate(a, b, 0.25).translation, a.translation * 0.75 + b.translation * 0.25, 1e-11);
}

TEST(Box, GrowsAroundWhatItHolds) {
  Box box;
  EXPECT_TRUE(box.empty());
  box.add(Box{});
  EXPECT_TRUE(box.empty());
  box.add(Vec3d{1, 2, 3});
  EXPECT_FALSE(box.empty());
  EXPECT_EQ(box.low, box.high);
  box.add(Vec3d{-1, 5, 3});
  EXPECT_EQ(box.low, (Vec3d{-1, 2, 3}));
  EXPECT_EQ(box.high, (Vec3d{1, 5, 3}));
  EXPECT_EQ(box.center(), (Vec3d{0, 3.5, 3}));
  Box other;
  other.add(Vec3d{0, 0, 9});
  other.add(box);
  EXPECT_EQ(other.low, (Vec3d{-1, 0, 3}));
  EXPECT_EQ(other.high, (Vec3d{1, 5, 9}));
}

TEST(Angles, DegreesAndRadiansAreInverse) {
  EXPECT_DOUBLE_EQ(radians(180), kPi);
  for (const double angle : {-720.0, -0.1, 0.0, 26.8, 359.99}) EXPECT_NEAR(degrees(radians(angle)), angle, 1e-12);
}

}  // namespace
}  // namespace scanmill
