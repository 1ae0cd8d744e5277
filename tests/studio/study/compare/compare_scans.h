#pragma once

// Scans of a place that is known: ground at 2 m below the sensor, a round wall 18 m away, and posts before it.

#include <random>
#include <utility>
#include <vector>

#include "scan/scan.h"
#include "scene/ontology.h"
#include "study/compare/compare.h"

namespace scanmill {

// What is done to the exact scan.
struct Flaws {
  double sigma = 0.005;   // m, of ranges
  double lost = 0;        // share of beams
  double ringOffset = 0;  // m, deviation of each ring's own
  double ringGain = 0;    // deviation of the logarithm
  double speckle = 0.05;  // deviation of the intensity, in parts
  double mixed = 0;       // share of points at edges that lie between
  double scale = 1;       // of intensities
};

constexpr std::uint32_t kTestRings = 32, kTestColumns = 720;

// A number of deviation 1 for each ring of the sensor.
inline std::vector<double> ofRings(unsigned seed) {
  std::mt19937 sensor(seed);
  std::normal_distribution<double> normal;
  std::vector<double> numbers(kTestRings);
  for (double& number : numbers) number = normal(sensor);
  return numbers;
}
constexpr unsigned kOffsets = 98, kGains = 99;  // seeds

inline Scan flawedScan(const Flaws& flaws, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform(0, 1);
  const std::vector<double> offset = ofRings(kOffsets), gain = ofRings(kGains);
  Scan scan;
  scan.rings = kTestRings;
  scan.columns = kTestColumns;
  constexpr double kWall = 18;
  const auto exact = [&](double azimuth, double elevation) {
    double range = kWall / std::cos(elevation);
    int label = 2;
    if (elevation < 0 && -2 / std::sin(elevation) < range) {
      range = -2 / std::sin(elevation);
      label = 1;
    }
    // A post every 6 degrees, 8 m away and 0.3 m wide.
    const double beside = std::remainder(azimuth + 0.01 * seed, kPi / 30);
    if (std::fabs(beside) < 0.15 / 8 && 8 / std::cos(elevation) < range) {
      range = 8 / std::cos(elevation);
      label = 3;
    }
    return std::pair(range, label);
  };
  for (std::uint32_t c = 0; c < kTestColumns; ++c) {
    for (std::uint32_t r = 0; r < kTestRings; ++r) {
      const double azimuth = 2 * kPi * c / kTestColumns;
      const double elevation = radians(5 - 30.0 * r / (kTestRings - 1));
      auto [range, label] = exact(azimuth, elevation);
      const double next = exact(azimuth + 2 * kPi / kTestColumns, elevation).first;
      if (std::fabs(next - range) > 1.5 && uniform(random) < flaws.mixed) range += (next - range) * uniform(random);
      if (uniform(random) < flaws.lost) continue;
      range += flaws.sigma * normal(random) + flaws.ringOffset * offset[r];
      scan.position.push_back({static_cast<float>(range * std::cos(elevation) * std::cos(azimuth)),
                               static_cast<float>(range * std::cos(elevation) * std::sin(azimuth)),
                               static_cast<float>(range * std::sin(elevation))});
      const double patchy = 1 + 0.2 * std::sin(3 * azimuth);
      scan[kIntensity].push_back(
          static_cast<float>(flaws.scale * 0.2 * label * patchy * std::exp(flaws.ringGain * gain[r]) *
                             std::max(0.0, 1 + flaws.speckle * normal(random))));
      scan[kLabel].push_back(static_cast<std::uint16_t>(label));
      scan[kRing].push_back(static_cast<std::uint16_t>(r));
      scan[kColumn].push_back(static_cast<std::uint16_t>(c));
    }
  }
  return scan;
}

inline std::vector<Scan> flawedScans(const Flaws& flaws, unsigned firstSeed, unsigned count = 2) {
  std::vector<Scan> scans;
  for (unsigned i = 0; i < count; ++i) scans.push_back(flawedScan(flaws, firstSeed + i));
  return scans;
}

inline Ontology testClasses() {
  Ontology ontology;
  ontology.name = "test";
  ontology.classes = {{0, "unlabeled", {}, false, {}, {}},
                      {1, "ground", {}, false, {}, {}},
                      {2, "wall", {}, false, {}, {}},
                      {3, "post", {}, false, {}, {}}};
  return ontology;
}

inline ScanSet setOf(const Flaws& flaws, unsigned firstSeed, bool labelled = true) {
  return measureScans("set", flawedScans(flaws, firstSeed), labelled ? std::optional(testClasses()) : std::nullopt);
}

}  // namespace scanmill
