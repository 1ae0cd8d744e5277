#include "study/noise/noise_comparison.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

#include "config/fields.h"
#include "config/value.h"
#include "scan/hits.h"
#include "sense/sense.h"
#include "study/median.h"

namespace scanmill {

namespace {

Effects makeEffects(const std::string& yaml) {
  const Value root = parseYaml(yaml, "fitted effects");
  Effects made;
  for (const Value& item : root.find("effects")->items) {
    const Value::Entry& entry = item.entries.front();
    Fields options(entry.value, "effect " + entry.key);
    const EffectEntry& effect = requireEffect(entry.key, item.where);
    made.push_back({&effect, effect.make(options), {}});
  }
  return made;
}

// Returns the scan that the sensor would make of a world that consists only of the patches' planes. The patches must
// not overlap.
RecordedScan simulate(const BeamTable& beams, const BeamImage& image, const std::vector<const FlatPatch*>& patches,
                      const Effects& effects, std::uint32_t stream) {
  Shot shot;
  shot.seed = 1;
  shot.frame = stream;
  shot.beams = std::shared_ptr<const BeamTable>(std::shared_ptr<const BeamTable>(), &beams);
  shot.worldFromSensor.resize(1);
  Hits hits;
  hits.reset(beams.rings, beams.columns, Channel::Range);
  std::ranges::fill(hits.range, kMiss);
  for (const FlatPatch* patch : patches) {
    for (std::uint32_t row = 0; row < kPatchRings; ++row) {
      for (std::uint32_t column = 0; column < kPatchColumns; ++column) {
        const auto beam = image.beam(patch->window.row + row, patch->window.column + column);
        if (beam) hits.range[*beam] = static_cast<float>(rangeOnPlane(beams, *beam, patch->plane));
      }
    }
  }
  Returns returns;
  returns.range = hits.range;
  for (const auto& effect : effects) effect->apply(hits, shot, {}, returns);
  RecordedScan scan;
  for (const float range : returns.range) {
    scan.range.push_back(range < kMiss ? double{range} : std::numeric_limits<double>::quiet_NaN());
  }
  return scan;
}

ResidualSpread spreadOf(const std::vector<FlatPatch>& patches) {
  ResidualSpread spread;
  std::vector<const FlatPatch*> all;
  std::vector<double> planes;
  for (const FlatPatch& p : patches) {
    all.push_back(&p);
    spread.residuals.insert(spread.residuals.end(), p.residuals.begin(), p.residuals.end());
    if (p.planeFreedom > 0) planes.push_back(p.planeSquares / p.planeFreedom / chiSquareQuantile(p.planeFreedom, 0));
  }
  spread.deviation = commonDeviation(all);
  spread.planeDeviation = std::sqrt(medianOf(std::move(planes)));
  return spread;
}

bool fitted(const NoiseFit& fit, double range) {
  return std::ranges::any_of(fit.bands, [&](const PatchGroup& band) {
    return band.leftOut.empty() && range >= band.low && range < band.high;
  });
}

}  // namespace

std::vector<ResidualComparison> compareNoise(const BeamTable& beams, const std::vector<RecordedScan>& scans,
                                             const std::vector<FlatPatch>& patches, const NoiseFit& fit,
                                             const std::string& effects) {
  const BeamImage image(beams);
  const Effects made = makeEffects(effects);
  const double leastCosine = std::cos(fit.mostIncidence);
  std::vector<FlatPatch> recorded[2];  // [0]: patches at incidence angles up to fit.mostIncidence; [1]: above it
  std::vector<FlatPatch> simulated[2];
  for (std::uint32_t s = 0; s < scans.size(); ++s) {
    for (std::uint32_t tested = 0; tested < 2; ++tested) {
      // Patches of scan `s` whose tested beams have the colour `tested` of the chessboard (flat_patches.h). These
      // patches do not overlap.
      std::vector<const FlatPatch*> own;
      for (const FlatPatch& p : patches) {
        if (p.window.scan == s && p.window.tested == tested && fitted(fit, p.range)) own.push_back(&p);
      }
      const RecordedScan copy = simulate(beams, image, own, made, 2 * s + tested);
      for (const FlatPatch* p : own) {
        const std::size_t view = p->incidence >= leastCosine ? 0 : 1;
        recorded[view].push_back(*p);
        if (auto again = measurePatch(beams, image, copy, p->window)) simulated[view].push_back(std::move(*again));
      }
    }
  }
  std::vector<ResidualComparison> comparison;
  const std::string limit = fmt::format("{:.0f} deg", degrees(fit.mostIncidence));
  for (std::size_t view = 0; view < 2; ++view) {
    if (recorded[view].empty()) continue;
    comparison.push_back({(view == 0 ? "up to " : "more than ") + limit, recorded[view].size(),
                          spreadOf(recorded[view]), spreadOf(simulated[view])});
  }
  return comparison;
}

}  // namespace scanmill
