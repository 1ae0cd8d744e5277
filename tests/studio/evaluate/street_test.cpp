// The depth camera and particles against ray tracing: the same beams on the procedural street, as in the tables of
// docs/depth_camera.md and docs/particle.md.

#include "tests/support/street.h"

#include <span>

#include "base/error.h"
#include "evaluate/cloud_errors.h"
#include "evaluate/measure.h"
#include "tests/core/methods/trace.h"

namespace scanmill {
namespace {

struct HitErrors {
  std::uint64_t beams = 0;
  std::uint64_t bothHit = 0;
  std::uint64_t falseNegatives = 0;  // beams that hit only with the reference method
  std::uint64_t falsePositives = 0;  // beams that hit only with the tested method
  std::uint64_t sameLabel = 0;       // beams of bothHit with the same class and instance
  std::uint64_t interior = 0;        // beams that are not near an edge
  // Interior beams that miss with both methods, or hit with the same class and instance.
  std::uint64_t interiorAgree = 0;
  Spread rangeSameSurface;  // |tested - reference range| of beams in bothHit with the same instance and class (m)
  Spread rangeInterior;     // |tested - reference range| of interior beams in bothHit (m)
};

// Compares hits, which must have the channels Range, Instance and Semantic. `edges`: for each beam 1 if it is near an
// edge, as returned by edgeBeams(); if it is empty, all beams are interior. Throws Error if the sizes differ, or if
// beams fire several rays.
HitErrors compareHits(const Hits& reference, const Hits& tested, std::span<const std::uint8_t> edges) {
  if (reference.size() != tested.size() || (!edges.empty() && edges.size() != reference.size())) {
    throw Error("hits of different numbers of beams cannot be compared");
  }
  requireOneRay(reference);
  requireOneRay(tested);
  HitErrors e;
  e.beams = reference.size();
  std::vector<double> same;
  std::vector<double> interior;
  for (std::size_t i = 0; i < reference.size(); ++i) {
    const bool inside = edges.empty() || edges[i] == 0;
    e.interior += inside ? 1 : 0;
    if (!reference.hit(i) || !tested.hit(i)) {
      e.falseNegatives += reference.hit(i) ? 1 : 0;
      e.falsePositives += tested.hit(i) ? 1 : 0;
      e.interiorAgree += inside && reference.hit(i) == tested.hit(i) ? 1 : 0;
      continue;
    }
    ++e.bothHit;
    const double error = std::abs(double{tested.range[i]} - double{reference.range[i]});
    const bool label = reference.semantic[i] == tested.semantic[i] && reference.instance[i] == tested.instance[i];
    if (label) same.push_back(error);
    if (inside) interior.push_back(error);
    e.sameLabel += label ? 1 : 0;
    e.interiorAgree += inside && label ? 1 : 0;
  }
  e.rangeSameSurface = spreadOf(std::move(same));
  e.rangeInterior = spreadOf(std::move(interior));
  return e;
}

// rad, at the centre of an image of 120 degrees and 2048 pixels: 2 tan(60 degrees) / 2048.
constexpr double kPixel = 0.0016915;

class Street : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    scene_ = std::make_unique<Scene>(proceduralStreet());
    tracing_ = rayTracing(*scene_);
  }
  static void TearDownTestSuite() {
    tracing_.reset();
    scene_.reset();
  }

  Hits seen(const Shot& shot, const std::string& options) const {
    const auto method = methodOf("depth_camera", *scene_, options);
    try {
      method->prepare(shot);
    } catch (const InputError&) {
      throw;
    } catch (const Error& e) {
      skipped_ = e.what();  // no OpenGL
      return {};
    }
    return traced(*method, shot);
  }

  static std::unique_ptr<Scene> scene_;
  static std::unique_ptr<Method> tracing_;
  mutable std::string skipped_;
};

std::unique_ptr<Scene> Street::scene_;
std::unique_ptr<Method> Street::tracing_;

TEST_F(Street, PlaneSamplingIsAsGoodAsTheTableSays) {
  const Shot shot = streetShot(presetBeams("paper_64"), -20);
  const Hits tested = seen(shot, "{layout: three_120, resolution: 2048}");
  if (!skipped_.empty()) GTEST_SKIP() << skipped_;
  const Hits truth = traced(*tracing_, shot);
  const HitErrors e = compareHits(truth, tested, edgeBeams(*tracing_, shot, kPixel));
  EXPECT_GT(e.bothHit, 90'000u);
  EXPECT_LT(e.rangeSameSurface.median, 1e-3);
  EXPECT_LT(e.rangeSameSurface.p99, 0.05);
  EXPECT_GT(e.interior, 80'000u);
  EXPECT_GT(static_cast<double>(e.interiorAgree), 0.995 * static_cast<double>(e.interior));
  const CloudErrors clouds = cloudErrors(hitPoints(shot, truth), hitPoints(shot, tested));
  EXPECT_LT(clouds.to.mean, 0.01);
  EXPECT_LT(clouds.from.mean, 0.01);
}

// Where the trees are nearest; the default layout.
TEST_F(Street, TheDefaultHoldsItsBoundsAmongTrees) {
  const Shot shot = streetShot(presetBeams("paper_64"), 3);
  const Hits tested = seen(shot, "{}");
  if (!skipped_.empty()) GTEST_SKIP() << skipped_;
  const Hits truth = traced(*tracing_, shot);
  const HitErrors e = compareHits(truth, tested, edgeBeams(*tracing_, shot, kPixel));
  EXPECT_LT(e.rangeSameSurface.median, 1e-3);
  EXPECT_LT(e.rangeSameSurface.p99, 0.05);
  EXPECT_GT(static_cast<double>(e.interiorAgree), 0.995 * static_cast<double>(e.interior));
}

// Samplings err in the order in which they simplify, and finer images err less.
TEST_F(Street, WhatIsSimplerErrsMore) {
  const Shot shot = streetShot(presetBeams("paper_64"), 12);
  const Hits truth = traced(*tracing_, shot);
  const std::vector<std::uint8_t> edges = edgeBeams(*tracing_, shot, kPixel);
  const auto median = [&](const std::string& options) {
    const Hits tested = seen(shot, options);
    return skipped_.empty() ? compareHits(truth, tested, edges).rangeInterior.median : 0;
  };
  const double plane = median("{layout: three_120, resolution: 1024}");
  if (!skipped_.empty()) GTEST_SKIP() << skipped_;
  const double nearest = median("{layout: three_120, resolution: 1024, sampling: nearest}");
  const double finer = median("{layout: three_120, resolution: 2048, sampling: nearest}");
  const double coarse = median("{layout: three_120, resolution: 1024, depth: half_500}");
  EXPECT_LT(10 * plane, nearest);
  EXPECT_LT(1.5 * finer, nearest);
  EXPECT_GT(coarse, 0.02);  // steps of 0.25 to 0.5 m
}

// The same effect reads the same figures: on flat surfaces intensities are the same.
TEST_F(Street, WhatIntensityIsMadeOfIsTheSameOnFlatSurfaces) {
  const Shot shot = streetShot(presetBeams("paper_64"), -41);
  const Hits tested = seen(shot, "{}");
  if (!skipped_.empty()) GTEST_SKIP() << skipped_;
  const Hits truth = traced(*tracing_, shot);
  std::size_t flat = 0;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    if (!truth.hit(i) || !tested.hit(i) || truth.instance[i] != tested.instance[i]) continue;
    if (truth.primitive[i] != tested.primitive[i] || std::abs(truth.range[i] - tested.range[i]) > 1e-3f) continue;
    ++flat;
    EXPECT_EQ(tested.material[i], truth.material[i]);
    EXPECT_NEAR(tested.incidence[i], truth.incidence[i], 1e-3f) << i;
    EXPECT_NEAR(tested.reflectance[i], truth.reflectance[i], 1e-3f) << i;
  }
  EXPECT_GT(flat, 60'000u);
}

Hits flownOver(const Scene& scene, const Shot& shot, const std::string& options) {
  return traced(*methodOf("particle", scene, "{backend: cpu, " + options + "}"), shot);
}

TEST_F(Street, ParticlesThatMeetTrianglesSeeWhatRaysSee) {
  for (const double x : {-20.0, 3.0}) {
    const Shot shot = streetShot(presetBeams("paper_64"), x);
    const Hits truth = traced(*tracing_, shot);
    const Hits tested = flownOver(*scene_, shot, "refine: triangle");
    const HitErrors e = compareHits(truth, tested, {});
    EXPECT_GT(e.bothHit, 90'000u);
    EXPECT_LT(e.falseNegatives + e.falsePositives, e.beams / 10'000);
    EXPECT_GT(static_cast<double>(e.sameLabel), 0.9999 * static_cast<double>(e.bothHit));
    EXPECT_LT(e.rangeSameSurface.p999, 1e-4);
    const CloudErrors clouds = cloudErrors(hitPoints(shot, truth), hitPoints(shot, tested));
    EXPECT_LT(clouds.to.mean, 1e-3);
    EXPECT_LT(clouds.from.mean, 1e-3);
    EXPECT_TRUE(tested.unresolved.empty());
  }
}

TEST_F(Street, ParticlesErrInTheOrderInWhichTheySimplify) {
  const Shot shot = streetShot(presetBeams("paper_64"), -20);
  const Hits truth = traced(*tracing_, shot);
  const auto errors = [&](const std::string& options) {
    return compareHits(truth, flownOver(*scene_, shot, options), {});
  };
  const HitErrors none = errors("refine: none");
  const HitErrors coarse = errors("refine: none, voxel_m: 0.4, voxels: 64");
  EXPECT_LT(none.rangeSameSurface.median, 0.1);
  EXPECT_GT(coarse.rangeSameSurface.median, 2 * none.rangeSameSurface.median);
  // Half a voxel thicker than it is, everything is seen: only beams past silhouettes are false positives.
  EXPECT_LT(none.falseNegatives, none.beams / 1000);
  EXPECT_GT(static_cast<double>(none.sameLabel), 0.85 * static_cast<double>(none.bothHit));
}

}  // namespace
}  // namespace scanmill
