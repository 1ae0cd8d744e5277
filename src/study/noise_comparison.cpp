#include "study/noise_comparison.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

#include "base/parallel.h"
#include "config/fields.h"
#include "config/value.h"
#include "effects/effect.h"
#include "evaluate/registration.h"
#include "scan/hits.h"

namespace scanmill {

namespace {

using Effects = std::vector<std::unique_ptr<Effect>>;

Effects makeEffects(const std::string& yaml) {
  const Value root = parseYaml(yaml, "fitted effects");
  Effects made;
  for (const Value& item : root.find("effects")->items) {
    const Value::Entry& entry = item.entries.front();
    Fields options(entry.value, "effect " + entry.key);
    made.push_back(requireEffect(entry.key, item.where).make(options));
  }
  return made;
}

template <class Visit>
void forBeams(const BeamImage& image, const PatchWindow& window, Visit&& visit) {
  for (std::uint32_t row = 0; row < kPatchRings; ++row) {
    for (std::uint32_t column = 0; column < kPatchColumns; ++column) {
      if (const auto beam = image.beam(window.row + row, window.column + column)) visit(*beam);
    }
  }
}

// What the sensor would report of the patches' planes, all else being empty. The patches must not overlap.
RecordedScan simulate(const BeamTable& beams, const BeamImage& image, const std::vector<const FlatPatch*>& patches,
                      const Effects& effects, std::uint32_t stream) {
  Shot shot;
  shot.seed = 1;
  shot.frame = stream;
  shot.beams = std::shared_ptr<const BeamTable>(std::shared_ptr<const BeamTable>(), &beams);
  shot.worldFromSensor.resize(1);
  Hits hits;
  hits.reset(beams.rings, beams.columns, Channel::Range);
  std::fill(hits.range.begin(), hits.range.end(), kMiss);
  for (const FlatPatch* patch : patches) {
    forBeams(image, patch->window, [&](std::uint32_t beam) {
      hits.range[beam] = static_cast<float>(rangeOnPlane(beams, beam, patch->plane));
    });
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

std::vector<Vec3f> pointsOf(const BeamTable& beams, const BeamImage& image, const RecordedScan& scan,
                            const std::vector<const FlatPatch*>& patches) {
  std::vector<Vec3f> points;
  for (const FlatPatch* patch : patches) {
    forBeams(image, patch->window, [&](std::uint32_t beam) {
      if (std::isnan(scan.range[beam])) return;
      const Vec3d origin = beams.origin.empty() ? Vec3d{} : static_cast<Vec3d>(beams.origin[beam]);
      points.push_back(static_cast<Vec3f>(origin + beams.direction[beam] * scan.range[beam]));
    });
  }
  return points;
}

// Every n-th point: registration takes its time by points of the source, and needs no more of them.
std::vector<Vec3f> thinned(const std::vector<Vec3f>& points) {
  constexpr std::size_t kMost = 5000;
  const std::size_t stride = points.size() / kMost + 1;
  std::vector<Vec3f> kept;
  for (std::size_t i = 0; i < points.size(); i += stride) kept.push_back(points[i]);
  return kept;
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
  if (!planes.empty()) {
    const auto middle = planes.begin() + static_cast<std::ptrdiff_t>(planes.size() / 2);
    std::nth_element(planes.begin(), middle, planes.end());
    spread.planeDeviation = std::sqrt(*middle);
  }
  return spread;
}

bool fitted(const NoiseFit& fit, double range) {
  return std::any_of(fit.bands.begin(), fit.bands.end(), [&](const PatchGroup& band) {
    return band.leftOut.empty() && range >= band.low && range < band.high;
  });
}

}  // namespace

NoiseComparison compareNoise(const BeamTable& beams, const std::vector<RecordedScan>& scans,
                             const std::vector<FlatPatch>& patches, const NoiseFit& fit, const std::string& effects) {
  // Registered clouds: farther points have no partner; what is left after ICP is far smaller.
  constexpr IcpOptions kIcp{60, 1.0, 0.5};
  const BeamImage image(beams);
  const Effects made = makeEffects(effects);
  const double leastCosine = std::cos(fit.mostIncidence);
  std::vector<FlatPatch> recorded[2];  // steep, grazing
  std::vector<FlatPatch> simulated[2];
  std::vector<std::vector<Vec3f>> clouds[3];  // recorded, simulated, exact
  for (std::uint32_t s = 0; s < scans.size(); ++s) {
    for (std::uint32_t tested = 0; tested < 2; ++tested) {
      std::vector<const FlatPatch*> own;  // of one colour: they do not overlap
      for (const FlatPatch& p : patches) {
        if (p.window.scan == s && p.window.tested == tested && fitted(fit, p.range)) own.push_back(&p);
      }
      const RecordedScan copy = simulate(beams, image, own, made, 2 * s + tested);
      for (const FlatPatch* p : own) {
        const std::size_t view = p->incidence >= leastCosine ? 0 : 1;
        recorded[view].push_back(*p);
        if (auto again = measurePatch(beams, image, copy, p->window)) simulated[view].push_back(std::move(*again));
      }
      if (tested != 0) continue;
      clouds[0].push_back(pointsOf(beams, image, scans[s], own));
      clouds[1].push_back(pointsOf(beams, image, copy, own));
      clouds[2].push_back(pointsOf(beams, image, simulate(beams, image, own, {}, 0), own));
    }
  }
  NoiseComparison comparison;
  const std::string limit = fmt::format("{:.0f} deg", degrees(fit.mostIncidence));
  for (std::size_t view = 0; view < 2; ++view) {
    if (recorded[view].empty()) continue;
    comparison.residuals.push_back({(view == 0 ? "up to " : "more than ") + limit, recorded[view].size(),
                                    spreadOf(recorded[view]), spreadOf(simulated[view])});
  }
  const std::size_t pairs = scans.empty() ? 0 : scans.size() - 1;
  std::vector<Registered> registered(3 * pairs);
  parallelFor(registered.size(), 1, [&](std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i) {
      const auto& kind = clouds[i / pairs];
      registered[i] = registerClouds(thinned(kind[i % pairs + 1]), kind[i % pairs], kIcp);
    }
  });
  for (std::size_t p = 0; p < pairs; ++p) {
    comparison.fitness.push_back({fmt::format("{} on {}", scans[p + 1].name, scans[p].name), registered[p].fitness,
                                  registered[pairs + p].fitness, registered[2 * pairs + p].fitness,
                                  length(registered[p].targetFromSource.translation)});
  }
  return comparison;
}

}  // namespace scanmill
