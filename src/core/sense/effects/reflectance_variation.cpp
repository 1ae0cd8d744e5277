// reflectance_variation: the reflectance of a surface varies from place to place: patches of asphalt, blades of grass,
// brickwork, dirt.
//
//   reflectance_variation: {}                # as much as the table of materials says
//   reflectance_variation: {strength: 0.5}   # half as much
//
// The reflectance at a point is the reflectance of the material times exp(sum of c_k n_k - c_k^2 / 2). Each of the
// material's `variations` has a contrast c_k and a size, and n_k is a Gaussian field of variance 1 over cubes of that
// size (spatial_noise.h). The result is a log-normal distribution whose mean is the material's reflectance.
//
// A beam averages over its width: if the sensor file gives the width, the variance c_k^2 is divided by 1 + area of the
// beam / size^2, as for the mean of this many independent patches.

#include <algorithm>
#include <cmath>

#include "base/instruction_sets.h"
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
    const PositionsOfHits positionsOfHits(hits, shot, returns);
    std::vector<SpatialField> fields;
    for (std::uint32_t k = 0; k < kMostVariations; ++k) {
      fields.emplace_back(shot.seed, Purpose::ReflectanceVariation, k);
    }
    // The variations of each material; the last entry is for rows without a hit or without a material.
    std::vector<const std::vector<Variation>*> variationsOf;
    const std::vector<Variation> none;
    for (const Material& m : materials) variationsOf.push_back(&m.variations);
    variationsOf.push_back(&none);
    // Values of the rows of a batch. `area`: area that the beam illuminates (m^2). `size` (m, later cubes per metre)
    // and `contrast` belong to one variation. `exponent`: natural logarithm of the factor on the reflectance.
    Positions positions;
    Batch<const std::vector<Variation>*> variations;
    Batch<double> area, size, contrast, exponent;
    for (std::size_t first = 0; first < returns.size(); first += kBatch) {
      const std::size_t count = std::min(kBatch, returns.size() - first);
      std::size_t mostVariations = 0;  // largest number of variations of a row
      for (std::size_t i = 0; i < kBatch; ++i) {
        variations[i] = &none;
        area[i] = 0;
        if (i >= count || !returns.returned(first + i) || returns.hit(first + i) == kNoHit) continue;
        const std::uint32_t hit = returns.hit(first + i);
        variations[i] = variationsOf[std::min<std::size_t>(hits.material[hit], materials.size())];
        area[i] = beamArea(*shot.beams, double{hits.range[hit]});
        mostVariations = std::max(mostVariations, variations[i]->size());
      }
      if (mostVariations == 0) continue;
      positionsOfHits.compute(first, positions);
      exponent.fill(0);
      for (std::size_t k = 0; k < mostVariations; ++k) {
        for (std::size_t i = 0; i < kBatch; ++i) {
          const Variation variation = k < variations[i]->size() ? (*variations[i])[k] : Variation{};
          size[i] = double{variation.size};
          contrast[i] = double{variation.contrast};
        }
        averageOverFootprint(area, size, contrast, exponent);
        fields[k].add(positions, size, contrast, exponent);
      }
      multiply(exponent, count, returns.gain.data() + first);
    }
  }

 private:
  // Multiplies the contrasts by the effect's strength and averages them over the beams' areas (m^2), replaces sizes by
  // cubes per metre, and subtracts half the variances from the exponents.
  SCANMILL_BEST_INSTRUCTIONS void averageOverFootprint(const Batch<double>& area, Batch<double>& size,
                                                       Batch<double>& contrast, Batch<double>& exponent) const {
    for (std::size_t i = 0; i < kBatch; ++i) {
      contrast[i] = strength_ * contrast[i] / std::sqrt(1 + area[i] / (size[i] * size[i]));
      exponent[i] -= contrast[i] * contrast[i] / 2;
      size[i] = 1.0 / size[i];
    }
  }

  SCANMILL_BEST_INSTRUCTIONS static void multiply(const Batch<double>& exponent, std::size_t count, float* gain) {
    for (std::size_t i = 0; i < count; ++i) gain[i] *= static_cast<float>(exponential(exponent[i]));
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
