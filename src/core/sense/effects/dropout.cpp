// dropout: returns that the sensor does not report.
//
//   dropout: {threshold: 0.002}      # returns with less power than this are lost; 1 is a white target at the
//                                    # reference range of the intensity effect, before gain and saturation
//   dropout: {probability: 0.01}     # lost at random, independent from beam to beam
//
// Both may be given. A threshold needs the intensity effect.

#include "base/instruction_sets.h"
#include "sense/effects/batches.h"
#include "sense/effects/makers.h"

namespace scanmill {
namespace {

class DropOut : public Effect {
 public:
  DropOut(float threshold, double probability) : threshold_(threshold), probability_(probability) {}

  Channels reads() const override { return Channel::Range; }
  bool needsIntensity() const override { return threshold_ > 0; }

  void apply(const Hits&, const Shot& shot, std::span<const Material>, Returns& returns) const override {
    change(shot, returns);
  }

 private:
  SCANMILL_BEST_INSTRUCTIONS void change(const Shot& shot, Returns& returns) const {
    if (threshold_ > 0) {
      loseFaint(returns);
      returns.noteFaint(returns.power, threshold_);
    }
    if (probability_ > 0) loseAtRandom(shot, returns);
    returns.noteLost(Reason::Dropped);
    if (returns.intensity.empty()) return;
    for (std::size_t row = 0; row < returns.size(); ++row) {
      returns.intensity[row] = returns.range[row] < kMiss ? returns.intensity[row] : 0.0f;
    }
  }

  void loseFaint(Returns& returns) const {
    if (returns.power.size() != returns.size()) {
      throw InputError("effect dropout: a threshold needs the effect intensity");
    }
    for (std::size_t row = 0; row < returns.size(); ++row) {
      returns.range[row] = returns.power[row] >= threshold_ ? returns.range[row] : kMiss;
    }
  }

  void loseAtRandom(const Shot& shot, Returns& returns) const {
    RandomWords words;
    forBatches(returns.range, [&](std::size_t first, std::size_t count) {
      float* const range = returns.range.data() + first;
      drawWords(shot, Purpose::DropOut, returns, first, words);
      for (std::size_t i = 0; i < count; ++i) {
        range[i] = (toDouble(words.a[i]) + 0.5) * 0x1p-32 < probability_ ? kMiss : range[i];
      }
    });
  }

  float threshold_;
  double probability_;
};

}  // namespace

std::unique_ptr<Effect> makeDropOut(Fields& options) {
  const double threshold = options.number("threshold", {0, 1e6}, 0);
  const double probability = options.number("probability", {0, 1}, 0);
  options.finish();  // first: a misspelt key is the likelier reason for the lack of one
  if (!options.has("threshold") && !options.has("probability")) {
    throw InputError(options.where(), "effect dropout: give threshold, probability or both");
  }
  return std::make_unique<DropOut>(static_cast<float>(threshold), probability);
}

}  // namespace scanmill
