#include "sense/returns.h"

#include "tests/core/sense/several_returns.h"

namespace scanmill {
namespace {

TEST(Returns, OneRayABeamIsOneRowABeam) {
  const World world = makeRaggedWorld(7, 40);
  Returns returns;
  returns.start(world.hits);
  ASSERT_TRUE(returns.onePerBeam());
  ASSERT_EQ(returns.size(), world.hits.size());
  for (std::size_t row = 0; row < returns.size(); ++row) {
    EXPECT_EQ(returns.beam(row), row);
    EXPECT_EQ(returns.hit(row), row);
    EXPECT_EQ(returns.number(row), 0u);
    EXPECT_EQ(returns.range[row], world.hits.range[row]);
    EXPECT_EQ(returns.returned(row), world.hits.hit(row));
  }
}

TEST(Returns, SeveralRaysABeamAreRowsOrderedByBeamAndRange) {
  const World world = makeSeveralReturns(3, 11);
  Returns returns;
  returns.start(findEchoes(world.hits, {}, 0), false);
  EXPECT_FALSE(returns.onePerBeam());
  std::size_t row = 0;
  for (std::uint32_t beam = 0; beam < 33; ++beam) {
    for (std::uint32_t number = 0; number < beam % 3; ++number, ++row) {
      ASSERT_LT(row, returns.size());
      EXPECT_EQ(returns.beam(row), beam);
      EXPECT_EQ(returns.number(row), number);
      EXPECT_EQ(returns.range[row], number == 0 ? 10 : 15);
      EXPECT_EQ(world.hits.beamOfRay[returns.hit(row)], beam);
      EXPECT_EQ(world.hits.range[returns.hit(row)], returns.range[row]);
      EXPECT_EQ(returns.cause(row), Reason::Surface);
    }
  }
  EXPECT_EQ(row, returns.size()) << "rays that meet nothing are no rows";
}

// A revolution that meets nothing, of which false positives are all there is: it has the columns that others have.
TEST(Returns, RowsThatAreAddedToNoneHaveTheirColumns) {
  World world = makeWorld(2, 5, 20);
  Returns returns;
  returns.start(findEchoes(makeSeveralReturns(1, 1).hits, {}, 0), false);  // a beam without a ray that meets something
  ASSERT_EQ(returns.size(), 0u);
  returns.add({.beam = 3, .range = 4, .power = 0.25f, .snr = 5}, world.hits);
  returns.add({.beam = 4, .range = 4, .power = 0.5f, .snr = 6}, world.hits);
  EXPECT_THAT(returns.power, testing::ElementsAre(0.25f, 0.5f));
  EXPECT_THAT(returns.snr, testing::ElementsAre(5.0f, 6.0f));
  EXPECT_THAT(returns.intensity, testing::SizeIs(2));
}

TEST(Returns, AddedRowsKeepTheOthersAndHaveNoHit) {
  const World world = makeWorld(2, 5, 20);
  Returns returns;
  returns.start(world.hits);
  returns.remove(3);
  const Returns before = returns;
  returns.add({.beam = 3, .range = 4, .power = 0.25f, .label = 77}, world.hits);
  returns.add({.beam = 3, .range = 2, .label = 78}, world.hits);
  ASSERT_EQ(returns.size(), 12u);
  for (std::size_t row = 0; row < before.size(); ++row) {
    EXPECT_EQ(returns.beam(row), before.beam(row));
    EXPECT_EQ(returns.hit(row), before.hit(row));
    EXPECT_EQ(returns.range[row], before.range[row]);
    EXPECT_EQ(returns.label[row], world.hits.semantic[row]);
    EXPECT_EQ(returns.instance[row], world.hits.instance[row]);
    EXPECT_EQ(returns.cause(row), Reason::Surface);
  }
  for (const std::size_t row : {10u, 11u}) {
    EXPECT_EQ(returns.beam(row), 3u);
    EXPECT_EQ(returns.hit(row), kNoHit);
    EXPECT_EQ(returns.number(row), row - 9) << "an address of randomness of its own";
    EXPECT_EQ(returns.cause(row), Reason::FalsePositive);
  }
  EXPECT_EQ(returns.power[10], 0.25f);
  EXPECT_EQ(returns.label[10], 77);
  EXPECT_EQ(returns.instance[10], 0u);
}

TEST(Returns, ABeamHasAtMostSixteen) {
  const World world = makeWorld(1, 2);
  Returns returns;
  returns.start(world.hits);
  for (int i = 0; i < 15; ++i) returns.add({.beam = 1, .range = 1}, world.hits);
  EXPECT_THROW(returns.add({.beam = 1, .range = 1}, world.hits), Error);
}

TEST(Returns, ATableIsStartedAnew) {
  const World several = makeSeveralReturns(3, 11);
  const World one = makeWorld(2, 3);
  Returns returns;
  returns.start(findEchoes(several.hits, {}, 0), false);
  returns.add({.beam = 0, .range = 3, .power = 1}, several.hits);
  returns.start(one.hits);
  EXPECT_TRUE(returns.onePerBeam());
  EXPECT_EQ(returns.size(), 6u);
  EXPECT_TRUE(returns.power.empty() && returns.label.empty() && returns.instance.empty());
}

}  // namespace
}  // namespace scanmill
