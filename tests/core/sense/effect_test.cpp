#include <set>

#include "sense/sense.h"
#include "tests/core/sense/world.h"

namespace scanmill {
namespace {

TEST(Effects, RowsAreUniqueAndRunInTheOrderOfPhysics) {
  std::set<std::string_view> names;
  for (const EffectEntry& entry : effects()) {
    EXPECT_TRUE(names.insert(entry.name).second) << entry.name;
    EXPECT_FALSE(entry.summary.empty());
    EXPECT_NE(entry.make, nullptr);
  }
  const auto stage = [](std::string_view name) { return requireEffect(name, {}).stage; };
  EXPECT_LT(stage("speckle"), stage("intensity"));
  EXPECT_LT(stage("ring_bias"), stage("intensity"));
  EXPECT_LT(stage("intensity"), stage("dropout"));
  EXPECT_LT(stage("dropout"), stage("range_noise"));
  EXPECT_EQ(stage("range_noise"), stage("shell"));
  EXPECT_LT(stage("range_noise"), stage("quantize"));
  EXPECT_LT(stage("quantize"), stage("angular_jitter"));
}

TEST(Effects, UnknownNamesAreRefusedWithASuggestion) {
  expectInputError([] { requireEffect("range_nois", {"p.yaml", 3, 5}); }, {"p.yaml:3:5", "range_noise"});
}

TEST(Effects, ChannelsAreThoseThatSomebodyNeeds) {
  const ColumnSet bare = ColumnSet::byDefault().without(kLabel).without(kInstance);
  EXPECT_EQ(channelsFor({}, bare), Channels(Channel::Range));
  EXPECT_EQ(channelsFor({}, ColumnSet::byDefault()), Channel::Range | Channel::Semantic | Channels(Channel::Instance));
  const auto noise = makeEffects({"range_noise: {sigma_m: 1}"});
  EXPECT_EQ(channelsFor(noise, bare), Channels(Channel::Range));
  const auto lit = makeEffects({"intensity: {}", "dropout: {threshold: 0.1}"});
  EXPECT_EQ(channelsFor(lit, bare),
            Channel::Range | Channel::Material | Channels(Channel::Reflectance) | Channel::Incidence);
  EXPECT_EQ(channelsFor({}, bare.with(kIncidence)), Channel::Range | Channel::Incidence);
  EXPECT_TRUE(lit[0]->setsIntensity());
  EXPECT_FALSE(lit[1]->setsIntensity());
}

}  // namespace
}  // namespace scanmill
