#include "sense/sense.h"
#include "tests/core/sense/several_returns.h"

namespace scanmill {
namespace {

std::vector<std::uint8_t> reasonsOnce(const World& world, const std::vector<std::string>& effects) {
  ScanLayout layout;
  layout.reasons = true;
  return senseOnce(world, effects, layout).reasonOfBeam;
}

Reason reasonOfFirst(const World& world, const std::vector<std::string>& effects) {
  return static_cast<Reason>(reasonsOnce(world, effects).front());
}

TEST(ReasonsOf, AreThoseOfReturnsAndMisses) {
  World world = makeWorld(2, 4);
  miss(world, 1);
  miss(world, 3);
  world.hits.unresolved = {3};
  const auto reasons = reasonsOnce(world, {});
  EXPECT_EQ(reasons, (std::vector<std::uint8_t>{1, 16, 1, 23, 1, 1, 1, 1}));
  EXPECT_TRUE(senseOnce(world, {}).reasonOfBeam.empty()) << "nobody asked";
}

TEST(ReasonsOf, TellWhatIsTooFaintFromWhatIsLostAtRandom) {
  World world = makeWorld(1, 1000);
  for (std::size_t beam = 0; beam < 500; ++beam) world.hits.reflectance[beam] = 0.01f;
  const ReasonCounts counts =
      countReasons(reasonsOnce(world, {"intensity: {}", "dropout: {threshold: 0.1, probability: 0.3}"}));
  EXPECT_EQ(counts.at(18), 500u);
  EXPECT_NEAR(static_cast<double>(counts.at(22)), 150, 60);
  EXPECT_EQ(counts.at(1), 500 - counts.at(22));
}

TEST(ReasonsOf, MirrorsAndGlassAreNoDarkSurfaces) {
  World world = makeWorld(1, 1);
  world.hits.reflectance[0] = 0.01f;
  world.hits.incidence[0] = 0.5f;
  const std::vector<std::string> effects{"intensity: {}", "dropout: {threshold: 0.1}"};
  EXPECT_EQ(reasonOfFirst(world, effects), Reason::TooFaint);
  world.materials[0].roughness = 0.02f;
  EXPECT_EQ(reasonOfFirst(world, effects), Reason::MirroredAway);
  world.materials[0].transmission = 0.6f;
  world.hits.glassIsClear = true;
  EXPECT_EQ(reasonOfFirst(world, effects), Reason::LostInGlass);
  world.hits.material[0] = kNoMaterial;
  EXPECT_EQ(reasonOfFirst(world, effects), Reason::TooFaint);
}

TEST(ReasonsOf, TheAirHasWhatWouldBeFoundWithoutIt) {
  World world = makeWideWorld(1, 1, 40);
  const std::vector<std::string> effects{"weather: {kind: dust, visibility_m: 50, least: 1}", "intensity: {}",
                                         "dropout: {threshold: 0.02}"};
  EXPECT_EQ(reasonOfFirst(world, effects), Reason::LostInAir);
  world.hits.reflectance[0] = 0.1f;
  EXPECT_EQ(reasonOfFirst(world, effects), Reason::TooFaint) << "it would be lost in clear air too";
}

// Neither what would be lost in clear air, nor drops that nobody sees, nor loss at random is the air's.
TEST(ReasonsOf, ThinAirIsBlamedForNothing) {
  World world = makeWideWorld(1, 400, 40);
  for (std::size_t beam = 0; beam < 100; ++beam) miss(world, beam);
  for (std::size_t beam = 100; beam < 200; ++beam) world.hits.reflectance[beam] = 0.01f;
  const std::vector<std::string> effects{"weather: {kind: fog, visibility_m: 100000, least: 0.000001}", "intensity: {}",
                                         "detection: {noise: 0.001}", "dropout: {probability: 0.2}"};
  const ReasonCounts counts = countReasons(reasonsOnce(world, effects));
  EXPECT_EQ(counts.at(16), 100u);
  EXPECT_NEAR(static_cast<double>(counts.at(18)), 100, 2);
  EXPECT_EQ(counts.count(21), 0u);
  EXPECT_NEAR(static_cast<double>(counts.at(22)), 40, 25);
}

TEST(ReasonsOf, TheNearestReturnSpeaksForItsBeam) {
  World world = makeWideWorld(1, 200, 30);
  const std::vector<std::string> snow{"weather: {kind: snow, severity: heavy}", "intensity: {}"};
  const ReasonCounts counts = countReasons(reasonsOnce(world, snow));
  const Returns returns = run(world, snow);
  std::vector<bool> flakes(200);
  for (std::size_t row = 0; row < returns.size(); ++row) {
    if (returns.cause(row) == Reason::Weather) flakes[returns.beam(row)] = true;
  }
  const auto expected = static_cast<std::uint64_t>(std::count(flakes.begin(), flakes.end(), true));
  ASSERT_GT(expected, 10u);
  EXPECT_EQ(counts.at(6), expected);
  EXPECT_EQ(counts.at(1), 200 - expected);
}

TEST(ReasonsOf, TheEgoVehicleBlocksWhatItIsNearerThan) {
  World world = makeWorld(1, 3);
  world.hits.pathOfRay = {RayPath::EgoVehicle, RayPath::EgoVehicle, RayPath::Direct};
  miss(world, 1);
  EXPECT_EQ(reasonsOnce(world, {}), (std::vector<std::uint8_t>{5, 17, 1}));
}

TEST(ReasonsOf, SumUpWhereBeamsHaveSeveralRays) {
  const World world = makeSeveralReturns(4, 30);
  const ReasonCounts counts = countReasons(reasonsOnce(world, {"intensity: {}", "detection: {returns: all}"}));
  EXPECT_EQ(counts, (ReasonCounts{{1, 80}, {16, 40}}));
  const ReasonCounts none =
      countReasons(reasonsOnce(world, {"intensity: {}", "detection: {returns: all}", "dropout: {probability: 1}"}));
  EXPECT_EQ(none, (ReasonCounts{{22, 80}, {16, 40}}));
}

}  // namespace
}  // namespace scanmill
