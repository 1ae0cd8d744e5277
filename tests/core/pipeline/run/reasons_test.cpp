// For every beam a reason, and weather, from a pipeline to a dataset.

#include "formats/reasons_png.h"
#include "pipeline/run/run_shot.h"
#include "tests/core/pipeline/small_world.h"

namespace scanmill {
namespace {

const std::string kWideYard =
    "sensors=[{name: top, columns: 256, rate_hz: 10, elevation_deg: {top: 5, bottom: -25, rings: 16}, range_m: [0.5, "
    "100], mount: {position: [0, 0, 1.8]}, divergence_mrad: 3, pulse_ns: 5}]";
constexpr ColumnKey<columnIndex("cause")> kCauseColumn;

class ReasonsRun : public Yard {
 protected:
  static std::vector<std::string> with(const std::string& effects) {
    return {kWideYard, "effects=" + effects, "output.reasons=true",
            "output.columns=[intensity, label, ring, column, return, cause]"};
  }
};

TEST_F(ReasonsRun, AddUpAndAgreeWithTheScans) {
  const Manifest m = sound(with("[intensity, detection: {noise: 0.004}, weather: {kind: snow, severity: heavy}]"));
  const std::vector<Scan> all = scans();
  std::vector<ReasonsImage> images;
  for (const auto& [name, bytes] : members()) {
    if (name.ends_with(".reasons.png")) images.push_back(decodeReasons(bytes, name));
  }
  ASSERT_EQ(images.size(), m.samples.size());
  for (std::size_t s = 0; s < images.size(); ++s) {
    EXPECT_EQ(images[s].rings, 16u);
    EXPECT_EQ(images[s].columns, 256u);
    std::uint64_t sum = 0;
    for (const auto& [reason, beams] : m.samples[s].scans[0].beamsPerReason) sum += beams;
    EXPECT_EQ(sum, m.samples[s].scans[0].beams);
    std::vector<std::uint8_t> causes(images[s].reasonOfBeam.size());
    for (std::size_t i = 0; i < all[s].size(); ++i) {
      causes[all[s][kRing][i] * 256u + all[s][kColumn][i]] = all[s][kCauseColumn][i];
    }
    for (std::size_t beam = 0; beam < causes.size(); ++beam) {
      const std::uint8_t reason = images[s].reasonOfBeam[beam];
      ASSERT_EQ(reason < 16 ? reason : 0, causes[beam]) << beam;
    }
    EXPECT_GT(countReasons(images[s].reasonOfBeam)[6], 10u);
  }
}

TEST_F(ReasonsRun, CostNothingWhereNobodyAsks) {
  std::vector<std::string> quiet = with("[intensity]");
  quiet[2] = "output.reasons=false";
  const Manifest m = sound(quiet);
  for (const auto& [name, bytes] : members()) EXPECT_FALSE(name.ends_with(".png"));
  EXPECT_TRUE(m.samples[0].scans[0].beamsPerReason.empty());
  EXPECT_EQ(toJson(m).find("\"reasons\""), std::string::npos);
}

TEST_F(ReasonsRun, WeatherAloneReportsTheStrongest) {
  const Plan plan = planOf(with("[intensity, weather: {kind: rain}]"));
  EXPECT_EQ(plan.pipeline.mostReturns(), 1u);
  expectInputError([&] { planOf(with("[weather: {kind: rain}]")); }, {"weather", "intensity"});
}

TEST_F(ReasonsRun, AForgedImageIsFound) {
  sound(with("[intensity, dropout: {probability: 0.1}]"));
  const std::filesystem::path shard = out() / readManifest(out()).shards[0].file;
  std::string bytes = readFile(shard);
  const std::size_t at = bytes.find("IDAT");
  ASSERT_NE(at, std::string::npos);
  bytes[at + 20] = static_cast<char>(bytes[at + 20] ^ 0x55);
  writeFile(shard, bytes);
  EXPECT_THAT(verifyDataset(out()).problems, Contains(HasSubstr("reasons.png")));
}

}  // namespace
}  // namespace scanmill
