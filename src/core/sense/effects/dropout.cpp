// dropout: returns that the sensor does not report.
//
//   dropout: {threshold: 0.002}      # returns with less power than this are lost; 1 is a white target at the
//                                    # reference range of the intensity effect, before gain and saturation
//   dropout: {probability: 0.01}     # returns are lost at random, independent from beam to beam
//   dropout: {probability: 0.8, things: true}     # only returns of object instances are lost, as with dark paint
//   dropout: {rings: 0.25}           # a random quarter of a sensor's rings, the same in all frames, reports nothing
//
// All keys may be given together. A threshold needs the intensity effect.

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "base/instruction_sets.h"
#include "base/random.h"
#include "sense/effects/batches.h"
#include "sense/effects/makers.h"

namespace scanmill {
namespace {

class DropOut : public Effect {
 public:
  DropOut(float threshold, double probability, bool instancesOnly, double rings)
      : threshold_(threshold), probability_(probability), instancesOnly_(instancesOnly), rings_(rings) {}

  Channels reads() const override {
    const Channels hits = Channel::Range;
    return instancesOnly_ ? hits | Channels(Channel::Instance) : hits;
  }
  bool needsIntensity() const override { return threshold_ > 0; }

  void apply(const Hits& hits, const Shot& shot, std::span<const Material>, Returns& returns) const override {
    if (rings_ > 0) {
      loseRings(shot, returns);
      returns.recordLost(Reason::Dropped);
    }
    change(hits, shot, returns);
  }

 private:
  SCANMILL_BEST_INSTRUCTIONS void change(const Hits& hits, const Shot& shot, Returns& returns) const {
    if (threshold_ > 0) {
      loseFaint(returns);
      returns.recordFaint(returns.power, threshold_);
    }
    if (probability_ > 0) loseAtRandom(hits, shot, returns);
    returns.recordLost(Reason::Dropped);
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

  // Removes the returns of the fraction `rings_` of the rings, rounded to complete rings. These are the rings with the
  // smallest random numbers.
  void loseRings(const Shot& shot, Returns& returns) const {
    const std::uint32_t rings = shot.beams->rings;
    std::vector<std::pair<std::uint32_t, std::uint32_t>> ranks;
    for (std::uint32_t ring = 0; ring < rings; ++ring) {
      ranks.emplace_back(
          randomBlock({.seed = shot.seed, .sensor = shot.sensor, .beam = ring, .purpose = Purpose::LostRings})[0],
          ring);
    }
    std::sort(ranks.begin(), ranks.end());
    ranks.resize(static_cast<std::size_t>(std::lround(rings_ * rings)));
    std::vector<bool> lost(rings, false);
    for (const auto& [rank, ring] : ranks) lost[ring] = true;
    for (std::size_t row = 0; row < returns.size(); ++row) {
      if (lost[returns.beam(row) / shot.beams->columns]) returns.range[row] = kMiss;
    }
  }

  void loseAtRandom(const Hits& hits, const Shot& shot, Returns& returns) const {
    RandomWords words;
    forBatches(returns.range, [&](std::size_t first, std::size_t count) {
      float* const range = returns.range.data() + first;
      drawWords(shot, Purpose::DropOut, returns, first, words);
      Batch<std::uint8_t> spared{};
      for (std::size_t i = 0; instancesOnly_ && i < count; ++i)
        spared[i] = returns.instanceOf(first + i, hits) == 0 ? 1 : 0;
      for (std::size_t i = 0; i < count; ++i) {
        const bool lost = (toDouble(words.a[i]) + 0.5) * 0x1p-32 < probability_ && spared[i] == 0;
        range[i] = lost ? kMiss : range[i];
      }
    });
  }

  float threshold_;
  double probability_;
  bool instancesOnly_;
  double rings_;
};

}  // namespace

std::unique_ptr<Effect> makeDropOut(Fields& options) {
  const double threshold = options.number("threshold", {0, 1e6}, 0);
  const double probability = options.number("probability", {0, 1}, 0);
  const bool things = options.boolean("things", false);
  const double rings = options.number("rings", {0, 1}, 0);
  options.finish();  // reports unknown keys first, since an unknown key may be a misspelt required key
  if (!options.has("threshold") && !options.has("probability") && !options.has("rings")) {
    throw InputError(options.where(), "effect dropout: give at least one of threshold, probability and rings");
  }
  if (things && !options.has("probability")) {
    throw InputError(options.where(),
                     "effect dropout: `things` limits the returns that are lost at random: give `probability` too");
  }
  return std::make_unique<DropOut>(static_cast<float>(threshold), probability, things, rings);
}

}  // namespace scanmill
