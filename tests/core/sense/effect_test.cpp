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

TEST(Effects, BadOptionsAreRefused) {
  const std::vector<std::pair<std::string, std::string>> wrong{
      {"angular_jitter: {}", "give either sigma_deg or azimuth_sigma_deg and elevation_sigma_deg"},
      {"angular_jitter: {sigma_deg: 6}", "sigma_deg must be a number from 0 to 5"},
      {"angular_jitter: {sigma_deg: -1}", "sigma_deg must be a number from 0 to 5"},
      {"angular_jitter: {sigma_deg: 1, azimuth_sigma_deg: 1}",
       "give either sigma_deg or azimuth_sigma_deg and elevation_sigma_deg"},
      {"range_walk: {}", "per_decade_m"},
      {"detection: {sun: {azimuth_deg: 0, elevation_deg: 10, noise: 1}}", "need `noise`"},
      {"detection: {returns: seventeen}", "strongest"},
      {"detection: {returns: 17}", "returns must be a whole number from 1 to 16"},
      {"detection: {returns: 0}", "returns must be a whole number from 1 to 16"},
      {"detection: {threshold: 5}", "noise"},
      {"footprint: {}", "rays"},
      {"footprint: {rays: 8}", "19"},
      {"dropout: {things: true, rings: 0.5}", "give `probability`"},
      {"dropout: {}", "threshold"},
      {"dropout: {probability: 1.5}", "probability must be a number from 0 to 1"},
      {"dropout: {threshold: -1}", "threshold must be a number from 0 to 1000000"},
      {"dropout: {probabilty: 0.5}", "probab"},
      {"intensity: {gian: 2}", "gain"},
      {"intensity: {falloff: cubic}", "falloff may not be 'cubic' (known: inverse_square, none)"},
      {"intensity: {reference_range_m: 0}", "reference_range_m must be a number from 0.1 to 1000"},
      {"intensity: {saturation: 0}", "saturation must be a number from 1e-09 to 1e+30"},
      {"intensity: {attenuation_per_m: -1}", "attenuation_per_m must be a number from 0 to 10"},
      {"intensity: {gain: .nan}", "gain must be a number from 0 to 1000000000"},
      {"intensity: {retro_full_scale: 100}", "model: reflectivity"},
      {"intensity: {model: reflectivity, retro_full_scale: 100}", "output: u8"},
      {"intensity: {model: reflectivity, output: u8, retro_full_scale: 100, gamma: 2}", "gamma"},
      {"intensity: {model: reflectivty}", "reflectivity"},
      {"intensity: {diffuse: rough}", "diffuse may not be 'rough' (known: lambertian, oren_nayar)"},
      {"intensity: {table: [[1, 2]]}", "at least two pairs"},
      {"intensity: {table: [[1, 2], [1, 3]]}", "rise from row to row"},
      {"intensity: {table: [[0, 2], [1, 3]]}", "above 0"},
      {"intensity: {table: [[1, 2, 3], [2, 3]]}", "[value, intensity]"},
      {"intensity: {output: u8, table: [[1, 2], [2, 300]]}", "at most 255"},
      {"intensity: {gamma: 2, table: [[1, 2], [2, 3]]}", "leave out gamma"},
      {"quantize: {}", "the key 'step_m' is missing"},
      {"quantize: {step_m: 0}", "step_m must be a number from 1e-06 to 10"},
      {"quantize: {step_m: -1}", "step_m must be a number from 1e-06 to 10"},
      {"range_noise: {}", "sigma_m"},
      {"range_noise: {sigma_m: -0.1}", "sigma_m must be a number from 0 to 100"},
      {"range_noise: {table: []}", "table must be a list of [range, sigma] pairs in metres"},
      {"range_noise: {table: 3}", "table must be a list of [range, sigma] pairs in metres"},
      {"range_noise: {table: [[1, 2, 3]]}", "table: each row is [range, sigma] in metres"},
      {"range_noise: {table: [[5, 0.1], [5, 0.2]]}", "rise"},
      {"range_noise: {table: [[5, 0.1]], sigma_m: 1}",
       "give either a table or sigma_m and sigma_per_m (beside `sensor`,"},
      {"range_noise: {sigma: 0.1, sigma_m: 0.1}", "test.yaml:1"},
      {"relief: {height: 1}", "height"},
      {"relief: {strength: -1}", "strength"},
      {"ring_bias: {}", "range"},
      {"ring_bias: {gain: [1], gain_sigma: 0.1}", "either gain or gain_sigma"},
      {"ring_bias: {range_m: [0.1, x]}", "range_m"},
      {"ring_bias: {range_sigma: 0.1}", "range_sigma_m"},
      {"shell: {}", "give scale_m, growth_per_m or both"},
      {"shell: {growth_per_m: 0.6}", "growth_per_m must be a number from 0 to 0.5"},
      {"shell: {scale: 1}", "unknown key 'scale' (did you mean 'scale_m'?)"},
      {"speckle: {}", "looks"},
      {"speckle: {looks: 0}", "looks must be a whole number from 1 to 30"},
      {"speckle: {looks: 31}", "looks must be a whole number from 1 to 30"},
      {"speckle: {looks: 2.5}", "looks must be a whole number from 1 to 30"},
      {"weather: {}", "kind"},
      {"weather: {kind: hail}", "rain"},
      {"weather: {kind: fog, rate_mm_h: 3}", "by `visibility_m`"},
      {"weather: {kind: fog, severity: heavy, visibility_m: 30}", "not both"},
  };
  for (const auto& [yaml, words] : wrong) EXPECT_THAT(refusal(yaml), testing::HasSubstr(words)) << yaml;
}

// Effects of size 0 change no bit.
TEST(Effects, ZeroKeepsEveryBit) {
  const World world = makeRaggedWorld(33, 77);
  for (const char* yaml : {"range_noise: {sigma_m: 0}", "range_noise: {sigma_m: 0, sigma_per_m: 0}",
                           "range_noise: {table: [[1, 0], [50, 0]]}", "angular_jitter: {sigma_deg: 0}",
                           "shell: {scale_m: 0}", "dropout: {probability: 0, threshold: 0}",
                           "ring_bias: {range_sigma_m: 0, elevation_sigma_deg: 0, gain_sigma: 0}"}) {
    const Returns returns = run(world, {yaml});
    EXPECT_EQ(returns.range, world.hits.range) << yaml;
    EXPECT_TRUE(returns.displacement.empty()) << yaml;
    EXPECT_TRUE(returns.gain.empty()) << yaml;
  }
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
