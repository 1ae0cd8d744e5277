// speckle: the granular interference pattern of laser light on rough surfaces. The power of each return is multiplied
// by a random factor.
//
//   speckle: {looks: 12}
//
// Light that a rough surface scatters interferes with itself. Averaged over `looks` independent patterns, the relative
// power at the detector follows the gamma distribution with mean 1 and variance 1 / looks, which for one look is the
// exponential distribution (Goodman, "Statistical properties of laser speckle patterns", in Laser Speckle and Related
// Phenomena, 1975). The factor is sampled exactly: the sum of `looks` exponential numbers is minus the logarithm of the
// product of `looks` uniform numbers. Factors are independent from return to return.

#include "base/instruction_sets.h"
#include "sense/effects/batches.h"
#include "sense/effects/makers.h"

namespace scanmill {
namespace {

constexpr int kMostLooks = 30;  // largest number of looks; a product of 30 numbers >= 2^-33 is a normal double

class Speckle : public Effect {
 public:
  explicit Speckle(int looks) : looks_(looks) {}

  bool setsGain() const override { return true; }

  void apply(const Hits&, const Shot& shot, std::span<const Material>, Returns& returns) const override {
    returns.gain.resize(returns.size(), 1.0f);
    change(shot, returns);
  }

 private:
  SCANMILL_BEST_INSTRUCTIONS void change(const Shot& shot, Returns& returns) const {
    Batch<double> product;
    forBatches(returns.range, [&](std::size_t first, std::size_t count) {
      product.fill(1.0);
      for (int look = 0; look < looks_; look += 4) {
        const auto purpose = static_cast<Purpose>(static_cast<int>(Purpose::Speckle) + look / 4);
        // A block has four words, and each word gives a factor. Factors beyond the number of looks are 1.
        const int remaining = looks_ - look;
        const double isLook[] = {1, remaining > 1 ? 1.0 : 0.0, remaining > 2 ? 1.0 : 0.0, remaining > 3 ? 1.0 : 0.0};
        drawBlocks(shot, purpose, returns, first, [&](std::size_t i, const RandomBlock& block) {
          double factor[4];
          for (std::size_t k = 0; k < 4; ++k) factor[k] = 1 + isLook[k] * ((toDouble(block[k]) + 0.5) * 0x1p-32 - 1);
          product[i] *= (factor[0] * factor[1]) * (factor[2] * factor[3]);
        });
      }
      float* const gain = returns.gain.data() + first;
      for (std::size_t i = 0; i < count; ++i) gain[i] *= static_cast<float>(naturalLog(product[i]) * (-1.0 / looks_));
    });
  }

  int looks_;
};

}  // namespace

std::unique_ptr<Effect> makeSpeckle(Fields& options) {
  options.also({"looks"}).finish();
  const int looks = static_cast<int>(options.integer("looks", 1, kMostLooks));
  options.finish();
  return std::make_unique<Speckle>(looks);
}

}  // namespace scanmill
