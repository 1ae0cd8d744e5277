#include "viewer/window/session_context.h"

#include <random>

#include "tests/studio/viewer/window/fake_frames.h"
#include "tests/support/message_of.h"

namespace scanmill {
namespace {

// Points on the walls of a box that is turned about the vertical, among others.
struct BoxScan {
  Scan scan;
  std::size_t own = 0;

  BoxScan(double length, double width, double height, double yaw) {
    std::mt19937 random(3);
    std::uniform_real_distribution<double> unit(-0.5, 0.5);
    const Affine placed = toAffine(Pose{fromYawPitchRoll(yaw, 0, 0), {12, -7, 1}});
    const auto add = [&](const Vec3d& p, std::uint32_t instance, std::uint16_t label) {
      scan.position.push_back(Vec3f(p));
      scan[kInstance].push_back(instance);
      scan[kLabel].push_back(label);
      own += instance == 7 ? 1 : 0;
    };
    for (int corner = 0; corner < 8; ++corner) {
      add(placed * Vec3d{(corner & 1 ? 0.5 : -0.5) * length, (corner & 2 ? 0.5 : -0.5) * width,
                         (corner & 4 ? 0.5 : -0.5) * height},
          7, 3);
    }
    for (int i = 0; i < 500; ++i) {
      add(placed * Vec3d{unit(random) * length, unit(random) * width, unit(random) * height}, 7, i < 20 ? 5 : 3);
      add({100 * unit(random), 100 * unit(random), 100 * unit(random)}, 8, 3);
    }
    add({NAN, 0, 0}, 7, 3);
    --own;
  }
};

TEST(InstanceSummary, ABoxHasItsSizeHoweverItIsTurned) {
  for (const double yaw : {0.0, 0.3, 1.2, 2.5, -3.0}) {
    for (const auto& [length, width] : {std::pair(4.5, 1.8), {2.0, 1.9}, {12.0, 0.5}}) {
      const BoxScan box(length, width, 1.5, yaw);
      const InstanceSummary summary = summarizeInstances(box.scan, box.scan.position, {}, 7).front();
      EXPECT_NEAR(summary.size.x, length, 1e-4);
      EXPECT_NEAR(summary.size.y, width, 1e-4);
      EXPECT_NEAR(summary.size.z, 1.5, 1e-4);
      EXPECT_EQ(summary.points.size(), box.own);
      for (const std::uint32_t i : summary.points) {
        const Vec3d p = inverse(summary.levelFromBox) * Vec3d(box.scan.position[i]);
        EXPECT_LE(std::abs(p.x), length / 2 + 1e-4);
        EXPECT_LE(std::abs(p.y), width / 2 + 1e-4);
        EXPECT_LE(std::abs(p.z), 0.75 + 1e-4);
      }
      ASSERT_EQ(summary.classes.size(), 2u);
      EXPECT_EQ(summary.classes[0], (std::pair<std::uint16_t, std::uint64_t>(3, 488)));
      EXPECT_EQ(summary.classes[1], (std::pair<std::uint16_t, std::uint64_t>(5, 20)));
    }
  }
}

TEST(InstanceSummary, AllAtOnceAreAsOneByOne) {
  const BoxScan box(4.5, 1.8, 1.5, 0.4);
  const auto all = summarizeInstances(box.scan, box.scan.position, {});
  ASSERT_EQ(all.size(), 2u);
  for (const InstanceSummary& one : all) {
    const InstanceSummary alone = summarizeInstances(box.scan, box.scan.position, {}, one.id).front();
    EXPECT_EQ(one.points, alone.points);
    EXPECT_EQ(one.classes, alone.classes);
    EXPECT_EQ(one.size, alone.size);
  }
}

// A sensor that is mounted askew says the same once it is turned upright.
TEST(InstanceSummary, IsMeasuredUpright) {
  BoxScan box(4.5, 1.8, 1.5, 0.4);
  const Affine levelFromScan = toAffine(Pose{fromYawPitchRoll(0.2, 0.5, -0.3), {0, 0, 2}});
  const Affine scanFromLevel = inverse(levelFromScan);
  for (Vec3f& p : box.scan.position) p = Vec3f(scanFromLevel * Vec3d(p));
  const Vec3d size = summarizeInstances(box.scan, box.scan.position, levelFromScan, 7).front().size;
  EXPECT_NEAR(length(size - Vec3d{4.5, 1.8, 1.5}), 0, 1e-4);
}

TEST(InstanceSummary, FewPointsHaveFlatBoxes) {
  Scan scan;
  EXPECT_TRUE(summarizeInstances(scan, scan.position, {}).empty());
  scan[kInstance] = {1, 1, 1, 2};
  scan.position = {{0, 0, 0}, {3, 4, 0}, {1.5, 2, 0}, {9, 9, 9}};
  InstanceSummary line = summarizeInstances(scan, scan.position, {}, 1).front();
  EXPECT_NEAR(length(line.size - Vec3d{5, 0, 0}), 0, 1e-6);
  EXPECT_TRUE(line.classes.empty());
  EXPECT_EQ(summarizeInstances(scan, scan.position, {}, 2).front().size, (Vec3d{0, 0, 0}));
}

TEST(ClassFilter, HidesOrShowsAlone) {
  const Ontology ontology = fakeOntology();
  const ClassFilter hidden({"road", "20"}, false, &ontology);
  EXPECT_FALSE(hidden.shows(kFakeRoad));
  EXPECT_FALSE(hidden.shows(kFakeCar));
  EXPECT_TRUE(hidden.shows(kFakeTree));
  EXPECT_EQ(hidden.text(&ontology), "without road, car");
  const ClassFilter alone({"road", "20"}, true, &ontology);
  for (std::uint32_t id = 0; id <= UINT16_MAX; ++id) {
    const auto c = static_cast<std::uint16_t>(id);
    EXPECT_NE(hidden.shows(c), alone.shows(c));
  }
  EXPECT_EQ(alone.text(nullptr), "only class 1, class 20");
}

TEST(ClassFilter, TogglingTwiceChangesNothing) {
  ClassFilter filter;
  EXPECT_TRUE(filter.showsAll());
  filter.toggle(7);
  EXPECT_FALSE(filter.shows(7));
  filter.toggle(7);
  EXPECT_TRUE(filter.showsAll());
  filter.showOnly(7);
  EXPECT_TRUE(filter.shows(7));
  EXPECT_FALSE(filter.shows(8));
  filter.toggle(8);
  EXPECT_TRUE(filter.shows(8));
  filter.toggle(8);
  filter.toggle(7);
  EXPECT_EQ(filter.text(nullptr), "all classes hidden");
}

TEST(ClassFilter, UnknownNamesAreRefused) {
  const Ontology ontology = fakeOntology();
  EXPECT_THAT(messageOf([&] { ClassFilter({"raod"}, false, &ontology); }), testing::HasSubstr("road"));
  EXPECT_THAT(messageOf([] { ClassFilter({"road"}, false, nullptr); }), testing::HasSubstr("--ontology"));
  EXPECT_NO_THROW(ClassFilter({"4711"}, false, nullptr));
}

}  // namespace
}  // namespace scanmill
