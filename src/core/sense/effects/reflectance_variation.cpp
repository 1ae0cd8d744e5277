// reflectance_variation: the reflectance of a surface varies from place to place: patches of asphalt, blades of grass,
// brickwork, dirt.
//
//   reflectance_variation: {}                # as much as the table of materials says
//   reflectance_variation: {strength: 0.5}   # half as much
//
// The reflectance at a point is the reflectance of the material times exp(sum of c_k n_k - c_k^2 / 2). Each of the
// material's `variations` has a contrast c_k and a size, and n_k is a Gaussian field of variance 1 over cubes of that
// size (spatial_noise.h). The result is a log-normal distribution whose mean is the material's reflectance. The fields
// depend only on the point in the world and the pipeline's seed, so that every frame, sensor and method finds the same
// patches.
//
// A beam averages over its width: if the sensor file gives the width, the variance c_k^2 is divided by 1 + area of the
// beam / size^2, as for the mean of this many independent patches.

#include <algorithm>
#include <cmath>

#include "sense/effects/makers.h"
#include "sense/effects/spatial_noise.h"
#include "sensors/footprint.h"

namespace scanmill {
namespace {

class ReflectanceVariation : public Effect {
 public:
  explicit ReflectanceVariation(double strength) : strength_(strength) {}

  Channels reads() const override { return Channel::Range | Channel::Material; }
  bool setsGain() const override { return true; }

  void apply(const Hits& hits, const Shot& shot, std::span<const Material> materials, Returns& returns) const override {
    returns.gain.resize(returns.size(), 1.0f);
    const PlacesOfHits hitPlaces(hits, shot, returns);
    std::vector<SpatialField> fields;
    for (std::uint32_t k = 0; k < kMostVariations; ++k) {
      fields.emplace_back(shot.seed, Purpose::ReflectanceVariation, k);
    }
    Places places;
    Batch<Variation> variation;
    Batch<double> cubes;
    Batch<double> contrast;
    Batch<double> exponent;
    for (std::size_t first = 0; first < returns.size(); first += kBatch) {
      const std::size_t count = std::min(kBatch, returns.size() - first);
      exponent.fill(0);
      bool placed = false;
      for (std::uint32_t k = 0; k < kMostVariations; ++k) {
        bool any = false;
        for (std::size_t i = 0; i < kBatch; ++i) {
          variation[i] = i < count ? variationOf(hits, materials, returns, first + i, k) : Variation{};
          any = any || variation[i].contrast > 0;
        }
        if (!any) break;
        if (!placed) hitPlaces.find(first, places);
        placed = true;
        for (std::size_t i = 0; i < kBatch; ++i) {
          cubes[i] = 1.0 / double{variation[i].size};
          contrast[i] = 0;
          if (variation[i].contrast == 0) continue;
          contrast[i] = seenContrast(variation[i], *shot.beams, hits.range[returns.hit(first + i)]);
          exponent[i] -= contrast[i] * contrast[i] / 2;
        }
        fields[k].add(places, cubes, contrast, exponent);
      }
      for (std::size_t i = 0; i < count && placed; ++i) {
        returns.gain[first + i] *= static_cast<float>(exponential(exponent[i]));
      }
    }
  }

 private:
  // Returns variation k of the material of a row's hit. The contrast is 0 if the row has no hit, or the material has no
  // variation k.
  static Variation variationOf(const Hits& hits, std::span<const Material> materials, const Returns& returns,
                               std::size_t row, std::uint32_t k) {
    if (!returns.returned(row) || returns.hit(row) == kNoHit) return {};
    const std::uint16_t material = hits.material[returns.hit(row)];
    if (material >= materials.size() || k >= materials[material].variations.size()) return {};
    return materials[material].variations[k];
  }

  double seenContrast(const Variation& variation, const BeamTable& beams, float range) const {
    const double area = beamArea(beams, range);
    const double size = variation.size;
    return strength_ * variation.contrast / std::sqrt(1 + area / (size * size));
  }

  double strength_;
};

}  // namespace

std::unique_ptr<Effect> makeReflectanceVariation(Fields& options) {
  const double strength = options.number("strength", {0, 10}, 1);
  options.finish();
  return std::make_unique<ReflectanceVariation>(strength);
}

}  // namespace scanmill
