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

struct DropOutOptions {
  float threshold;     // least power that is reported; 0: any
  double probability;  // probability of losing a return at random
  bool instancesOnly;  // true: only returns of object instances are lost at random
  double rings;        // fraction of the rings that report nothing
};

class DropOut : public Effect {
 public:
  explicit DropOut(const DropOutOptions& options) : o_(options) {}

  Channels reads() const override {
    const Channels hits = Channel::Range;
    return o_.instancesOnly ? hits | Channels(Channel::Instance) : hits;
  }
  bool needsIntensity() const override { return o_.threshold > 0; }

  void apply(const Hits& hits, const Shot& shot, std::span<const Material>, Returns& returns) const override {
    if (o_.rings > 0) {
      loseRings(shot, returns);
      returns.recordLost(Reason::Dropped);
    }
    change(hits, shot, returns);
  }

 private:
  // Removes faint returns and randomly chosen returns, and sets the intensity of all removed rows to 0.
  SCANMILL_BEST_INSTRUCTIONS void change(const Hits& hits, const Shot& shot, Returns& returns) const {
    if (o_.threshold > 0) {
      loseFaint(returns);
      returns.recordFaint(returns.power, o_.threshold);
    }
    if (o_.probability > 0) loseAtRandom(hits, shot, returns);
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
      returns.range[row] = returns.power[row] >= o_.threshold ? returns.range[row] : kMiss;
    }
  }

  // Removes all returns of some rings: of all rings, the fraction o_.rings with the smallest random numbers is lost.
  void loseRings(const Shot& shot, Returns& returns) const {
    const std::uint32_t rings = shot.beams->rings;
    std::vector<std::pair<std::uint32_t, std::uint32_t>> lostRings;  // random number, ring
    for (std::uint32_t ring = 0; ring < rings; ++ring) {
      lostRings.emplace_back(
          randomBlock({.seed = shot.seed, .sensor = shot.sensor, .beam = ring, .purpose = Purpose::LostRings})[0],
          ring);
    }
    std::ranges::sort(lostRings);
    lostRings.resize(static_cast<std::size_t>(std::lround(o_.rings * rings)));
    std::vector<bool> isLost(rings, false);
    for (const auto& [number, ring] : lostRings) isLost[ring] = true;
    for (std::size_t row = 0; row < returns.size(); ++row) {
      if (isLost[returns.beam(row) / shot.beams->columns]) returns.remove(row);
    }
  }

  void loseAtRandom(const Hits& hits, const Shot& shot, Returns& returns) const {
    RandomWords words;
    forBatches(returns.range, [&](std::size_t first, std::size_t count) {
      float* const range = returns.range.data() + first;
      drawWords(shot, Purpose::DropOut, returns, first, words);
      Batch<std::uint8_t> isExempt{};  // 1: the row belongs to no instance
      for (std::size_t i = 0; o_.instancesOnly && i < count; ++i) {
        isExempt[i] = returns.instanceOf(first + i, hits) == 0 ? 1 : 0;
      }
      for (std::size_t i = 0; i < count; ++i) {
        const bool lost = (toDouble(words.a[i]) + 0.5) * 0x1p-32 < o_.probability && isExempt[i] == 0;
        range[i] = lost ? kMiss : range[i];
      }
    });
  }

  DropOutOptions o_;
};

}  // namespace

std::unique_ptr<Effect> makeDropOut(Fields& options) {
  const DropOutOptions o{.threshold = static_cast<float>(options.number("threshold", {0, 1e6}, 0)),
                         .probability = options.number("probability", {0, 1}, 0),
                         .instancesOnly = options.boolean("things", false),
                         .rings = options.number("rings", {0, 1}, 0)};
  options.finish();  // reports unknown keys first, since an unknown key may be a misspelt required key
  if (!options.has("threshold") && !options.has("probability") && !options.has("rings")) {
    throw InputError(options.where(), "effect dropout: give at least one of threshold, probability and rings");
  }
  if (o.instancesOnly && !options.has("probability")) {
    throw InputError(options.where(),
                     "effect dropout: `things` limits the returns that are lost at random: give `probability` too");
  }
  return std::make_unique<DropOut>(o);
}

}  // namespace scanmill
