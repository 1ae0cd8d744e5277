#include "study/noise/noise_comparison.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

#include "base/parallel.h"
#include "config/fields.h"
#include "config/value.h"
#include "evaluate/registration.h"
#include "scan/hits.h"
#include "sense/sense.h"

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

Vec3d cornerOf(const BeamTable& beams, std::uint32_t beam, const PatchPlane& plane) {
  const Vec3d origin = beams.origin.empty() ? Vec3d{} : static_cast<Vec3d>(beams.origin[beam]);
  return origin + beams.direction[beam] * rangeOnPlane(beams, beam, plane);
}

PlanePiece pieceOf(const BeamTable& beams, const BeamImage& image, const FlatPatch& patch) {
  const auto at = [&](std::uint32_t row, std::uint32_t column) {
    return cornerOf(beams, *image.beam(patch.window.row + row, patch.window.column + column), patch.plane);
  };
  PlanePiece piece{at(kPatchRings / 2, kPatchColumns / 2), normalized(patch.plane), 0};
  for (const std::uint32_t row : {0u, kPatchRings - 1}) {
    for (const std::uint32_t column : {0u, kPatchColumns - 1}) {
      piece.reach = std::max(piece.reach, length(at(row, column) - piece.center));
    }
  }
  return piece;
}

// Of the source, moved onto the target.
std::optional<double> fitnessAt(const PlaneMotion& motion, const std::vector<Vec3f>& source,
                                const std::vector<Vec3f>& target) {
  constexpr double kWithin = 0.5;  // m; farther points have no partner
  if (!motion.failure.empty()) return {};
  std::vector<Vec3f> moved;
  moved.reserve(source.size());
  for (const Vec3f& p : source) moved.push_back(static_cast<Vec3f>(motion.targetFromSource * static_cast<Vec3d>(p)));
  return fitness(moved, target, kWithin);
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
  const BeamImage image(beams);
  const Effects made = makeEffects(effects);
  const double leastCosine = std::cos(fit.mostIncidence);
  std::vector<FlatPatch> recorded[2];  // steep, grazing
  std::vector<FlatPatch> simulated[2];
  std::vector<std::vector<Vec3f>> clouds[3];       // recorded, simulated, exact
  std::vector<std::vector<PlanePiece>> planes[2];  // recorded, simulated: of all patches
  for (std::uint32_t s = 0; s < scans.size(); ++s) {
    for (auto& kind : planes) kind.emplace_back();
    for (std::uint32_t tested = 0; tested < 2; ++tested) {
      std::vector<const FlatPatch*> own;  // of one colour: they do not overlap
      std::vector<const FlatPatch*> used;
      for (const FlatPatch& p : patches) {
        if (p.window.scan != s || p.window.tested != tested) continue;
        own.push_back(&p);
        if (fitted(fit, p.range)) used.push_back(&p);
      }
      const RecordedScan copy = simulate(beams, image, own, made, 2 * s + tested);
      for (const FlatPatch* p : own) {
        auto again = measurePatch(beams, image, copy, p->window);
        planes[0].back().push_back(pieceOf(beams, image, *p));
        if (again) planes[1].back().push_back(pieceOf(beams, image, *again));
        if (!fitted(fit, p->range)) continue;
        const std::size_t view = p->incidence >= leastCosine ? 0 : 1;
        recorded[view].push_back(*p);
        if (again) simulated[view].push_back(std::move(*again));
      }
      if (tested != 0) continue;
      clouds[0].push_back(pointsOf(beams, image, scans[s], used));
      clouds[1].push_back(pointsOf(beams, image, copy, used));
      clouds[2].push_back(pointsOf(beams, image, simulate(beams, image, used, {}, 0), used));
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
  std::vector<PlaneMotion> motions(2 * pairs);
  parallelFor(motions.size(), 1, [&](std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i) {
      const auto& kind = planes[i / pairs];
      motions[i] = registerPlanes(kind[i % pairs + 1], kind[i % pairs]);
    }
  });
  for (std::size_t p = 0; p < pairs; ++p) {
    FitnessComparison pair{
        fmt::format("{} on {}", scans[p + 1].name, scans[p].name), motions[p], motions[pairs + p], {}, {}, {}};
    pair.recorded = fitnessAt(pair.recordedMotion, clouds[0][p + 1], clouds[0][p]);
    pair.simulated = fitnessAt(pair.simulatedMotion, clouds[1][p + 1], clouds[1][p]);
    pair.exact = fitnessAt(pair.recordedMotion, clouds[2][p + 1], clouds[2][p]);
    comparison.fitness.push_back(std::move(pair));
  }
  return comparison;
}

}  // namespace scanmill
