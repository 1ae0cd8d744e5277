// The depth camera and particles against ray tracing: the same beams on the procedural street, as in the tables of
// docs/depth_camera.md and docs/particle.md.

#include "tests/support/street.h"

#include "evaluate/measure.h"
#include "tests/core/methods/trace.h"
#include "tests/support/gl.h"

namespace scanmill {
namespace {

class Street : public testing::Test {
 protected:
  static void SetUpTestSuite() { scene_ = std::make_unique<Scene>(proceduralStreet()); }
  static void TearDownTestSuite() { scene_.reset(); }

  // Returns the exact hits from a place on the street; compared() measures a method against them.
  static std::vector<TrueShot> truthAt(double x) {
    return trueShots(*scene_, {streetShot(presetBeams("paper_64"), x)}, {});
  }
  static Measurement compared(const std::vector<TrueShot>& truth, const char* method, const std::string& options) {
    return measure([&] { return methodOf(method, *scene_, options); }, *scene_, truth, {.repeats = 0});
  }
  static const GroupErrors& interiorOf(const Measurement& m) { return m.errors.byEdge.front().errors; }

  static std::unique_ptr<Scene> scene_;
};

std::unique_ptr<Scene> Street::scene_;

// The depth camera's images need OpenGL.
class StreetInImages : public Street {
 protected:
  void SetUp() override { SKIP_WITHOUT_GL(); }
};

// Bounds away from edges, as the tables say; also where the trees are nearest, with the default layout.
TEST_F(StreetInImages, PlaneSamplingIsAsGoodAsTheTableSays) {
  for (const auto& [x, options] : {std::pair{-20.0, "{layout: three_120, resolution: 2048}"}, {3.0, "{}"}}) {
    const Measurement m = compared(truthAt(x), "depth_camera", options);
    const GroupErrors& e = interiorOf(m);
    EXPECT_GT(m.errors.all.bothHit, 90'000u);
    EXPECT_GT(e.beams, 60'000u);
    EXPECT_LT(e.range.median, 1e-3);
    EXPECT_LT(e.range.p99, 0.05);
    EXPECT_GT(static_cast<double>(e.bothMiss + e.sameLabel), 0.995 * static_cast<double>(e.beams));
    EXPECT_LT(m.errors.all.nearestTo.mean, 0.01);
    EXPECT_LT(m.errors.all.nearestFrom.mean, 0.01);
  }
}

// Samplings err in the order in which they simplify, and finer images err less.
TEST_F(StreetInImages, WhatIsSimplerErrsMore) {
  const std::vector<TrueShot> truth = truthAt(12);
  const auto median = [&](const std::string& options) {
    return interiorOf(compared(truth, "depth_camera", "{layout: three_120, " + options + "}")).range.median;
  };
  const double nearest = median("resolution: 1024, sampling: nearest");
  EXPECT_LT(10 * median("resolution: 1024"), nearest);
  EXPECT_LT(1.5 * median("resolution: 2048, sampling: nearest"), nearest);
  EXPECT_GT(median("resolution: 1024, depth: half_500"), 0.02);  // steps of 0.25 to 0.5 m
}

TEST_F(Street, ParticlesThatMeetTrianglesSeeWhatRaysSee) {
  for (const double x : {-20.0, 3.0}) {
    const Measurement m = compared(truthAt(x), "particle", "{backend: cpu, refine: triangle}");
    const GroupErrors& e = m.errors.all;
    EXPECT_GT(e.bothHit, 90'000u);
    EXPECT_LT(e.falseNegatives + e.falsePositives, e.beams / 10'000);
    EXPECT_GT(static_cast<double>(e.sameLabel), 0.9999 * static_cast<double>(e.bothHit));
    EXPECT_LT(e.range.p999, 1e-4);
    EXPECT_LT(m.errors.all.nearestTo.mean, 1e-3);
    EXPECT_LT(m.errors.all.nearestFrom.mean, 1e-3);
    EXPECT_EQ(e.unresolved, 0u);
  }
}

TEST_F(Street, ParticlesErrInTheOrderInWhichTheySimplify) {
  const std::vector<TrueShot> truth = truthAt(-20);
  const GroupErrors none = compared(truth, "particle", "{backend: cpu, refine: none}").errors.all;
  const GroupErrors coarse =
      compared(truth, "particle", "{backend: cpu, refine: none, voxel_m: 0.4, voxels: 64}").errors.all;
  EXPECT_LT(none.range.median, 0.1);
  EXPECT_GT(coarse.range.median, 2 * none.range.median);
  // Half a voxel thicker than it is, everything is seen: only beams past silhouettes are false positives.
  EXPECT_LT(none.falseNegatives, none.beams / 1000);
  EXPECT_GT(static_cast<double>(none.sameLabel), 0.85 * static_cast<double>(none.bothHit));
}

}  // namespace
}  // namespace scanmill
