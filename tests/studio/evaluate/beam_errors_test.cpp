#include "evaluate/beam_errors.h"

#include <limits>

#include "base/error.h"
#include "base/random.h"
#include "tests/core/methods/trace.h"
#include "tests/support/test_scene.h"

namespace scanmill {
namespace {

constexpr float kNotANumber = std::numeric_limits<float>::quiet_NaN();

// Ground below the sensor and `things` boxes of 1 m, far off: what is met is made by hand.
Scene sceneOf(std::uint32_t things = 3) {
  SceneBuilder builder = testBuilder();
  Mesh ground = meshOf(builder, "ground");
  appendPlane(ground, 0, {}, 2000, 2000);
  builder.place(builder.addMesh(ground), at(0, 0, -2), "ground");
  Mesh box = meshOf(builder, "thing");
  appendBox(box, 0, {}, {1, 1, 1});
  const std::uint32_t mesh = builder.addMesh(box);
  for (std::uint32_t i = 0; i < things; ++i) builder.place(mesh, at(500, 10.0 * i, 0), "box");
  return builder.finish();
}

Hits hitsAt(const std::vector<float>& ranges) {
  Hits hits;
  hits.reset(1, static_cast<std::uint32_t>(ranges.size()), kErrorChannels);
  hits.range = ranges;
  for (std::size_t i = 0; i < hits.size(); ++i) {
    hits.semantic[i] = hits.hit(i) ? 2 : 0;
    hits.incidence[i] = hits.hit(i) ? 1.0f : 0.0f;
  }
  return hits;
}

TrueShot truthFrom(const Hits& hits) {
  TrueShot shot;
  shot.truth.hits = hits;
  shot.truth.range.assign(hits.range.begin(), hits.range.end());
  return shot;
}

BeamErrors errorsOf(const Scene& scene, const TrueShot& truth, const Hits& tested,
                    const std::vector<float>& intensity = {}) {
  BeamErrorSum sum(scene);
  sum.add(truth, tested, intensity);
  return sum.finish();
}

const GroupErrors& groupOf(const std::vector<ErrorGroup>& groups, const std::string& name) {
  const auto found = std::ranges::find_if(groups, [&](const ErrorGroup& g) { return g.name == name; });
  if (found == groups.end()) throw Error("no group " + name);
  return found->errors;
}

// Two planes that lie `offset` apart: a beam at the angle a to their normal errs by offset / cos(a).
TEST(BeamErrors, OfParallelPlanesAreTheirOffsetOverTheCosine) {
  const double height = 2;
  const double offset = 0.1;
  const Scene upper = flatGround({0, 0, -height}, 4000, 1);
  const Scene lower = flatGround({0, 0, -height - offset}, 4000, 1);
  const Shot shot = shotAt(spinning(60, 90, -88, -2));
  const TrueShot truth = truthFrom(traced(upper, shot));
  const BeamErrors e = errorsOf(upper, truth, traced(lower, shot));

  double mean = 0;
  for (const Vec3d& d : shot.beams->direction) mean += offset / -d.z;
  mean /= static_cast<double>(shot.beams->size());
  EXPECT_EQ(e.all.bothHit, 5400u);
  EXPECT_NEAR(e.all.range.mean, mean, 1e-5 * mean);
  EXPECT_NEAR(e.all.range.max, offset / std::sin(radians(2)), 1e-4);
  ASSERT_EQ(e.byIncidence.size(), 6u);
  for (const ErrorGroup& band : e.byIncidence) {
    EXPECT_GT(band.errors.bothHit, 0u) << band.name;
    EXPECT_GE(band.errors.range.mean, offset / std::cos(radians(band.low)) * (1 - 1e-5)) << band.name;
    if (band.high < 90) {
      EXPECT_LE(band.errors.range.max, offset / std::cos(radians(band.high)) * (1 + 1e-5)) << band.name;
    }
  }
  for (const ErrorGroup& band : e.byRange) {
    if (band.errors.bothHit == 0) continue;
    EXPECT_GE(band.errors.range.mean, offset * std::max(band.low / height, 1.0) * (1 - 1e-5)) << band.name;
  }
  EXPECT_EQ(e.all.labels(), 1);
  EXPECT_EQ(e.all.missRate(), 0);
}

TEST(BeamErrors, OfIdenticalHitsAreNone) {
  const Scene scene = sceneOf();
  Hits hits = hitsAt({1, 7, 15, 30, 60, 90, kMiss});
  hits.instance = {1, 2, 3, 1, 2, 3, 0};
  TrueShot truth = truthFrom(hits);
  truth.intensity.assign(7, 0.5f);
  const BeamErrors e = errorsOf(scene, truth, hits, truth.intensity);
  EXPECT_EQ(e.all.beams, 7u);
  EXPECT_EQ(e.all.bothHit, 6u);
  EXPECT_EQ(e.all.bothMiss, 1u);
  EXPECT_EQ(e.all.range.max, 0);
  EXPECT_EQ(e.all.intensity.count, 6u);
  EXPECT_EQ(e.all.intensity.max, 0);
  EXPECT_EQ(e.all.missRate(), 0);
  EXPECT_EQ(e.all.labels(), 1);
  EXPECT_EQ(e.all.classAgreed(), 1);
  EXPECT_EQ(e.all.instanceAgreed(), 1);
  ASSERT_EQ(e.byRange.size(), 6u);
  for (const ErrorGroup& band : e.byRange) EXPECT_EQ(band.errors.bothHit, 1u) << band.name;
  EXPECT_EQ(e.byRange[2].name, "10 to 20 m");
  EXPECT_EQ(e.byRange[5].name, "80 m and more");
  EXPECT_TRUE(std::isinf(e.byRange[5].high));
}

TEST(BeamErrors, EveryOutcomeCountsOnce) {
  const Scene scene = sceneOf();
  const TrueShot truth = truthFrom(hitsAt({10, 10, kMiss, kMiss, 5, 7, 12, kMiss}));
  Hits tested = hitsAt({10.5f, kMiss, 3, kMiss, 5, 9, kMiss, kMiss});
  tested.instance[5] = 9;
  tested.semantic[4] = 3;
  tested.unresolved = {6, 7};
  const GroupErrors e = errorsOf(scene, truth, tested).all;
  EXPECT_EQ(e.beams, 8u);
  EXPECT_EQ(e.bothHit, 3u);
  EXPECT_EQ(e.bothMiss, 1u);
  EXPECT_EQ(e.falseNegatives, 1u);
  EXPECT_EQ(e.falsePositives, 1u);
  EXPECT_EQ(e.unresolved, 2u);
  EXPECT_EQ(e.missRate(), 0.5);
  EXPECT_EQ(e.sameClass, 2u);
  EXPECT_EQ(e.sameInstance, 2u);
  EXPECT_EQ(e.sameLabel, 1u);
  EXPECT_EQ(e.range.count, 3u);
  EXPECT_EQ(e.range.max, 2);
  EXPECT_EQ(e.range.median, 0.5);
}

// A beam lies where it hits in truth, else where it is said to hit.
TEST(BeamErrors, BeamsBelongToTheBandOfTheTruth) {
  const Scene scene = sceneOf();
  TrueShot truth = truthFrom(hitsAt({4.9f, 5, 50, kMiss}));
  truth.truth.hits.incidence = {1, 0.5f - 1e-6f, 0, 0};
  truth.truth.hits.semantic = {1, 2, 7, 0};
  truth.edges = {0, 1, 1, 0};
  Hits tested = hitsAt({50, 4, kMiss, 25});
  tested.semantic = {3, 3, 0, 3};
  const BeamErrors e = errorsOf(scene, truth, tested);
  ASSERT_EQ(e.byRange.size(), 5u);  // none beyond 80 m
  EXPECT_EQ(groupOf(e.byRange, "0 to 5 m").bothHit, 1u);
  EXPECT_EQ(groupOf(e.byRange, "5 to 10 m").bothHit, 1u);
  EXPECT_EQ(groupOf(e.byRange, "10 to 20 m").beams, 0u);
  EXPECT_EQ(groupOf(e.byRange, "20 to 40 m").falsePositives, 1u);
  EXPECT_EQ(groupOf(e.byRange, "40 to 80 m").falseNegatives, 1u);
  EXPECT_EQ(groupOf(e.byIncidence, "0 to 30 deg").beams, 1u);
  EXPECT_EQ(groupOf(e.byIncidence, "60 to 75 deg").beams, 1u);
  EXPECT_EQ(groupOf(e.byIncidence, "85 to 90 deg").falseNegatives, 1u);
  EXPECT_EQ(groupOf(e.byEdge, "edges").beams, 2u);
  EXPECT_EQ(groupOf(e.byEdge, "interior").falsePositives, 1u);
  ASSERT_EQ(e.byClass.size(), 4u);
  EXPECT_EQ(e.byClass[0].name, "ground");
  EXPECT_EQ(e.byClass[1].name, "thing");
  EXPECT_EQ(groupOf(e.byClass, "other").falsePositives, 1u);
  EXPECT_EQ(groupOf(e.byClass, "class 7").falseNegatives, 1u);
}

struct RandomPair {
  TrueShot truth;
  Hits tested;
  std::vector<float> intensity;
  std::vector<float> nearestTo, nearestFrom;
};

RandomPair randomPair(std::uint32_t stream, std::uint32_t beams) {
  Hits exact;
  exact.reset(1, beams, kErrorChannels);
  RandomPair pair;
  pair.tested = exact;
  for (std::uint32_t i = 0; i < beams; ++i) {
    const RandomBlock a = randomBlock({3, stream, 0, 0, i, 0, Purpose::Test});
    const RandomBlock b = randomBlock({3, stream, 1, 0, i, 0, Purpose::Test});
    const bool hits = uniform(a[0]) < 0.7;
    const bool seen = uniform(b[0]) < 0.7;
    exact.range[i] = hits ? static_cast<float>(120 * uniform(a[1])) : kMiss;
    exact.semantic[i] = hits ? a[2] % 4 : 0;
    exact.instance[i] = hits ? a[3] % 4 : 0;
    exact.incidence[i] = hits ? static_cast<float>(uniform(b[1])) : 0;
    pair.tested.range[i] = seen ? static_cast<float>(120 * uniform(b[2])) : kMiss;
    pair.tested.semantic[i] = seen ? b[3] % 4 : 0;
    pair.tested.instance[i] = seen ? (b[3] >> 8) % 4 : 0;
    if (!seen && (b[3] >> 16) % 4 == 0) pair.tested.unresolved.push_back(i);
    pair.truth.edges.push_back(b[3] >> 31 != 0 ? 1 : 0);
    pair.truth.intensity.push_back(static_cast<float>(uniform(a[2])));
    pair.intensity.push_back(static_cast<float>(uniform(b[2])));
    const RandomBlock c = randomBlock({3, stream, 2, 0, i, 0, Purpose::Test});
    pair.nearestTo.push_back(c[2] % 8 == 0 ? kNotANumber : static_cast<float>(uniform(c[0])));
    pair.nearestFrom.push_back(c[3] % 8 == 0 ? kNotANumber : static_cast<float>(uniform(c[1])));
  }
  pair.truth.truth.hits = exact;
  pair.truth.truth.range.assign(exact.range.begin(), exact.range.end());
  return pair;
}

GroupErrors totalOf(const std::vector<ErrorGroup>& groups) {
  GroupErrors total;
  for (const auto& [name, low, high, e] : groups) {
    for (const auto count : {&GroupErrors::beams, &GroupErrors::bothHit, &GroupErrors::bothMiss,
                             &GroupErrors::falseNegatives, &GroupErrors::falsePositives, &GroupErrors::unresolved,
                             &GroupErrors::sameClass, &GroupErrors::sameInstance, &GroupErrors::sameLabel}) {
      total.*count += e.*count;
    }
    total.range.count += e.range.count;
    total.range.mean += e.range.mean * static_cast<double>(e.range.count);
    total.range.max = std::max(total.range.max, e.range.max);
    total.intensity.count += e.intensity.count;
    for (const auto distances : {&GroupErrors::nearestTo, &GroupErrors::nearestFrom}) {
      (total.*distances).count += (e.*distances).count;
      (total.*distances).max = std::max((total.*distances).max, (e.*distances).max);
    }
  }
  return total;
}

TEST(BeamErrors, GroupsAddUpToTheWhole) {
  const Scene scene = sceneOf();
  BeamErrorSum sum(scene);
  std::uint64_t trueHits = 0;
  std::uint64_t truePoints = 0;  // whose distances are known
  for (std::uint32_t stream = 0; stream < 3; ++stream) {
    const RandomPair p = randomPair(stream, 5000);
    sum.add(p.truth, p.tested, p.intensity, p.nearestTo, p.nearestFrom);
    for (std::size_t i = 0; i < 5000; ++i) {
      trueHits += p.truth.truth.hits.hit(i) ? 1 : 0;
      truePoints += p.truth.truth.hits.hit(i) && !std::isnan(p.nearestTo[i]) ? 1 : 0;
    }
  }
  const BeamErrors e = sum.finish();
  EXPECT_EQ(e.all.beams, 15'000u);
  EXPECT_EQ(e.all.beams,
            e.all.bothHit + e.all.bothMiss + e.all.falseNegatives + e.all.falsePositives + e.all.unresolved);
  EXPECT_GT(e.all.unresolved, 0u);
  EXPECT_EQ(e.all.intensity.count, e.all.bothHit);
  EXPECT_LE(e.all.sameLabel, std::min(e.all.sameClass, e.all.sameInstance));
  for (const auto* groups : {&e.byRange, &e.byIncidence, &e.byEdge, &e.byClass}) {
    const GroupErrors total = totalOf(*groups);
    EXPECT_EQ(total.bothHit, e.all.bothHit);
    EXPECT_EQ(total.falseNegatives, e.all.falseNegatives);
    EXPECT_EQ(total.sameClass, e.all.sameClass);
    EXPECT_EQ(total.sameInstance, e.all.sameInstance);
    EXPECT_EQ(total.sameLabel, e.all.sameLabel);
    EXPECT_EQ(total.range.count, e.all.range.count);
    EXPECT_NEAR(total.range.mean, e.all.range.mean * static_cast<double>(e.all.bothHit), 1e-6 * total.range.mean);
    EXPECT_EQ(total.range.max, e.all.range.max);
    EXPECT_EQ(total.intensity.count, e.all.intensity.count);
    EXPECT_EQ(total.nearestTo.count, truePoints);
    EXPECT_EQ(total.nearestTo.max, e.all.nearestTo.max);
    if (groups != &e.byIncidence) {
      EXPECT_EQ(total.falsePositives, e.all.falsePositives);
      EXPECT_EQ(total.nearestFrom.count, e.all.nearestFrom.count);
      EXPECT_EQ(total.nearestFrom.max, e.all.nearestFrom.max);
      EXPECT_EQ(total.hausdorff(), e.all.hausdorff());
    }
  }
  EXPECT_EQ(totalOf(e.byEdge).beams, e.all.beams);
  EXPECT_EQ(totalOf(e.byIncidence).beams, trueHits);
}

// A distance lies where its beam does, however far off the nearest point; Hausdorff's is the larger of the two.
TEST(BeamErrors, NearestDistancesBelongToTheGroupOfTheirBeam) {
  const Scene scene = sceneOf();
  TrueShot truth = truthFrom(hitsAt({4, 15, kMiss, kMiss, 30, 30}));
  truth.truth.hits.semantic = {1, 2, 0, 0, 2, 2};
  truth.edges = {0, 1, 1, 0, 0, 0};
  Hits tested = hitsAt({50, kMiss, 7, kMiss, kMiss, 30});
  tested.semantic = {1, 0, 3, 0, 0, 2};
  tested.unresolved = {4};
  BeamErrorSum sum(scene);
  sum.add(truth, tested, {}, std::vector<float>{1, 2, 64, 64, 3, kNotANumber},
          std::vector<float>{5, 64, 6, 64, 64, kNotANumber});
  const BeamErrors e = sum.finish();
  EXPECT_EQ(e.all.nearestTo.count, 3u) << "a miss has no distance";
  EXPECT_EQ(e.all.nearestTo.mean, 2);
  EXPECT_EQ(e.all.nearestFrom.count, 2u);
  EXPECT_EQ(e.all.hausdorff(), 6);
  const GroupErrors& close = groupOf(e.byRange, "0 to 5 m");
  EXPECT_EQ(close.nearestTo.mean, 1);
  EXPECT_EQ(close.nearestFrom.mean, 5) << "its true range decides";
  EXPECT_EQ(close.hausdorff(), 5);
  EXPECT_EQ(groupOf(e.byRange, "5 to 10 m").nearestFrom.mean, 6);
  EXPECT_EQ(groupOf(e.byRange, "5 to 10 m").nearestTo.count, 0u);
  EXPECT_EQ(groupOf(e.byRange, "10 to 20 m").nearestTo.mean, 2);
  EXPECT_EQ(groupOf(e.byRange, "20 to 40 m").nearestTo.count, 1u) << "the unresolved beam's true point is known";
  EXPECT_EQ(groupOf(e.byRange, "20 to 40 m").nearestFrom.count, 0u);
  EXPECT_EQ(groupOf(e.byRange, "20 to 40 m").hausdorff(), 3);
  EXPECT_EQ(groupOf(e.byEdge, "edges").hausdorff(), 6);
  EXPECT_EQ(groupOf(e.byEdge, "interior").nearestTo.mean, 2);
  EXPECT_EQ(groupOf(e.byClass, "other").nearestFrom.max, 6);
  EXPECT_EQ(totalOf(e.byIncidence).nearestFrom.count, 1u) << "what is invented has no incidence";
}

TEST(BeamErrors, WhereThereIsNothingToCompareNothingErrs) {
  const Scene scene = sceneOf();
  const BeamErrors none = BeamErrorSum(scene).finish();
  EXPECT_EQ(none.all.beams, 0u);
  EXPECT_EQ(none.all.missRate(), 0);
  EXPECT_EQ(none.all.labels(), 1);
  EXPECT_TRUE(none.byRange.empty());
  EXPECT_TRUE(none.byThickness.empty());
  const BeamErrors misses = errorsOf(scene, truthFrom(hitsAt({kMiss, kMiss})), hitsAt({kMiss, kMiss}));
  EXPECT_EQ(misses.all.bothMiss, 2u);
  EXPECT_EQ(misses.all.missRate(), 0);
  EXPECT_TRUE(misses.byClass.empty());
  const BeamErrors blind = errorsOf(scene, truthFrom(hitsAt({1, 2})), hitsAt({kMiss, kMiss}));
  EXPECT_EQ(blind.all.missRate(), 1);
  EXPECT_EQ(blind.all.range.count, 0u);
  EXPECT_EQ(blind.all.instanceAgreed(), 1);
  EXPECT_EQ(blind.all.nearestTo.count, 0u);
  EXPECT_EQ(blind.all.hausdorff(), 0);
}

TEST(BeamErrors, WhatIsNotANumberIsAMiss) {
  const Scene scene = sceneOf();
  TrueShot truth = truthFrom(hitsAt({kNotANumber, 5, kNotANumber, 6, 7}));
  truth.truth.hits.incidence[3] = kNotANumber;
  truth.intensity = {1, 1, 1, kNotANumber, 1};
  const BeamErrors e = errorsOf(scene, truth, hitsAt({kNotANumber, kNotANumber, 4, 6, 7}), {1, 1, 1, 1, 3});
  EXPECT_EQ(e.all.bothMiss, 1u);
  EXPECT_EQ(e.all.falseNegatives, 1u);
  EXPECT_EQ(e.all.falsePositives, 1u);
  EXPECT_EQ(e.all.bothHit, 2u);
  EXPECT_EQ(e.all.range.max, 0);
  EXPECT_EQ(e.all.intensity.count, 1u);
  EXPECT_EQ(e.all.intensity.mean, 2);
  EXPECT_EQ(totalOf(e.byIncidence).bothHit, 1u);
}

TEST(BeamErrors, IntensitiesAreComparedWhereBothAreGiven) {
  const Scene scene = sceneOf();
  TrueShot truth = truthFrom(hitsAt({5, 5, kMiss}));
  EXPECT_EQ(errorsOf(scene, truth, hitsAt({5, 5, 5}), {1, 2, 3}).all.intensity.count, 0u);
  truth.intensity = {0.5f, 0.5f, 0.5f};
  EXPECT_EQ(errorsOf(scene, truth, hitsAt({5, 5, 5})).all.intensity.count, 0u);
  const Spread s = errorsOf(scene, truth, hitsAt({5, 5, 5}), {0.75f, 0.25f, 9}).all.intensity;
  EXPECT_EQ(s.count, 2u);
  EXPECT_EQ(s.mean, 0.25);
}

TEST(BeamErrors, WhatDoesNotFitIsRefused) {
  const Scene scene = sceneOf();
  const TrueShot truth = truthFrom(hitsAt({1, 2}));
  EXPECT_THROW(errorsOf(scene, truth, hitsAt({1})), Error);
  TrueShot foreign = truth;
  foreign.truth.hits.instance[1] = 4'000'000'000u;
  EXPECT_THROW(errorsOf(scene, foreign, hitsAt({1, 2})), Error);
  const std::vector<float> three(3, 0);
  BeamErrorSum sum(scene);
  EXPECT_THROW(sum.add(truth, hitsAt({1, 2}), three), Error);
  EXPECT_THROW(sum.add(truth, hitsAt({1, 2}), {}, three), Error);
  EXPECT_THROW(sum.add(truth, hitsAt({1, 2}), {}, {}, three), Error);
  TrueShot edged = truth;
  edged.edges = {0, 1, 0};
  EXPECT_THROW(errorsOf(scene, edged, hitsAt({1, 2})), Error);
}

TEST(ThingSizes, AreThoseOfTheBoxAlongTheMeshsAxes) {
  SceneBuilder builder = testBuilder();
  Mesh pair = meshOf(builder, "thing");
  Surface second = pair.surfaces[0];
  second.object = 2;
  pair.surfaces.push_back(second);
  pair.surfaces.push_back(builder.surface("ground", "grey"));
  appendBox(pair, 0, at(3, 0, 0), {0.25, 1, 2});
  appendBox(pair, 1, at(-3, 0, 0), {4, 0.5, 1});
  appendBox(pair, 2, {}, {50, 50, 50});
  Mesh sheet = meshOf(builder, "thing");
  appendPlane(sheet, 0, {}, 2, 3);
  const std::uint32_t pairId = builder.addMesh(pair);
  const Mat3 turned = toMatrix(fromYawPitchRoll(0.3, 0.4, 0.5));
  builder.place(pairId, at(100, 200, 300), "pair");
  builder.place(pairId, {turned * Mat3::scale({2, 3, 0.5}), {7, 7, 7}}, "stretched");
  builder.place(builder.addMesh(sheet), {turned * Mat3::scale({1, -1, 1}), {}}, "sheet");
  const std::vector<InstanceSize> sizes = instanceSizes(builder.finish());
  ASSERT_EQ(sizes.size(), 6u);
  const std::vector<std::pair<double, double>> expected{{0, 0}, {0.25, 2}, {0.5, 4}, {0.5, 3}, {0.5, 8}, {0, 3}};
  for (std::size_t id = 0; id < sizes.size(); ++id) {
    EXPECT_NEAR(sizes[id].smallest, expected[id].first, 1e-6) << id;
    EXPECT_NEAR(sizes[id].largest, expected[id].second, 1e-6) << id;
  }
}

// A pole of 4 cm that nobody else finds, half of a box, and a box that no beam meets.
TEST(BeamErrors, RecallCountsThingsBySize) {
  SceneBuilder builder = testBuilder();
  const auto place = [&](const Vec3d& size) {
    Mesh mesh = meshOf(builder, "thing");
    appendBox(mesh, 0, {}, size);
    builder.place(builder.addMesh(mesh), at(10, 0, 0), "thing");
  };
  place({0.04, 0.04, 3});
  place({1.5, 1.6, 1.7});
  place({0.3, 0.3, 0.3});
  const Scene scene = builder.finish();
  Hits exact = hitsAt(std::vector<float>(10, 10.0f));
  exact.instance = {1, 1, 1, 2, 2, 2, 2, 0, 0, 0};
  Hits tested = exact;
  tested.instance = {2, 2, 0, 2, 2, 1, 0, 3, 0, 0};
  tested.range[6] = kMiss;
  const BeamErrors e = errorsOf(scene, truthFrom(exact), tested);
  ASSERT_EQ(e.byThickness.size(), 5u);
  EXPECT_EQ(e.byThickness[0].name, "0 to 0.05 m");
  EXPECT_EQ(e.byThickness[0].instances, 1u);
  EXPECT_EQ(e.byThickness[0].instancesFound, 0u);
  EXPECT_EQ(e.byThickness[0].beams, 3u);
  EXPECT_EQ(e.byThickness[0].beamsFound, 0u);
  EXPECT_EQ(e.byThickness[4].instances, 1u);
  EXPECT_EQ(e.byThickness[4].instancesFound, 1u);
  EXPECT_EQ(e.byThickness[4].beams, 4u);
  EXPECT_EQ(e.byThickness[4].beamsFound, 2u);
  for (std::size_t i = 1; i < 4; ++i) EXPECT_EQ(e.byThickness[i].instances, 0u);
  ASSERT_EQ(e.byLength.size(), 4u);
  EXPECT_EQ(e.byLength[2].instancesFound, 1u);  // 1 to 2 m
  EXPECT_EQ(e.byLength[3].instances, 1u);       // 2 to 5 m
}

}  // namespace
}  // namespace scanmill
