// The same bytes on any number of threads, whatever a pipeline asks for: shards, manifest and recording.

#include "tests/core/pipeline/two_returns_yard.h"

namespace scanmill {
namespace {

struct OnThreads {
  const char* name;
  std::vector<std::string> overrides;
  bool recorded = false;    // hits are kept
  bool twoReturns = false;  // beams have two returns, one or none
};

const std::string kRandomNoise =
    "effects=[intensity: {output: u8}, dropout: {probability: 0.1, threshold: 0.0005}, range_noise: {sigma_m: 0.02}, "
    "angular_jitter: {sigma_deg: 0.05}, shell: {scale_m: 0.01}, quantize: {step_m: 0.004}]";
const std::string kWideBeams =
    "sensors=[{name: top, columns: 128, rate_hz: 10, elevation_deg: {top: 5, bottom: -25, rings: 16}, range_m: [0.5, "
    "100], mount: {position: [0, 0, 1.8]}, divergence_mrad: 3, pulse_ns: 5}]";

const OnThreads kCases[] = {
    {"SensorsFormatsAndSplits",
     {"sensors=[" + kTop + ", {name: front, columns: 100, rate_hz: 10, elevation_deg: [2, 0, -4], range_m: [1, 25]}]",
      "scenes.0.seeds=[1, 2, 3]", "splits={by: seed, train: [1], val: [2], test: [3]}", "motion=per_column",
      kRandomNoise, "output.formats=[pcd, draco: {max_error_mm: 2}, csv]"},
     true},
    {"ObjectsVoxelsAndMovement",
     {"motion={steps: per_column, deskew: true}", "output.objects=true",
      "output.columns=[label, instance, ring, column, velocity_x, radial_velocity]",
      "output.voxels={size: 0.5, from: [-45, -30, -2.5], to: [45, 30, 2.5]}"}},
    {"WeatherAndReasons",
     {kWideBeams, "output.reasons=true",
      "effects=[intensity, reflectance_variation: {}, speckle: {looks: 4}, weather: {kind: rain, severity: heavy}]"}},
    {"Footprints",
     {kWideBeams,
      "effects=[intensity, footprint: {rays: 7}, detection: {returns: dual, noise: 0.01}, range_noise: {over_snr_m: "
      "0.3}]"}},
    {"DrawnValues",
     {"scenes.0.seeds=[1, 2, 3]", "sensors.0.mount.position.2={uniform: [1.2, 2.4]}", "vehicle=vehicle",
      "effects=[{range_noise: {sigma_m: {uniform: [0.01, 0.2], per: frame}}}]"}},
    {"SeveralReturns",
     {kRandomNoise, "scenes.0.moving=false", "output.formats=[pcd, draco: {max_error_mm: 2}, csv]"},
     false,
     true},
    {"SeveralReturnsOrganised", {kRandomNoise, "scenes.0.moving=false", "output.layout=organised"}, false, true},
};

class Threads : public TwoReturnsYard, public testing::WithParamInterface<OnThreads> {
 protected:
  Threads() { folder_.write("scenes/yard.yaml", yardScene() + "    moving: {velocity: [1, 0, 0]}\n"); }
};

TEST_P(Threads, DoNotChangeAByte) {
  std::vector<MembersByName> bytes;
  for (const int threads : {1, 2, 8}) {
    const ThreadLimit limit(threads);
    const std::string name = fmt::format("t{}", threads);
    const std::filesystem::path hits = GetParam().recorded ? out("hits" + name) : std::filesystem::path();
    Pipeline pipeline = readPipeline(pipeline_, GetParam().overrides);
    if (GetParam().twoReturns) pipeline = withTwoReturns(pipeline);
    generate(makePlan(std::move(pipeline)), {.folder = out(name), .keepHits = hits, .quiet = true});
    EXPECT_THAT(verifyDataset(out(name)).problems, IsEmpty());
    MembersByName& made = bytes.emplace_back(shards(name));
    made["manifest.json"] = readFile(out(name) / "manifest.json");
    if (hits.empty()) continue;
    for (const auto& entry : std::filesystem::directory_iterator(hits)) {
      made[entry.path().filename().string()] = readFile(entry.path());
    }
  }
  EXPECT_TRUE(bytes[0] == bytes[1]);
  EXPECT_TRUE(bytes[0] == bytes[2]);
}

INSTANTIATE_TEST_SUITE_P(All, Threads, testing::ValuesIn(kCases),
                         [](const auto& c) { return std::string(c.param.name); });

}  // namespace
}  // namespace scanmill
