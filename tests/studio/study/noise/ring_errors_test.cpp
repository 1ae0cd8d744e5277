#include "base/random.h"
#include "study/noise/fit_noise.h"
#include "tests/studio/study/noise/noise_scans.h"

namespace scanmill {
namespace {

using testing::HasSubstr;
using testing::Not;

const std::vector<double> kWallDistances{3.5, 6, 8.5, 11, 13.5, 17};

double normal(std::uint32_t stream, std::uint32_t i) {
  const RandomBlock w = randomBlock({.scene = stream, .beam = i});
  return std::sqrt(-2 * std::log(uniform(w[0]))) * std::cos(2 * kPi * uniform(w[1]));
}

// Brightness of walls and floor with a gain of each ring and grain of each beam.
void light(std::vector<RecordedScan>& scans, const BeamTable& beams, double sigma) {
  for (std::uint32_t s = 0; s < scans.size(); ++s) {
    scans[s].intensity.assign(beams.size(), 0);
    for (std::uint32_t beam = 0; beam < beams.size(); ++beam) {
      const double gain = sigma * normal(50, beam / beams.columns);
      scans[s].intensity[beam] = static_cast<float>(40 * std::exp(gain + 0.1 * normal(60 + s, beam)));
    }
  }
}

NoiseFit fitOf(const std::string& effects, double gain) {
  const auto beams = wallBeams();
  std::vector<RecordedScan> recorded = recordedOf(wallScans(beams, kWallDistances, effects), *beams);
  light(recorded, *beams, gain);
  return fitNoise(*beams, recorded, findFlatPatches(*beams, recorded));
}

TEST(RingErrors, AreFoundAsWideAsTheyAre) {
  const NoiseFit fit = fitOf("[ring_bias: {range_sigma_m: 0.01}, range_noise: {sigma_m: 0.008}]", 0.2);
  EXPECT_GT(fit.rings.range.rings, 40u);
  EXPECT_GT(fit.rings.range.agreement, 0.9);
  EXPECT_NEAR(fit.rings.range.sigma, 0.01, 0.0025);
  EXPECT_GT(fit.rings.gain.agreement, 0.9);
  EXPECT_NEAR(fit.rings.gain.sigma, 0.2, 0.05);
  EXPECT_THAT(effectsYaml(fit, "today"), HasSubstr("ring_bias: {range_sigma_m: 0.0"));
}

// Walls and floor tell errors of the elevation from errors of the range, of either size.
TEST(RingErrors, OfElevationAreToldFromThoseOfRange) {
  struct Case {
    double range, elevation;  // m, deg
  };
  for (const Case& c : {Case{0.02, 0}, {0, 0.06}, {0.02, 0.06}}) {
    const NoiseFit fit = fitOf(fmt::format("[ring_bias: {{range_sigma_m: {}, elevation_sigma_deg: {}}}, range_noise: "
                                           "{{sigma_m: 0.008}}]",
                                           c.range, c.elevation),
                               0);
    EXPECT_NEAR(fit.rings.range.sigma, c.range, c.range > 0 ? 0.2 * c.range : 0.003)
        << c.range << " m, " << c.elevation << " deg";
    EXPECT_NEAR(degrees(fit.rings.elevation.sigma), c.elevation, c.elevation > 0 ? 0.2 * c.elevation : 0.01)
        << c.range << " m, " << c.elevation << " deg";
  }
}

TEST(RingErrors, NoiseIsNone) {
  const NoiseFit fit = fitOf("[range_noise: {sigma_m: 0.008}]", 0);
  EXPECT_LT(fit.rings.range.agreement, kOwnErrors);
  EXPECT_LT(fit.rings.range.sigma, 0.001);
  EXPECT_LT(fit.rings.gain.agreement, kOwnErrors);
  EXPECT_THAT(effectsYaml(fit, "today"), Not(HasSubstr("ring_bias")));
}

// Ring by ring: neighbours' differences are those that the effect has drawn.
TEST(RingErrors, AreThoseOfEachRing) {
  const auto beams = wallBeams();
  std::string offsets;
  std::vector<double> drawn;
  for (std::uint32_t ring = 0; ring < beams->rings; ++ring) {
    drawn.push_back(0.008 * normal(3, ring));
    offsets += (ring == 0 ? "" : ", ") + std::to_string(drawn.back());
  }
  const auto scans =
      wallScans(beams, kWallDistances, "[ring_bias: {range_m: [" + offsets + "]}, range_noise: {sigma_m: 0.008}]");
  const std::vector<RecordedScan> recorded = recordedOf(scans, *beams);
  const std::vector<FlatPatch> flat = findFlatPatches(*beams, recorded);
  std::vector<const FlatPatch*> patches;
  for (const FlatPatch& p : flat) patches.push_back(&p);
  const RingErrors errors = fitRingErrors(*beams, recorded, patches);
  double both = 0, truth = 0, found = 0;
  for (std::uint32_t ring = 20; ring + 2 < beams->rings; ++ring) {
    const double a = drawn[ring - 1] - 2 * drawn[ring] + drawn[ring + 1];
    const double b = errors.range.ofRing[ring - 1] - 2 * errors.range.ofRing[ring] + errors.range.ofRing[ring + 1];
    both += a * b;
    truth += a * a;
    found += b * b;
  }
  EXPECT_GT(both / std::sqrt(truth * found), 0.95);
}

// What is no noise stays, with its comments.
TEST(SensorEffects, KeepsWhatIsNoNoise) {
  const std::string file =
      "columns: 8\neffects:\n  # of light\n  - intensity: {output: u8}\n  # old\n  - dropout: "
      "{probability: 0.1}\n  - footprint: {rays: 7}\n  - ring_bias: {gain_sigma: 0.3}\nrate_hz: 10\n";
  const std::string noise = "effects:\n  # new\n  - range_noise: {sigma_m: 0.01}\n";
  EXPECT_EQ(withEffects(file, "s.yaml", noise),
            "columns: 8\neffects:\n  # of light\n  - intensity: {output: u8}\n  - footprint: {rays: 7}\n  - ring_bias: "
            "{gain_sigma: 0.3}\n  # new\n  - range_noise: {sigma_m: 0.01}\nrate_hz: 10\n");
  const std::string bias = noise + "  - ring_bias: {range_sigma_m: 0.02}\n";
  EXPECT_EQ(withEffects(file, "s.yaml", bias).find("gain_sigma"), std::string::npos);
  EXPECT_EQ(withEffects("columns: 8\neffects: [intensity]\n", "s.yaml", noise), "columns: 8\n" + noise);
}

}  // namespace
}  // namespace scanmill
