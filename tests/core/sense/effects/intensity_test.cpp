#include <limits>

#include "tests/core/sense/world.h"

namespace scanmill {
namespace {

constexpr float kTiny = 1e-6f;

float intensityAt(float range, float incidence, const Material& material, const std::string& options = "{}") {
  World world = makeWorld(1, 1, range);
  world.hits.incidence[0] = incidence;
  world.hits.reflectance[0] = material.reflectance;
  world.materials[0] = material;
  return run(world, {"intensity: " + options}).intensity[0];
}

Material matt(float reflectance) {
  return {.name = "matt", .reflectance = reflectance, .source = "", .texture = {}};
}

Material surface(float reflectance, float roughness, float metallic) {
  Material material = matt(reflectance);
  material.roughness = roughness;
  material.metallic = metallic;
  return material;
}

TEST(Intensity, WhiteTargetAtTheReferenceRangeIsExactlyOne) {
  EXPECT_EQ(intensityAt(10, 1, matt(1)), 1.0f);
  EXPECT_EQ(intensityAt(25, 1, matt(1), "{reference_range_m: 25}"), 1.0f);
  EXPECT_EQ(intensityAt(10, 1, matt(1), "{output: u8}"), 255.0f);
}

TEST(Intensity, LambertsCosine) {
  for (int degree = 0; degree <= 90; ++degree) {
    const float c = std::max(0.0f, static_cast<float>(std::cos(radians(degree))));
    EXPECT_NEAR(intensityAt(10, c, matt(0.4f)), 0.4f * c, kTiny);
  }
}

TEST(Intensity, InverseSquareOfTheRange) {
  for (float range : {1.0f, 2.0f, 5.0f, 20.0f, 100.0f, 1e4f}) {
    const float expected = 0.3f * 100 / (range * range);
    EXPECT_NEAR(intensityAt(range, 1, matt(0.3f)) / expected, 1, 1e-6);
    EXPECT_EQ(intensityAt(range, 1, matt(0.3f), "{falloff: none}"), 0.3f);
  }
}

TEST(Intensity, NearTargetsGainNothingBelowTheNearRange) {
  const float at2 = intensityAt(2, 1, matt(0.3f), "{near_range_m: 2}");
  for (float range : {0.0f, 1e-3f, 0.5f, 1.9f}) {
    EXPECT_EQ(intensityAt(range, 1, matt(0.3f), "{near_range_m: 2}"), at2);
  }
  EXPECT_LT(intensityAt(2.1f, 1, matt(0.3f), "{near_range_m: 2}"), at2);
}

TEST(Intensity, AirAttenuatesBothWays) {
  for (float range : {1.0f, 10.0f, 50.0f, 200.0f}) {
    const double factor = intensityAt(range, 1, matt(0.5f), "{attenuation_per_m: 0.01}") /
                          static_cast<double>(intensityAt(range, 1, matt(0.5f)));
    EXPECT_NEAR(factor / std::exp(-2 * 0.01 * range), 1, 1e-6);
  }
  EXPECT_EQ(intensityAt(1e4f, 1, matt(0.5f), "{attenuation_per_m: 10}"), 0);
}

TEST(Intensity, RetroreflectorsAddToTheDiffusePart) {
  Material sign = matt(0.2f);
  sign.retroreflectance = 30;
  EXPECT_NEAR(intensityAt(10, 1, sign), 30.2f, 1e-5);
  EXPECT_NEAR(intensityAt(10, 0.5f, sign), 15.1f, 1e-5);
}

TEST(Intensity, SpecularPeakHasItsClosedForm) {
  for (float roughness : {0.1f, 0.3f, 0.6f, 1.0f}) {
    const double alpha = static_cast<double>(roughness) * roughness;
    EXPECT_NEAR(intensityAt(10, 1, surface(0.8f, roughness, 1)) / (0.8 / (4 * alpha * alpha)), 1, 1e-5);
    const double glossy = 0.04 * (1 - alpha);
    const double expected = 0.8 * (1 - glossy) + glossy / (4 * alpha * alpha);
    EXPECT_NEAR(intensityAt(10, 1, surface(0.8f, roughness, 0)) / expected, 1, 1e-5);
  }
}

// The normals of a microfacet surface cover its area once: the integral of D cos over the hemisphere is 1. Of a white
// metal the return is pi D G / (4 cos), so D comes back from it with Smith's G = 2 / (1 + sqrt(1 + alpha^2 tan^2)).
// Without G the integral is bounded by 1: no energy is made.
TEST(Intensity, MicrofacetsCoverTheSurfaceOnce) {
  for (float roughness : {0.2f, 0.5f, 0.8f, 1.0f}) {
    constexpr int kSteps = 20000;
    World world = makeWorld(1, kSteps);
    world.materials[0] = surface(1, roughness, 1);
    const auto angle = [](int i) { return (i + 0.5) / kSteps * (kPi / 2); };
    for (int i = 0; i < kSteps; ++i) world.hits.incidence[i] = static_cast<float>(std::cos(angle(i)));
    const Returns returns = run(world, {"intensity: {}"});
    const double alpha = static_cast<double>(roughness) * roughness;
    double area = 0;
    double masked = 0;
    for (int i = 0; i < kSteps; ++i) {
      const double t = angle(i);
      const double masking = 2 / (1 + std::sqrt(1 + alpha * alpha * std::tan(t) * std::tan(t)));
      const double slice =
          returns.intensity[i] * 4 * std::cos(t) / kPi * std::cos(t) * 2 * kPi * std::sin(t) * (kPi / 2 / kSteps);
      area += slice / masking;
      masked += slice;
    }
    EXPECT_NEAR(area, 1, 1e-3) << roughness;
    EXPECT_LT(masked, 1);
  }
}

TEST(Intensity, ResponseAmplifiesSaturatesAndBends) {
  EXPECT_NEAR(intensityAt(10, 1, matt(0.3f), "{gain: 5}"), 1.5f, kTiny);
  EXPECT_EQ(intensityAt(10, 1, matt(0.3f), "{gain: 5, saturation: 1.25}"), 1.25f);
  EXPECT_NEAR(intensityAt(10, 1, matt(0.25f), "{gamma: 0.5}"), 0.5f, kTiny);
  EXPECT_EQ(intensityAt(10, 1, matt(0), "{gamma: 0.5}"), 0);
  EXPECT_EQ(intensityAt(10, 1, matt(0.3f), "{gain: 0}"), 0);
}

TEST(Intensity, BytesAreWholeNumbersUpTo255) {
  const std::string options = "{output: u8, gain: 2, saturation: 4}";
  for (float reflectance = 0; reflectance <= 1; reflectance += 0.01f) {
    const float value = intensityAt(10, 1, matt(reflectance), options);
    EXPECT_EQ(value, std::floor(255 * (2 * reflectance * 0.25f) + 0.5f));
  }
  EXPECT_EQ(intensityAt(1, 1, matt(1), options), 255);
  EXPECT_EQ(intensityAt(10, 1, matt(0.25f), "{output: u8, gamma: 0.5}"), 128);
}

TEST(Intensity, ExtremesAreFiniteAndNeverNegative) {
  for (float range : {0.0f, 1e-3f, 1.0f, 1e4f, 3e38f}) {
    for (float c : {0.0f, 1e-30f, 1e-4f, 1.0f}) {
      for (float roughness : {0.0f, 0.5f, 1.0f}) {
        for (float metallic : {0.0f, 1.0f}) {
          for (const char* options : {"{}", "{output: u8, gain: 1e9}", "{attenuation_per_m: 10, gamma: 10, gain: 1e9}",
                                      "{near_range_m: 0.001, reference_range_m: 1000, gain: 1e9, gamma: 10}"}) {
            const float value = intensityAt(range, c, surface(1, roughness, metallic), options);
            EXPECT_TRUE(std::isfinite(value)) << range << " " << c << " " << roughness << options;
            EXPECT_GE(value, 0);
          }
        }
      }
    }
  }
  Material broken = matt(std::numeric_limits<float>::quiet_NaN());
  EXPECT_EQ(intensityAt(10, 1, broken), 0);
}

TEST(Intensity, MissesAndUnknownMaterials) {
  World world = makeWorld(3, 300);
  for (std::size_t beam = 0; beam < 700; ++beam) miss(world, beam);
  world.hits.material[800] = 65535;
  const Returns returns = run(world, {"intensity: {}"});
  for (std::size_t beam = 0; beam < 700; ++beam) EXPECT_EQ(returns.intensity[beam], 0);
  for (std::size_t beam = 700; beam < 900; ++beam) EXPECT_EQ(returns.intensity[beam], 1);
  EXPECT_EQ(returns.range, world.hits.range);
}

// Passes drawn by others bring the look of each beam with them; the same figures give the same bits.
TEST(Intensity, TheLookOfABeamStandsForItsMaterials) {
  World world = makeRaggedWorld(4, 100);
  world.materials = {surface(1, 0.1f, 0), surface(1, 0.5f, 1), surface(1, 0.9f, 0.3f)};
  world.materials[2].retroreflectance = 5;
  for (std::uint32_t beam = 0; beam < world.hits.size(); ++beam) {
    world.hits.material[beam] = static_cast<std::uint16_t>(beam % 3);
    world.hits.incidence[beam] = static_cast<float>(beam % 11) / 10;
    world.hits.reflectance[beam] = static_cast<float>(beam % 7) / 7;
  }
  const Returns table = run(world, {"intensity: {}"});
  for (const std::uint16_t m : world.hits.material) {
    world.hits.roughness.push_back(world.materials[m].roughness);
    world.hits.metallic.push_back(world.materials[m].metallic);
    world.hits.retroreflectance.push_back(world.materials[m].retroreflectance);
  }
  std::fill(world.hits.material.begin(), world.hits.material.end(), std::uint16_t{0});
  EXPECT_EQ(run(world, {"intensity: {}"}).intensity, table.intensity);
  world.hits.retroreflectance[10] += 1;  // a hit
  EXPECT_NE(run(world, {"intensity: {}"}).intensity, table.intensity);
}

// The same surface tells the same from any range, through any air; what arrives still falls off.
TEST(Intensity, ReflectivityKnowsNeitherRangeNorAir) {
  for (const float range : {2.0f, 10.0f, 50.0f, 120.0f}) {
    World world = makeWorld(1, 1, range);
    world.hits.reflectance[0] = 0.3f;
    world.hits.incidence[0] = 0.5f;
    const Returns returns = run(world, {"intensity: {model: reflectivity, attenuation_per_m: 0.01}"});
    EXPECT_NEAR(returns.intensity[0], 0.15, 1e-6) << range;
    EXPECT_NEAR(returns.power[0] / (0.15 * 100 / (range * range) * std::exp(-0.02 * range)), 1, 1e-5) << range;
  }
}

// The column `power` is what arrives, whatever the model reports; without the effect there is none.
TEST(Intensity, ThePowerIsWhatArrives) {
  const World world = makeRaggedWorld(4, 16);
  const ScanLayout layout{.columns = ColumnSet(kIntensity, kPower)};
  const Scan power = senseOnce(world, {"intensity: {}"}, layout);
  const Scan reflectivity = senseOnce(world, {"intensity: {model: reflectivity}"}, layout);
  EXPECT_EQ(power[kPower], power[kIntensity]);
  EXPECT_EQ(reflectivity[kPower], power[kPower]);
  EXPECT_NE(reflectivity[kIntensity], power[kIntensity]);
  EXPECT_TRUE(senseOnce(world, {}, layout)[kPower].empty());
}

// Velodyne, VLP-16 User Manual, section 6.1: 0 to 100 for 0 to 100 %, 101 to 255 for retroreflectors.
TEST(Intensity, BytesOfReflectivityAreThoseOfTheManuals) {
  const auto byteOf = [](double reflectivity) {
    World world = makeWorld(1, 1);
    world.hits.reflectance[0] = 1;
    world.materials[0].reflectance = 1;
    world.materials[0].retroreflectance = static_cast<float>(reflectivity - 1);
    if (reflectivity <= 1) {
      world.hits.reflectance[0] = static_cast<float>(reflectivity);
      world.materials[0].retroreflectance = 0;
    }
    return run(world, {"intensity: {model: reflectivity, output: u8, retro_full_scale: 1000}"}).intensity[0];
  };
  for (int percent = 0; percent <= 100; ++percent) EXPECT_EQ(byteOf(percent / 100.0), static_cast<float>(percent));
  EXPECT_EQ(byteOf(10), 152.0f);  // a third of the way to 1000, in logarithms
  EXPECT_EQ(byteOf(100), 203.0f);
  EXPECT_EQ(byteOf(1000), 255.0f);
  EXPECT_EQ(byteOf(5000), 255.0f);
}

// Oren and Nayar 1994, eq. 30, with the sensor where the light comes from.
TEST(Intensity, RoughSurfacesFollowOrenAndNayar) {
  for (const double roughness : {0.5, 0.9, 1.0}) {
    Material material = surface(0.4f, static_cast<float>(roughness), 0);
    const double s = std::atan(roughness * roughness / std::sqrt(2.0));
    const double a = 1 - 0.5 * s * s / (s * s + 0.33);
    const double b = 0.45 * s * s / (s * s + 0.09);
    for (int degree = 0; degree < 90; degree += 5) {
      const double t = radians(degree);
      const float c = static_cast<float>(std::cos(t));
      const double lambert = intensityAt(10, c, material);
      const double rough = intensityAt(10, c, material, "{diffuse: oren_nayar}");
      const double matt = 0.4 * (1 - 0.04 * (1 - roughness * roughness));
      const double expected = lambert + matt * (std::cos(t) * (a - 1 + b * std::sin(t) * std::tan(t)));
      EXPECT_NEAR(rough, expected, 2e-6) << roughness << ' ' << degree;
    }
  }
  Material mirror = surface(0.4f, 0.0f, 0);
  EXPECT_EQ(intensityAt(10, 0.3f, mirror, "{diffuse: oren_nayar}"), intensityAt(10, 0.3f, mirror)) << "no slopes";
}

// The curve passes its rows, is linear in the logarithm between them, and constant outside.
TEST(Intensity, ResponseTable) {
  const auto at = [](float value, const std::string& more = "") {
    return intensityAt(10, 1, matt(value), "{table: [[0.01, 0.2], [0.1, 0.6], [1, 0.7]]" + more + "}");
  };
  EXPECT_NEAR(at(0.01f), 0.2f, kTiny);
  EXPECT_NEAR(at(0.1f), 0.6f, kTiny);
  EXPECT_NEAR(at(1), 0.7f, kTiny);
  EXPECT_NEAR(at(0.001f), 0.2f, kTiny);
  EXPECT_NEAR(at(5), 0.7f, kTiny);
  EXPECT_NEAR(at(std::sqrt(0.001f)), 0.4f, kTiny);
  EXPECT_EQ(at(0), 0);
  EXPECT_NEAR(at(std::sqrt(0.001f), ", step: 0.15"), 0.45f, kTiny);
  EXPECT_EQ(intensityAt(10, 1, matt(1), "{output: u8, table: [[0.01, 3], [0.1, 99.6]]}"), 100);
}

// The factor at a range multiplies what the model gives there, and does not change the received power.
TEST(Intensity, RangeResponse) {
  const std::string response = ", range_response: [[5, 2], [20, 0.5]]}";
  for (const std::string model : {"power", "reflectivity"}) {
    for (const auto& [range, factor] :
         {std::pair{3.0f, 2.0f}, {5.0f, 2.0f}, {10.0f, 1.25f}, {20.0f, 0.5f}, {80.0f, 0.5f}}) {
      const std::string options = "{floor: 0.001, model: " + model;
      const float plain = intensityAt(range, 1, matt(0.3f), options + "}");
      EXPECT_NEAR(intensityAt(range, 1, matt(0.3f), options + response) / plain, factor, 1e-6f) << model << range;
    }
  }
}

// The floor is compared with the received power: dark surfaces near and bright ones far report 0 alike, whatever the
// model, and the returns stay.
TEST(Intensity, FloorOfTheReceivedPower) {
  for (const std::string model : {"power", "reflectivity"}) {
    for (const float range : {5.0f, 10.0f, 20.0f, 40.0f}) {
      for (const float reflectance : {0.02f, 0.1f, 0.5f}) {
        const float received = reflectance * 100 / (range * range);
        const float intensity = intensityAt(range, 1, matt(reflectance), "{floor: 0.03, model: " + model + "}");
        EXPECT_EQ(intensity > 0, received > 0.03f) << range << " " << reflectance;
      }
    }
  }
}

// Noise of the intensity has the given deviation and mean 0, is independent from beam to beam, the same each time, and
// makes no intensity negative.
TEST(Intensity, NoiseOfTheReportedNumber) {
  const World world = makeWorld(64, 2048, 10);
  const auto intensities = [&](const std::string& more) {
    return run(world, {"intensity: {gain: 0.5" + more + "}"}).intensity;
  };
  const std::vector<float> exact = intensities("");
  const std::vector<float> noisy = intensities(", noise: 0.02");
  EXPECT_EQ(noisy, intensities(", noise: 0.02"));
  const auto n = static_cast<double>(exact.size());
  double sum = 0;
  double squares = 0;
  double neighbours = 0;
  for (std::size_t i = 0; i < exact.size(); ++i) {
    const double off = double{noisy[i]} - double{exact[i]};
    sum += off;
    squares += off * off;
    if (i > 0) neighbours += off * (double{noisy[i - 1]} - double{exact[i - 1]});
  }
  EXPECT_NEAR(sum / n, 0, 4 * 0.02 / std::sqrt(n));
  EXPECT_NEAR(std::sqrt(squares / n), 0.02, 4 * 0.02 / std::sqrt(2 * n));
  EXPECT_NEAR(neighbours / squares, 0, 4 / std::sqrt(n));
  for (const float value : intensities(", noise: 1")) EXPECT_GE(value, 0);
  const std::vector<float> bytes = run(world, {"intensity: {output: u8, gain: 0.5, noise: 0.02, step: 0.1}"}).intensity;
  for (const float value : bytes) EXPECT_NEAR(std::remainder(value, 25.5f), 0, 0.51f);
}

}  // namespace
}  // namespace scanmill
