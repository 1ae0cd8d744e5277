#include "evaluate/hit_errors.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

#include "tests/core/methods/trace.h"
#include "tests/support/message_of.h"
#include "tests/support/test_scene.h"

namespace scanmill {
namespace {

Hits hitsOf(const std::vector<float>& ranges) {
  Hits hits;
  hits.reset(1, static_cast<std::uint32_t>(ranges.size()), Channel::Instance | Channel::Semantic);
  hits.range = ranges;
  std::fill(hits.instance.begin(), hits.instance.end(), 1u);
  std::fill(hits.semantic.begin(), hits.semantic.end(), std::uint16_t{2});
  return hits;
}

TEST(HitErrors, CountsEveryOutcomeOnce) {
  const Hits reference = hitsOf({10, 10, kMiss, kMiss, 5, 7});
  Hits tested = hitsOf({10.5f, kMiss, 3, kMiss, 5, 9});
  tested.instance[5] = 9;
  const HitErrors e = compareHits(reference, tested, {});
  EXPECT_EQ(e.beams, 6u);
  EXPECT_EQ(e.bothHit, 3u);
  EXPECT_EQ(e.falseNegatives, 1u);
  EXPECT_EQ(e.falsePositives, 1u);
  EXPECT_EQ(e.sameLabel, 2u);
  EXPECT_EQ(e.range.max, 2);
  EXPECT_EQ(e.rangeSameSurface.max, 0.5);
  EXPECT_EQ(e.interior, 6u);
  EXPECT_EQ(e.interiorAgree, 3u);  // two hits and a miss
  const std::vector<std::uint8_t> edges{0, 1, 1, 0, 0, 1};
  const HitErrors inner = compareHits(reference, tested, edges);
  EXPECT_EQ(inner.interior, 3u);
  EXPECT_EQ(inner.interiorAgree, 3u);
  EXPECT_EQ(inner.rangeInterior.count, 2u);
  EXPECT_THROW(compareHits(reference, hitsOf({1}), {}), Error);
}

// What is compared is of beams; rays of several a beam would be taken for those of others.
TEST(HitErrors, RefuseSeveralRaysABeam) {
  const Hits reference = hitsOf({10, 10});
  Hits several = hitsOf({10, 10});
  several.beamOfRay = {0, 1, 1};
  several.range = {10, 10, 12};
  for (const std::string& refusal : {messageOf<Error>([&] { compareHits(reference, several, {}); }),
                                     messageOf<Error>([&] { compareHits(several, reference, {}); })}) {
    EXPECT_THAT(refusal, testing::HasSubstr("2 beams have 3 rays"));
  }
}

// A disc of angular radius a seen head-on: edge beams are those whose angle to its rim is below the pixel's.
TEST(HitErrors, EdgesAreWhereNeighboursDiffer) {
  SceneBuilder builder = testBuilder();
  Mesh box = meshOf(builder, "thing");
  appendBox(box, 0, at(0, 0, 0), {0.02, 2, 2});
  builder.place(builder.addMesh(box), at(10, 0, 0), "board");
  const Scene scene = builder.finish();
  const auto method = rayTracing(scene);
  const double angle = 0.002;
  const Shot shot = shotAt(spinning(9, 3600, -8, 8));
  const std::vector<std::uint8_t> edges = edgeBeams(*method, shot, angle);
  for (std::size_t i = 0; i < edges.size(); ++i) {
    const Vec3d& d = shot.beams->direction[i];
    if (d.x <= 0) {
      EXPECT_EQ(edges[i], 0);
      continue;
    }
    // Distance, on the image plane at 1 m, from the square's outline of half side 1 / 9.99.
    const double u = std::abs(d.y / d.x);
    const double v = std::abs(d.z / d.x);
    const double half = 1 / 9.99;
    const double toOutline = u <= half && v <= half ? std::min(half - u, half - v)
                                                    : std::hypot(std::max(u - half, 0.0), std::max(v - half, 0.0));
    if (toOutline > 2.1 * angle) {
      EXPECT_EQ(edges[i], 0) << u << " " << v;
    }
    if (toOutline < 0.9 * angle) {
      EXPECT_EQ(edges[i], 1) << u << " " << v;
    }
  }
  EXPECT_GT(std::accumulate(edges.begin(), edges.end(), 0), 15);
}

}  // namespace
}  // namespace scanmill
