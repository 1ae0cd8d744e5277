#include <cstring>
#include <map>

#include "tests/core/sense/world.h"
#include "tests/support/on_threads.h"

namespace scanmill {
namespace {

constexpr ScanLayout kEvery{ColumnSet::all(), false};
constexpr ScanLayout kEveryOrganised{ColumnSet::all(), true};

template <class T>
bool sameBytes(const std::vector<T>& a, const std::vector<T>& b) {
  return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0);
}

bool sameBytes(const Scan& a, const Scan& b) {
  bool same = a.rings == b.rings && a.columns == b.columns && a.organised == b.organised && a.planes == b.planes &&
              sameBytes(a.position, b.position);
  visitTable(a, [&](auto key, const auto& values) { same = same && sameBytes(values, b[key]); });
  return same;
}

TEST(Sense, NoiseFreePointsLieOnTheirBeamsInTheOrderOfFiring) {
  for (const auto& [rings, columns] : std::vector<std::pair<std::uint32_t, std::uint32_t>>{
           {1, 1}, {1, 300}, {300, 1}, {16, 64}, {17, 65}, {64, 1024}, {5, 63}}) {
    const World world = makeRaggedWorld(rings, columns);
    const Scan scan = senseOnce(world, {}, kEvery);
    std::size_t k = 0;
    for (std::uint32_t c = 0; c < columns; ++c) {
      for (std::uint32_t r = 0; r < rings; ++r) {
        const std::size_t b = std::size_t{r} * columns + c;
        if (!world.hits.hit(b)) continue;
        ASSERT_LT(k, scan.size());
        ASSERT_EQ(scan[kRing][k], r);
        ASSERT_EQ(scan[kColumn][k], c);
        ASSERT_EQ(scan[kLabel][k], world.hits.semantic[b]);
        ASSERT_EQ(scan[kInstance][k], world.hits.instance[b]);
        ASSERT_EQ(scan[kTime][k], world.shot.beams->time[b]);
        ASSERT_EQ(scan[kRangeTrue][k], world.hits.range[b]);
        const Vec3d expected = world.shot.beams->direction[b] * static_cast<double>(world.hits.range[b]);
        ASSERT_EQ(scan.position[k], static_cast<Vec3f>(expected));
        ++k;
      }
    }
    EXPECT_EQ(k, scan.size());
    EXPECT_EQ(scan.rings, rings);
    EXPECT_EQ(scan.columns, columns);
    EXPECT_EQ(scan.height(), 1u);
  }
}

TEST(Sense, DenseIsOrganisedWithoutItsMisses) {
  const World world = makeRaggedWorld(33, 130);
  const Scan dense = senseOnce(world, kManyEffects, kEvery);
  const Scan organised = senseOnce(world, kManyEffects, kEveryOrganised);
  ASSERT_EQ(organised.size(), world.hits.size());
  EXPECT_EQ(organised.width(), 130u);
  EXPECT_EQ(organised.height(), 33u);
  std::size_t k = 0;
  for (std::uint32_t c = 0; c < 130; ++c) {
    for (std::uint32_t r = 0; r < 33; ++r) {
      const std::size_t b = std::size_t{r} * 130 + c;
      if (std::isnan(organised.position[b].x)) {
        EXPECT_TRUE(std::isnan(organised.position[b].y) && std::isnan(organised.position[b].z));
        EXPECT_TRUE(std::isnan(organised[kRangeTrue][b]));
        EXPECT_TRUE(std::isnan(organised[kIncidence][b]));
        EXPECT_EQ(organised[kIntensity][b], 0);
        EXPECT_EQ(organised[kLabel][b] + organised[kInstance][b] + organised[kRing][b] + organised[kColumn][b], 0u);
        EXPECT_EQ(organised[kTime][b], 0);
        continue;
      }
      ASSERT_LT(k, dense.size());
      EXPECT_EQ(dense.position[k], organised.position[b]);
      visitTable(organised, [&](auto key, const auto& values) { EXPECT_EQ(values[b], dense[key][k]) << key.row.name; });
      ++k;
    }
  }
  EXPECT_EQ(k, dense.size());
  EXPECT_LT(k, world.hits.size() * 2 / 3);
}

TEST(Sense, NoisyScansJoinTheirNoiseFreeTwins) {
  const World world = makeRaggedWorld(32, 256);
  const std::vector<std::string> noisyEffects{"intensity: {}", "dropout: {probability: 0.2}",
                                              "range_noise: {sigma_m: 0.02}"};
  const Scan exact = senseOnce(world, {"intensity: {}"}, kEvery);
  const Scan noisy = senseOnce(world, noisyEffects, kEvery);
  std::map<std::pair<int, int>, std::size_t> twin;
  for (std::size_t k = 0; k < exact.size(); ++k) twin[{exact[kRing][k], exact[kColumn][k]}] = k;
  ASSERT_LT(noisy.size(), exact.size());
  std::size_t unmoved = 0;  // by less than a float resolves
  for (std::size_t k = 0; k < noisy.size(); ++k) {
    const auto found = twin.find({noisy[kRing][k], noisy[kColumn][k]});
    ASSERT_NE(found, twin.end());
    const std::size_t t = found->second;
    EXPECT_EQ(noisy[kLabel][k], exact[kLabel][t]);
    EXPECT_EQ(noisy[kInstance][k], exact[kInstance][t]);
    EXPECT_EQ(noisy[kTime][k], exact[kTime][t]);
    EXPECT_EQ(noisy[kIntensity][k], exact[kIntensity][t]);
    EXPECT_EQ(noisy[kRangeTrue][k], exact[kRangeTrue][t]);
    EXPECT_EQ(noisy[kIncidence][k], exact[kIncidence][t]);
    unmoved += noisy.position[k] == exact.position[t] ? 1u : 0u;
    const Vec3d a = normalized(static_cast<Vec3d>(noisy.position[k]));
    const Vec3d b = normalized(static_cast<Vec3d>(exact.position[t]));
    EXPECT_NEAR(length(cross(a, b)), 0, 1e-6);
    EXPECT_NEAR(length(static_cast<Vec3d>(noisy.position[k])), noisy[kRangeTrue][k], 0.02 * 6.8);
  }
  EXPECT_LT(unmoved, noisy.size() / 100);
}

TEST(Sense, ReusedBuffersAndOtherThreadsGiveTheSameBytes) {
  const World big = makeRaggedWorld(40, 300);
  const World small = makeRaggedWorld(3, 7);
  const auto list = makeEffects(kManyEffects);
  const Scan expected = senseOnce(big, kManyEffects, kEvery);
  Returns scratch;
  Scan scan;
  sense({list, big.materials, kEveryOrganised}, big.hits, big.shot, scratch, scan);
  sense({{}, small.materials, kEvery}, small.hits, small.shot, scratch, scan);
  EXPECT_TRUE(scan[kIntensity].empty());
  sense({list, big.materials, kEvery}, big.hits, big.shot, scratch, scan);
  EXPECT_TRUE(sameBytes(scan, expected));
  std::vector<Scan> scans(4);
  onThreads(scans.size(), [&](std::size_t thread) {
    Returns own;
    for (int i = 0; i < 3; ++i) sense({list, big.materials, kEvery}, big.hits, big.shot, own, scans[thread]);
  });
  for (const Scan& mine : scans) EXPECT_TRUE(sameBytes(mine, expected));
}

TEST(Sense, KeepsOnlyTheColumnsAskedFor) {
  const World world = makeRaggedWorld(4, 50);
  const ScanLayout few{ColumnSet(kRing), false};
  EXPECT_EQ(columnNames(senseOnce(world, {"intensity: {}"}, few)), (std::vector<std::string>{"x", "y", "z", "ring"}));
  EXPECT_EQ(columnNames(senseOnce(world, {}, kEvery)),
            scanColumnNames(ColumnSet::all().without(kIntensity).without(kPower)));
  World bare = world;
  bare.hits.reset(4, 50, Channel::Range);
  EXPECT_EQ(senseOnce(bare, {}, few).size(), senseOnce(world, {}, few).size());
  EXPECT_THROW(senseOnce(bare, {}, kEvery), Error);
  EXPECT_THROW(senseOnce(bare, {"intensity: {}"}, few), Error);
}

// Cosines of Hits become angles, from head-on to grazing; what a recording did not know stays unknown.
TEST(Sense, IncidenceIsTheAngleOfItsCosine) {
  constexpr ScanLayout kAngles{ColumnSet::byDefault().without(kRing).with(kIncidence), false};
  World world = makeWorld(1, 901);
  for (std::size_t b = 0; b < world.hits.size(); ++b) {
    world.hits.incidence[b] = static_cast<float>(std::cos(radians(0.1 * static_cast<double>(b))));
  }
  const Scan scan = senseOnce(world, {"range_noise: {sigma_m: 0.5}", "angular_jitter: {sigma_deg: 1}"}, kAngles);
  ASSERT_EQ(scan[kIncidence].size(), world.hits.size());
  for (std::size_t k = 0; k < scan.size(); ++k) {
    const double angle = radians(0.1 * scan[kColumn][k]);
    // A cosine's rounding is an angle's over its sine.
    EXPECT_NEAR(scan[kIncidence][k], angle, std::min(6e-8 / std::max(std::sin(angle), 1e-9), 3.5e-4) + 1e-7);
  }
  EXPECT_EQ(scan[kIncidence].front(), 0);
  world.hits.incidence[5] = std::nanf("");
  world.hits.incidence[6] = 1 + 1e-6f;
  const Scan odd = senseOnce(world, {}, kAngles);
  EXPECT_TRUE(std::isnan(odd[kIncidence][5]));
  EXPECT_EQ(odd[kIncidence][6], 0);
  EXPECT_TRUE(senseOnce(world, {})[kIncidence].empty()) << "nobody asked";
  world.hits.reset(1, 901, Channel::Range | Channel::Semantic | Channels(Channel::Instance));
  EXPECT_THAT(messageOf<Error>([&] { senseOnce(world, {}, kAngles); }), testing::HasSubstr("incidence"));
}

TEST(Sense, HitsMustBelongToTheSensor) {
  World world = makeWorld(4, 50);
  world.shot.beams = makeWorld(50, 4).shot.beams;
  EXPECT_THROW(senseOnce(world, {}), Error);
}

TEST(Sense, BeamOriginsShiftThePoints) {
  World world = makeWorld(4, 50, 20);
  const Scan before = senseOnce(world, {}, kEveryOrganised);
  world.beams().origin.assign(world.hits.size(), Vec3f{0.5f, -0.25f, 0.125f});
  const Scan after = senseOnce(world, {}, kEveryOrganised);
  for (std::size_t b = 0; b < before.size(); ++b) {
    EXPECT_NEAR(length(after.position[b] - before.position[b] - Vec3f{0.5f, -0.25f, 0.125f}), 0, 4e-6);
  }
}

TEST(Sense, MissesGiveEmptyDenseScansAndOrganisedOnesWithoutPoints) {
  World world = makeWorld(6, 70);
  for (std::size_t b = 0; b < world.hits.size(); ++b) miss(world, b);
  EXPECT_EQ(senseOnce(world, kManyEffects, kEvery).size(), 0u);
  const Scan organised = senseOnce(world, kManyEffects, kEveryOrganised);
  EXPECT_EQ(organised.size(), 420u);
  for (const Vec3f& p : organised.position) EXPECT_TRUE(std::isnan(p.x));
  EXPECT_EQ(senseOnce(makeWorld(0, 0), kManyEffects, kEvery).size(), 0u);
  EXPECT_EQ(senseOnce(makeWorld(0, 0), kManyEffects, kEveryOrganised).size(), 0u);
}

// A wall that stands still in the world, seen from a sensor that drives and turns: after deskewing all points lie on
// it, in the frame of the revolution's start, whatever the world's origin.
TEST(Sense, DeskewUndoesTheMotionOfTheSensor) {
  const auto scanAt = [](const Vec3d& corner, std::size_t steps, bool deskew) {
    World world = makeWorld(8, 720);
    world.shot.deskew = deskew;
    world.shot.worldFromSensor.clear();
    for (std::size_t s = 0; s < steps; ++s) {
      const double t = static_cast<double>(s) / static_cast<double>(steps);
      world.shot.worldFromSensor.push_back(
          {fromYawPitchRoll(0.7 + 0.2 * t, 0.02 * t, 0.01), corner + Vec3d{2 * t, 0.5 * t, 0.1 * t}});
    }
    for (std::size_t b = 0; b < world.hits.size(); ++b) {
      const Pose& pose = world.shot.worldFromSensor[world.shot.stepOf(static_cast<std::uint32_t>(b % 720))];
      const Vec3d direction = toMatrix(pose.rotation) * world.shot.beams->direction[b];
      const double distance = (30 - (pose.translation.x - corner.x)) / direction.x;
      if (direction.x > 0.05) {
        world.hits.range[b] = static_cast<float>(distance);
      } else {
        miss(world, b);
      }
    }
    return std::make_pair(senseOnce(world, {}), world.shot.worldFromSensor.front());
  };
  for (std::size_t steps : {7u, 360u, 720u}) {
    for (const Vec3d& corner : {Vec3d{0, 0, 0}, Vec3d{1e7, -1e7, 100}}) {
      const auto [scan, start] = scanAt(corner, steps, true);
      ASSERT_GT(scan.size(), 1000u);
      const auto [skewed, same] = scanAt(corner, steps, false);
      double worstSkewed = 0;
      for (std::size_t k = 0; k < scan.size(); ++k) {
        const double range = length(static_cast<Vec3d>(scan.position[k]));
        EXPECT_NEAR((toMatrix(start.rotation) * static_cast<Vec3d>(scan.position[k])).x, 30, 1e-6 * range + 1e-8);
        worstSkewed =
            std::max(worstSkewed, std::abs((toMatrix(start.rotation) * static_cast<Vec3d>(skewed.position[k])).x - 30));
      }
      EXPECT_GT(worstSkewed, 0.5);
    }
  }
}

TEST(Sense, DeskewOfASensorThatStandsStillChangesNoBit) {
  World world = makeRaggedWorld(8, 100);
  const Scan before = senseOnce(world, {});
  world.shot.deskew = true;
  world.shot.worldFromSensor[0] = {fromYawPitchRoll(1, 0.1, 0.2), {5e6, 3e6, 10}};
  EXPECT_TRUE(sameBytes(before, senseOnce(world, {})));
}

}  // namespace
}  // namespace scanmill
