// relief: surfaces are rough: grass, gravel, leaf litter, courses of stone, bark. A beam is stopped by the first height
// in its way.
//
//   relief: {}                # as rough as the table of materials says
//   relief: {strength: 0.5}   # half as high
//
// Heights over the mesh are the sum of height_k n_k, with a height and a size for each of the material's `relief`, and
// n_k a Gaussian field of variance 1 over cubes of that size (spatial_noise.h) that belongs to the world and the
// pipeline's seed: every frame, every sensor and every method meets the same tufts. The beam is followed from where it
// comes within kDeviations of the mesh, in steps of no more than the smallest size, to where it is first below a
// height; there, between two steps, twice by a straight line (relief mapping: Policarpo, Oliveira and Comba,
// "Real-time relief mapping on arbitrary polygonal surfaces", I3D 2005). So a grazing beam meets the tips and jumps
// from tuft to tuft, and one that falls from above meets heights of mean 0.
//
// A beam averages over its own width: as in reflectance_variation, the variance is divided by 1 + area / size^2, here
// with the area that the beam lights on the slanted surface.

#include <algorithm>
#include <cmath>

#include "sense/effects/makers.h"
#include "sense/effects/spatial_noise.h"
#include "sensors/footprint.h"

namespace scanmill {
namespace {

constexpr double kDeviations = 2.5;  // heights beyond are rare: 0.6 %
constexpr double kLeastCosine = 0.05;
constexpr double kStep = 0.75;  // of the smallest size
constexpr int kMostSteps = 24;

class ReliefEffect : public Effect {
 public:
  explicit ReliefEffect(double strength) : strength_(strength) {}

  Channels reads() const override { return Channel::Range | Channel::Incidence | Channel::Material; }

  void apply(const Hits& hits, const Shot& shot, std::span<const Material> materials, Returns& returns) const override {
    const PlacesOfHits hitPlaces(hits, shot, returns);
    for (std::size_t first = 0; first < returns.size(); first += kBatch) {
      Work work;
      if (!prepare(hits, shot, materials, returns, first, work)) continue;
      hitPlaces.find(first, work.hit, &work.along);
      march(shot.seed, work);
      const std::size_t count = std::min(kBatch, returns.size() - first);
      for (std::size_t i = 0; i < count; ++i) {
        if (work.reach[i] == 0) continue;
        float& range = returns.range[first + i];
        range = std::max(range / 2, range + static_cast<float>(work.met[i]));
      }
    }
  }

 private:
  // Of a batch of rows.
  struct Work {
    Places hit;
    Places along;                                      // unit vectors of the beams
    std::array<Batch<double>, kMostReliefs> height{};  // m, as the beam sees it
    std::array<Batch<double>, kMostReliefs> cubes{};   // a metre
    Batch<double> cosine{};                            // of the incidence
    Batch<double> reach{};                             // m before the hit and behind it that are searched; 0: none
    Batch<double> step{};                              // m
    Batch<int> steps{};
    Batch<double> met{};  // m behind the hit
    std::size_t levels = 0;
    int mostSteps = 0;
  };

  // False where no row of the batch has a relief.
  bool prepare(const Hits& hits, const Shot& shot, std::span<const Material> materials, const Returns& returns,
               std::size_t first, Work& work) const {
    const std::size_t count = std::min(kBatch, returns.size() - first);
    for (std::size_t i = 0; i < count; ++i) {
      const std::size_t row = first + i;
      if (!returns.returned(row) || returns.hit(row) == kNoHit) continue;
      const std::uint32_t hit = returns.hit(row);
      if (hits.material[hit] >= materials.size()) continue;
      const std::vector<Relief>& reliefs = materials[hits.material[hit]].relief;
      if (reliefs.empty()) continue;
      const double cosine = std::max(kLeastCosine, double{hits.incidence[hit]});
      const double area = beamArea(*shot.beams, double{hits.range[hit]}) / cosine;
      double variance = 0;
      double smallest = double{reliefs.front().size};
      for (std::size_t k = 0; k < reliefs.size(); ++k) {
        const double size = reliefs[k].size;
        const double height = strength_ * reliefs[k].height / std::sqrt(1 + area / (size * size));
        work.height[k][i] = height;
        work.cubes[k][i] = 1 / size;
        variance += height * height;
        smallest = std::min(smallest, size);
      }
      if (variance == 0) continue;
      work.levels = std::max(work.levels, reliefs.size());
      work.cosine[i] = cosine;
      work.reach[i] = kDeviations * std::sqrt(variance) / cosine;
      work.steps[i] = std::min(kMostSteps, static_cast<int>(std::ceil(2 * work.reach[i] / (kStep * smallest))));
      work.step[i] = 2 * work.reach[i] / work.steps[i];
      work.mostSteps = std::max(work.mostSteps, work.steps[i]);
    }
    return work.mostSteps > 0;
  }

  // Adds the heights at `at`, in m behind the hits.
  static void heightsAt(std::uint64_t seed, const Work& work, const Batch<double>& at, Batch<double>& heights) {
    Places places;
    for (std::size_t i = 0; i < kBatch; ++i) {
      places.x[i] = work.hit.x[i] + at[i] * work.along.x[i];
      places.y[i] = work.hit.y[i] + at[i] * work.along.y[i];
      places.z[i] = work.hit.z[i] + at[i] * work.along.z[i];
    }
    heights.fill(0);
    for (std::uint32_t k = 0; k < work.levels; ++k) {
      addField({seed, Purpose::Relief, k}, places, work.cubes[k], work.height[k], heights);
    }
  }

  static void march(std::uint64_t seed, Work& work) {
    Batch<double> at;
    Batch<double> heights;
    Batch<double> above{};   // how far the beam is over the heights, at the last step where it is
    Batch<double> below{};   // at the first where it is not; 0: it is not known between which steps it meets them
    Batch<double> before{};  // the first of the two steps, m behind the hit
    Batch<bool> searching;
    for (std::size_t i = 0; i < kBatch; ++i) searching[i] = work.reach[i] > 0;
    bool any = true;
    for (int step = 0; any; ++step) {
      for (std::size_t i = 0; i < kBatch; ++i) at[i] = step * work.step[i] - work.reach[i];
      heightsAt(seed, work, at, heights);
      any = false;
      for (std::size_t i = 0; i < kBatch; ++i) {
        if (!searching[i]) continue;
        const double over = -at[i] * work.cosine[i] - heights[i];
        work.met[i] = at[i];
        if (over > 0 && step < work.steps[i]) {
          above[i] = over;
          any = true;
          continue;
        }
        searching[i] = false;
        if (step == 0 || over > 0) continue;
        below[i] = over;
        before[i] = at[i] - work.step[i];
        work.met[i] = before[i] + work.step[i] * above[i] / (above[i] - over);
      }
    }
    // Once more, by the line between there and one of the two steps.
    heightsAt(seed, work, work.met, heights);
    for (std::size_t i = 0; i < kBatch; ++i) {
      if (below[i] == 0) continue;
      const double over = -work.met[i] * work.cosine[i] - heights[i];
      if (over > 0) {
        work.met[i] += (before[i] + work.step[i] - work.met[i]) * over / (over - below[i]);
      } else {
        work.met[i] = before[i] + (work.met[i] - before[i]) * above[i] / (above[i] - over);
      }
    }
  }

  double strength_;
};

}  // namespace

std::unique_ptr<Effect> makeRelief(Fields& options) {
  const double strength = options.number("strength", {0, 10}, 1);
  options.finish();
  return std::make_unique<ReliefEffect>(strength);
}

}  // namespace scanmill
