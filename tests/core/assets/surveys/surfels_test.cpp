#include <set>

#include "assets/surveys/surveys.h"
#include "base/parallel.h"
#include "base/random.h"

namespace scanmill {
namespace {

double draw(std::uint32_t i, std::size_t k) {
  return uniform(randomBlock({7, i, 0, 0, 0, 0, Purpose::Placement})[k]);
}

// Points of a square of 10 m in a plane through zero, at random.
std::vector<Vec3f> plane(const Vec3d& normal, std::uint32_t count) {
  const Vec3d u = normalized(cross(normal, Vec3d{0.3, 0.4, 0.5}));
  const Vec3d v = cross(normal, u);
  std::vector<Vec3f> points;
  for (std::uint32_t i = 0; i < count; ++i) {
    points.push_back(static_cast<Vec3f>(u * (10 * draw(i, 0) - 5) + v * (10 * draw(i, 1) - 5)));
  }
  return points;
}

TEST(Surfels, OfAPlaneHaveItsNormal) {
  for (const Vec3d& n : {Vec3d{0, 0, 1}, normalized(Vec3d{1, 2, 3}), normalized(Vec3d{-3, 1, 0.1})}) {
    for (const Surfel& s : surfelsOf(plane(n, 2000), {}, {})) {
      EXPECT_NEAR(std::fabs(dot(Vec3d(s.normal), n)), 1, 1e-5);
    }
  }
}

// Of points that lie at random, discs of `cover` times the radius of a point's share leave exp(-cover^2) of the plane
// bare: each place lies in a number of discs whose mean is cover^2 and which is Poisson's.
TEST(Surfels, CoverAsMuchAsTheyShould) {
  const std::vector<Vec3f> points = plane({0, 0, 1}, 8000);
  for (const double cover : {0.7, 1.0, 1.5, 2.0}) {
    SurfelOptions options;
    options.cover = cover;
    const std::vector<Surfel> surfels = surfelsOf(points, {}, options);
    int bare = 0;
    constexpr std::uint32_t kPlaces = 3000;
    for (std::uint32_t i = 0; i < kPlaces; ++i) {
      const Vec3d at{8 * draw(i, 2) - 4, 8 * draw(i, 3) - 4, 0};  // away from the edge
      bool in = false;
      for (std::size_t k = 0; k < points.size() && !in; ++k) {
        const double dx = double{points[k].x} - at.x;
        const double dy = double{points[k].y} - at.y;
        in = std::hypot(dx, dy) < double{surfels[k].radius};
      }
      bare += in ? 0 : 1;
    }
    const double expected = std::exp(-cover * cover);
    EXPECT_NEAR(bare / double{kPlaces}, expected, 0.25 * expected + 0.006) << cover;
  }
}

// Rings of a scan: dense along, apart across. Twelve neighbours are all of one ring, a line, which tells no plane.
TEST(Surfels, OfRingsTakeInTheNextRing) {
  std::vector<Vec3f> points;
  for (int ring = 0; ring < 12; ++ring) {
    for (int i = 0; i < 400; ++i) points.push_back({static_cast<float>(0.01 * i), static_cast<float>(0.1 * ring), 0});
  }
  int upright = 0;
  for (const Surfel& s : surfelsOf(points, {}, {})) upright += std::fabs(s.normal.z) > 0.999f ? 1 : 0;
  EXPECT_EQ(upright, 12 * 400);
}

TEST(Surfels, KeepNormalsThatAreGivenAndTheirBounds) {
  const std::vector<Vec3f> points = plane({0, 0, 1}, 500);
  SurfelOptions options;
  options.radius = {0.3, 0.35};
  const std::vector<Vec3f> normals(points.size(), {0, 2, 0});
  for (const Surfel& s : surfelsOf(points, normals, options)) {
    EXPECT_EQ(s.normal, (Vec3f{0, 1, 0}));
    EXPECT_GE(s.radius, 0.3f);
    EXPECT_LE(s.radius, 0.35f);
  }
  EXPECT_EQ(surfelsOf({{1, 2, 3}}, {}, options).at(0).radius, 0.35f) << "alone";
  EXPECT_EQ(surfelsOf({{1, 2, 3}, {1, 2, 3}, {1, 2, 3}}, {}, options).at(0).radius, 0.3f) << "thrice in one place";
  EXPECT_TRUE(surfelsOf({}, {}, options).empty());
}

TEST(Surfels, DoNotDependOnThreads) {
  const std::vector<Vec3f> points = plane(normalized(Vec3d{1, 1, 4}), 5000);
  const std::vector<Surfel> all = surfelsOf(points, {}, {});
  const ThreadLimit one(1);
  const std::vector<Surfel> alone = surfelsOf(points, {}, {});
  for (std::size_t i = 0; i < all.size(); ++i) {
    EXPECT_EQ(all[i].normal, alone[i].normal);
    EXPECT_EQ(all[i].radius, alone[i].radius);
  }
}

TEST(Surfels, ThinnedOnesAreOneACube) {
  const std::vector<Vec3f> points = plane({0, 0, 1}, 5000);
  const std::vector<std::size_t> kept = thinned(points, 0.5);
  std::set<std::pair<long, long>> cubes;
  for (const std::size_t i : kept) {
    EXPECT_TRUE(
        cubes.emplace(std::lround(std::floor(points[i].x / 0.5f)), std::lround(std::floor(points[i].y / 0.5f))).second);
  }
  std::set<std::pair<long, long>> all;
  for (const Vec3f& p : points) all.emplace(std::lround(std::floor(p.x / 0.5f)), std::lround(std::floor(p.y / 0.5f)));
  EXPECT_EQ(cubes.size(), all.size());
  EXPECT_TRUE(std::is_sorted(kept.begin(), kept.end()));
}

}  // namespace
}  // namespace scanmill
