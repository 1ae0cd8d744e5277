#include "viewer/window/picking.h"

#include <limits>
#include <random>

#include "base/parallel.h"
#include "tests/core/sense/several_returns.h"
#include "tests/studio/viewer/window/session_world.h"
#include "viewer/window/orbit_camera.h"

namespace scanmill {
namespace {

constexpr int kWidth = 400;
constexpr int kHeight = 300;
constexpr double kSize = 3;
constexpr double kReach = 8;

struct Cloud {
  std::vector<Vec3f> positions;
  std::vector<std::uint8_t> shown;
  Affine canvasFromItem;
  PickCloud view() const { return {positions, shown, canvasFromItem}; }
};

Cloud randomCloud(std::mt19937& random, std::size_t count) {
  std::uniform_real_distribution<float> place(-20, 20);
  Cloud cloud;
  for (std::size_t i = 0; i < count; ++i) cloud.positions.push_back({place(random), place(random), place(random) / 5});
  cloud.canvasFromItem = toAffine(Pose{fromYawPitchRoll(0.3, 0.1, -0.2), {1, 2, 3}});
  return cloud;
}

OrbitCamera randomView(std::mt19937& random) {
  std::uniform_real_distribution<double> unit(-1, 1);
  return {.yaw = kPi * unit(random),
          .pitch = unit(random),
          .distance = 15 + 10 * unit(random),
          .orthographic = unit(random) > 0.5};
}

// A visible point's own pixel gives it, or a nearer one whose square covers that pixel too.
TEST(Picking, APixelGivesThePointThatIsSeenThere) {
  std::mt19937 random(1);
  for (int round = 0; round < 20; ++round) {
    const Cloud cloud = randomCloud(random, 5000);
    const ViewCamera camera = randomView(random).camera(kWidth, kHeight);
    const PickCloud clouds[] = {cloud.view()};
    for (std::size_t i = 0; i < cloud.positions.size(); i += 37) {
      const Projected own = camera.project(cloud.canvasFromItem * Vec3d(cloud.positions[i]));
      if (own.depth < camera.nearest * 1.001 || own.x < 0 || own.y < 0 || own.x > kWidth || own.y > kHeight) continue;
      const double x = std::floor(own.x) + 0.5;
      const double y = std::floor(own.y) + 0.5;
      const auto hit = pickPoint(clouds, camera, x, y, kSize, kReach);
      ASSERT_TRUE(hit);
      if (hit->point == i) continue;
      const Projected other = camera.project(cloud.canvasFromItem * Vec3d(cloud.positions[hit->point]));
      EXPECT_LE(other.depth, own.depth + 1e-4);
      EXPECT_LE(std::abs(other.x - x), kSize / 2 + 0.51);
      EXPECT_LE(std::abs(other.y - y), kSize / 2 + 0.51);
    }
  }
}

TEST(Picking, BesideAllPointsItIsTheNearestWithinReach) {
  std::mt19937 random(2);
  std::uniform_real_distribution<double> unit(0, 1);
  int some = 0;
  int none = 0;
  for (int round = 0; round < 300; ++round) {
    const Cloud cloud = randomCloud(random, 300);
    const ViewCamera camera = randomView(random).camera(kWidth, kHeight);
    const PickCloud clouds[] = {cloud.view()};
    const double x = kWidth * unit(random);
    const double y = kHeight * unit(random);
    double least = std::numeric_limits<double>::infinity();
    bool covered = false;
    for (const Vec3f& p : cloud.positions) {
      const Projected at = camera.project(cloud.canvasFromItem * Vec3d(p));
      if (at.depth < camera.nearest) continue;
      const double dx = std::abs(at.x - x);
      const double dy = std::abs(at.y - y);
      covered = covered || std::max(dx, dy) <= kSize / 2 + 0.5;
      least = std::min(least, std::hypot(dx, dy));
    }
    if (covered || std::abs(least - kReach) < 0.01) continue;
    const auto hit = pickPoint(clouds, camera, x, y, kSize, kReach);
    ASSERT_EQ(hit.has_value(), least < kReach) << least;
    if (hit) {
      EXPECT_NEAR(hit->distance, least, 0.01);
    }
    ++(hit ? some : none);
  }
  EXPECT_GT(some, 10);
  EXPECT_GT(none, 10);
}

TEST(Picking, HiddenAndMissingPointsAreNeverPicked) {
  std::mt19937 random(3);
  Cloud cloud = randomCloud(random, 20000);
  cloud.shown.assign(cloud.positions.size(), 1);
  for (std::size_t i = 0; i < cloud.positions.size(); i += 2) cloud.shown[i] = 0;
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  for (std::size_t i = 1; i < cloud.positions.size(); i += 4) cloud.positions[i] = {kNan, kNan, kNan};
  const ViewCamera camera = OrbitCamera{}.camera(kWidth, kHeight);
  const PickCloud clouds[] = {cloud.view()};
  int hits = 0;
  for (int x = 0; x < kWidth; x += 9) {
    for (int y = 0; y < kHeight; y += 9) {
      const auto hit = pickPoint(clouds, camera, x, y, kSize, kReach);
      if (!hit) continue;
      ++hits;
      EXPECT_EQ(hit->point % 4, 3u);
    }
  }
  EXPECT_GT(hits, 100);
}

TEST(Picking, TheSameWithAnyNumberOfThreads) {
  std::mt19937 random(4);
  Cloud cloud = randomCloud(random, 300000);
  const std::size_t half = cloud.positions.size() / 2;
  for (std::size_t i = 0; i < half; ++i) cloud.positions[half + i] = cloud.positions[i];  // ties
  const ViewCamera camera = OrbitCamera{}.camera(kWidth, kHeight);
  const PickCloud clouds[] = {cloud.view(), cloud.view()};
  for (int x = 5; x < kWidth; x += 40) {
    std::optional<PointHit> alone;
    {
      const ThreadLimit one(1);
      alone = pickPoint(clouds, camera, x, 150, kSize, kReach);
    }
    for (int repeat = 0; repeat < 3; ++repeat) {
      const auto together = pickPoint(clouds, camera, x, 150, kSize, kReach);
      ASSERT_EQ(alone.has_value(), together.has_value());
      if (!alone) continue;
      EXPECT_EQ(alone->cloud, 0u);
      EXPECT_EQ(together->cloud, 0u);
      EXPECT_EQ(alone->point, together->point);
      EXPECT_LT(alone->point, half);
    }
  }
}

TEST(Picking, TheLineOfSightMeetsWhatIsSeen) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> unit(0, 1);
  for (int i = 0; i < 100; ++i) {
    const ViewCamera camera = randomView(random).camera(kWidth, kHeight);
    const double x = kWidth * unit(random);
    const double y = kHeight * unit(random);
    const SightLine line = sightLine(camera, x, y);
    EXPECT_NEAR(length(line.direction), 1, 1e-12);
    const Projected p = camera.project(line.origin + line.direction * 12.0);
    EXPECT_NEAR(p.x, x, 1e-6);
    EXPECT_NEAR(p.y, y, 1e-6);
    EXPECT_GT(p.depth, 0);
  }
}

ViewScan viewOf(Scan scan, const std::string& name) {
  ViewScan view;
  view.name = name;
  view.scan = std::move(scan);
  return view;
}

std::size_t pointWith(const Scan& scan, const PointKey& key) {
  for (std::size_t i = 0; i < scan.size(); ++i) {
    if (keyOf(scan, i) == key && isFinite(scan.position[i])) return i;
  }
  throw std::runtime_error("no such point");
}

// The scan has 9 columns: beam 11 (ring 1, column 2) has two returns, beam 10 one, beam 9 none.
class ReturnRows : public testing::Test {
 protected:
  World world_ = makeSeveralReturns(4, 9);
  ViewScan dense_ = viewOf(senseOnce(world_, {}, {ColumnSet::all(), false}), "dense");
  ViewScan image_ = viewOf(senseOnce(world_, {}, {ColumnSet(kLabel), true}), "image");
};

TEST_F(ReturnRows, TellWhichOneItIs) {
  for (const ViewScan* view : {&dense_, &image_}) {
    for (const std::uint32_t number : {0u, 1u}) {
      const PickedElement picked = describePoint(*view, 0, pointWith(view->scan, {1, 2, number}), nullptr);
      EXPECT_EQ(rowOf(picked, "return"), std::to_string(number + 1)) << view->name;
      EXPECT_EQ(rowOf(picked, "ring"), "1");
      EXPECT_EQ(rowOf(picked, "column"), "2");
      EXPECT_EQ(rowOf(picked, "range"), number == 0 ? "10.000 m" : "15.000 m");
    }
  }
  EXPECT_EQ(rowOf(describePoint(dense_, 0, 0, nullptr), "cause"), "1");
}

TEST_F(ReturnRows, JoinByBeamAndReturn) {
  const auto ofOther = [](const ViewScan& own, const ViewScan& other, const PointKey& key) {
    PickedElement picked = describePoint(own, 0, pointWith(own.scan, key), nullptr);
    addSameBeam(picked, own.scan, other, nullptr);
    return rowOf(picked, other.name);
  };
  EXPECT_EQ(ofOther(dense_, image_, {1, 2, 0}), "10.00 m, class 1");
  EXPECT_EQ(ofOther(dense_, image_, {1, 2, 1}), "15.00 m, class 2");
  EXPECT_EQ(ofOther(image_, dense_, {1, 2, 1}), "15.00 m, class 2");
  EXPECT_EQ(ofOther(image_, dense_, {1, 1, 0}), "10.00 m, class 1");
  const ViewScan single = viewOf(senseOnce(makeWorld(4, 9, 12), {}, {ColumnSet(kRing, kColumn), false}), "single");
  EXPECT_EQ(ofOther(dense_, single, {1, 2, 0}), "12.00 m");
  EXPECT_EQ(ofOther(dense_, single, {1, 2, 1}), "no return");
}

}  // namespace
}  // namespace scanmill
