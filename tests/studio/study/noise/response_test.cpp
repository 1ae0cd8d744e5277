// Scans of a place whose reflectances are known, seen through responses that are known.

#include "study/noise/response.h"

#include <functional>

#include "base/random.h"
#include "config/fields.h"
#include "config/value.h"
#include "sense/effect.h"
#include "tests/support/message_of.h"

namespace scanmill {
namespace {

using testing::HasSubstr;

double uniformAt(std::uint32_t frame, std::uint32_t beam, int word) {
  return uniform(randomBlock({.frame = frame, .beam = beam, .purpose = Purpose::Bootstrap})[word]);
}

double normalAt(std::uint32_t frame, std::uint32_t beam) {
  return std::sqrt(-2 * std::log(uniformAt(frame, beam, 2) + 1e-12)) * std::cos(2 * kPi * uniformAt(frame, beam, 3));
}

// Returns a scan of tiles of 0.25 m on the ground, 1.7 m below the sensor, whose reflectances are from .02 to 1, evenly
// in the logarithm, and of some bright specks. `respond`: maps a power and a range to the intensity.
Scan tiles(std::uint32_t place, const std::function<double(double power, double range, std::uint32_t beam)>& respond) {
  Scan scan;
  std::uint32_t beam = 0;
  for (int row = 0; row < 60; ++row) {
    for (int column = 0; column < 30; ++column) {
      const std::uint32_t tile = 1000 * static_cast<std::uint32_t>(row) + static_cast<std::uint32_t>(column);
      double reflectance = 0.02 * std::pow(50.0, uniformAt(place, tile, 0));
      if (uniformAt(place, tile, 1) > 0.99) reflectance = 50;
      for (int k = 0; k < 9; ++k) {
        const Vec3d p{3.03 + 0.6 * row + 0.05 * (k % 3), 0.03 + 0.6 * column + 0.05 * (k / 3), -1.7};
        const double range = length(p);
        const double power = reflectance * 100 / (range * range);
        scan.position.push_back(static_cast<Vec3f>(p));
        scan[kPower].push_back(static_cast<float>(power));
        scan[kIntensity].push_back(static_cast<float>(respond(power, range, beam++)));
      }
    }
  }
  return scan;
}

double nothing(double, double, std::uint32_t) {
  return 0;
}

// Returns the intensity that the fitted table gives for a value.
double at(const ResponseFit& fit, double value) {
  for (std::size_t k = 1; k < fit.table.size(); ++k) {
    const auto& [low, before] = fit.table[k - 1];
    const auto& [high, after] = fit.table[k];
    if (value <= high) return before + (after - before) * std::log(value / low) / std::log(high / low);
  }
  return fit.table.back().second;
}

// The places of both differ, and so do the numbers of scans.
ResponseFit fitOf(const std::function<double(double, double, std::uint32_t)>& respond) {
  return fitResponse({tiles(1, respond), tiles(2, respond), tiles(3, respond)},
                     {tiles(11, nothing), tiles(12, nothing), tiles(13, nothing), tiles(14, nothing)});
}

TEST(Response, FindsACurveOfReflectivities) {
  const auto curve = [](double value) { return 60 + 25 * std::log(value / 0.02); };
  const ResponseFit fit = fitOf([&](double power, double range, std::uint32_t) {
    return std::round(std::min(255.0, curve(power * range * range / 100)));
  });
  EXPECT_EQ(fit.model, ResponseModel::Reflectivity);
  EXPECT_TRUE(fit.bytes);
  EXPECT_EQ(fit.step, 0);
  EXPECT_EQ(fit.floor, 0);
  for (const double value : {0.03, 0.05, 0.1, 0.2, 0.4, 0.8}) EXPECT_NEAR(at(fit, value), curve(value), 4) << value;
  EXPECT_NEAR(fit.table.back().second, curve(50), 2);
  EXPECT_LT(fit.misfit, 0.05);
  EXPECT_GT(fit.otherMisfit, 2 * fit.misfit);
  EXPECT_LT(fit.noise, 0.005);
}

TEST(Response, FindsACurveOfPowers) {
  const ResponseFit fit = fitOf([](double power, double, std::uint32_t) { return 20 * std::sqrt(power); });
  EXPECT_EQ(fit.model, ResponseModel::Power) << fit.misfit << " " << fit.otherMisfit;
  EXPECT_FALSE(fit.bytes);
  for (const double power : {0.03, 0.1, 0.3}) EXPECT_NEAR(at(fit, power) / (20 * std::sqrt(power)), 1, 0.1) << power;
}

// Surfaces that differ more in the recording than in the simulated scans do not make the response steeper than linear.
TEST(Response, IsAtMostLinear) {
  const ResponseFit fit = fitOf(
      [](double power, double range, std::uint32_t) { return 0.01 * std::pow(power * range * range / 100, 1.6); });
  for (std::size_t k = 1; k < fit.table.size(); ++k) {
    const auto& [low, before] = fit.table[k - 1];
    const auto& [high, after] = fit.table[k];
    EXPECT_GE(after, before);
    EXPECT_LE(after / before, 1.001 * high / low);
  }
  EXPECT_NEAR(fit.slope, 1, 0.001);
}

TEST(Response, FindsFloorNoiseAndStep) {
  constexpr double kFloor = 0.02, kNoise = 0.05, kStep = 0.02;
  const ResponseFit fit = fitOf([](double power, double range, std::uint32_t beam) {
    const double value = std::max(0.0, power - kFloor) * range * range / 100;
    if (value <= 0) return 0.0;
    const double noisy = 0.9 + 0.15 * std::log(value) + kNoise * normalAt(99, beam);
    return kStep * std::round(std::max(0.0, noisy) / kStep);
  });
  EXPECT_EQ(fit.model, ResponseModel::Reflectivity);
  EXPECT_NEAR(fit.floor, kFloor, 0.3 * kFloor);
  EXPECT_NEAR(fit.noise, kNoise, 0.25 * kNoise);
  EXPECT_NEAR(fit.step, kStep, 1e-4);
  for (const double value : {0.1, 0.3, 0.8}) EXPECT_NEAR(at(fit, value), 0.9 + 0.15 * std::log(value), 0.05) << value;
}

// A recording of mostly near ground and simulated scans of mostly far ground have the same response.
TEST(Response, DoesNotDependOnHowManySurfacesAreNear) {
  const auto respond = [](double power, double range, std::uint32_t) { return 9 * std::sqrt(power) * range; };
  const auto without = [](Scan scan, double low, double high) {
    Scan kept;
    for (std::size_t i = 0; i < scan.size(); ++i) {
      const double range = length(Vec3d(scan.position[i]));
      if (range > low && range < high && i % 27 >= 9) continue;
      kept.position.push_back(scan.position[i]);
      kept[kPower].push_back(scan[kPower][i]);
      kept[kIntensity].push_back(scan[kIntensity][i]);
    }
    return kept;
  };
  const ResponseFit fit =
      fitResponse({without(tiles(1, respond), 20, 100), without(tiles(2, respond), 20, 100)},
                  {without(tiles(11, nothing), 0, 12), without(tiles(12, nothing), 0, 12), tiles(13, nothing)});
  for (const double value : {0.05, 0.2, 0.6}) EXPECT_NEAR(at(fit, value) / (90 * std::sqrt(value)), 1, 0.12) << value;
}

// The YAML makes an effect with the fitted full scale.
TEST(Response, IsAnEffect) {
  const ResponseFit fit = fitOf([](double power, double range, std::uint32_t) {
    return std::round(std::min(255.0, 10 * std::sqrt(power) * range));
  });
  const std::string yaml = "effects:\n" + responseYaml(fit, "oren_nayar", "towns");
  EXPECT_THAT(yaml, HasSubstr("# towns."));
  const Value item = parseYaml(yaml, "sensor.yaml").find("effects")->items.at(0);
  ASSERT_EQ(item.entries.front().key, "intensity");
  Fields options(item.entries.front().value, "effect");
  const auto effect = requireEffect("intensity", item.where).make(options);
  EXPECT_EQ(effect->intensityFullScale(), 255);
}

TEST(Response, SaysWhatIsMissing) {
  Scan bare = tiles(1, nothing);
  bare[kIntensity].clear();
  EXPECT_THAT(messageOf([&] { fitResponse({bare}, {tiles(2, nothing)}); }), HasSubstr("no intensities"));
  bare = tiles(1, nothing);
  bare[kPower].clear();
  EXPECT_THAT(messageOf([&] { fitResponse({tiles(2, nothing)}, {bare}); }), HasSubstr("`power` among"));
  EXPECT_THAT(messageOf([&] { fitResponse({tiles(2, nothing)}, {tiles(3, nothing)}); }), HasSubstr("all alike"));
  Scan few;
  few.position.assign(10, Vec3f{5, 0, -1});
  few[kIntensity].assign(10, 1);
  EXPECT_THAT(messageOf([&] { fitResponse({few}, {tiles(3, nothing)}); }), HasSubstr("give more scans"));
}

}  // namespace
}  // namespace scanmill
