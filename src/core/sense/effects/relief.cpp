// relief: surfaces such as grass, gravel, leaf litter, stonework and bark are rough. This effect models them as a
// height field over the mesh; a beam ends where it first hits the height field.
//
//   relief: {}                # as rough as the table of materials says
//   relief: {strength: 0.5}   # half as high
//
// The height over the mesh is the sum of height_k n_k over the entries of the material's `relief`. Each entry has a
// height and a size, and n_k is a Gaussian field of variance 1 over cubes of that size (spatial_noise.h). The search
// follows the beam from kSearchDeviations standard deviations above the mesh to the first step below the height field.
// Steps are shorter than the smallest size, unless this takes more than kMostSteps. Two linear interpolations between
// the last two steps then find the hit (relief mapping: Policarpo, Oliveira and Comba, "Real-time relief mapping on
// arbitrary polygonal surfaces", I3D 2005). Grazing beams therefore hit the tips of tufts, with gaps behind them, and
// beams from above hit heights whose mean is 0.
//
// A beam averages over its width: as in reflectance_variation, the variance is divided by 1 + area / size^2, with the
// area that the beam illuminates on the inclined surface.

#include <algorithm>
#include <cmath>
#include <vector>

#include "sense/effects/makers.h"
#include "sense/effects/spatial_noise.h"
#include "sensors/footprint.h"

namespace scanmill {
namespace {

constexpr double kSearchDeviations = 2.5;  // height at which the search begins, in standard deviations of the height;
                                           // only 0.6 % of heights are higher
constexpr double kLeastCosine = 0.05;      // least cosine of the angle of incidence; smaller cosines are replaced by it
constexpr double kStepFraction = 0.75;     // length of a step, as a fraction of the smallest Relief::size
constexpr int kMostSteps = 24;

// A beam that hits a rough surface.
struct RoughHit {
  std::size_t row = 0;
  Vec3d point;      // m, world: hit on the mesh
  Vec3d direction;  // unit vector, world axes: of the beam
  // Standard deviation of the height (m) after averaging over the beam's footprint, for each entry of the relief.
  std::array<double, kMostReliefs> height{};
  std::array<double, kMostReliefs> cubesPerMetre{};  // cubes per metre, by entry of the relief
  double cosine = 1;                                 // cosine of the angle of incidence
  double reach = 0;                                  // m, length of beam searched on each side of the mesh
  double step = 0;                                   // m along the beam, length of a step
  int steps = 0;
};

// Follows many beams at once, each in one slot. When the search along a beam ends, the next beam takes its slot.
class March {
 public:
  March(std::span<SpatialField> fields, std::span<const RoughHit> hits, Returns& returns)
      : fields_(fields), hits_(hits), returns_(returns) {}

  void run() {
    for (std::size_t slot = 0; slot < kBatch; ++slot) startNext(slot);
    Batch<double> heights;
    while (running_ > 0) {
      heights.fill(0);
      for (std::uint32_t k = 0; k < kMostReliefs; ++k) {
        if (levels_ > k) fields_[k].add(positions_, cubesPerMetre_[k], height_[k], heights);
      }
      for (std::size_t slot = 0; slot < kBatch; ++slot) {
        if (hit_[slot] != nullptr) advance(slot, heights[slot]);
      }
    }
  }

 private:
  // Puts the next beam into a slot, at the start of its search. If no beam is left, the slot stays empty.
  void startNext(std::size_t slot) {
    if (next_ == hits_.size()) {
      hit_[slot] = nullptr;
      return;
    }
    const RoughHit& hit = hits_[next_++];
    ++running_;
    hit_[slot] = &hit;
    step_[slot] = 0;
    below_[slot] = 0;
    for (std::size_t k = 0; k < kMostReliefs; ++k) {
      height_[k][slot] = hit.height[k];
      cubesPerMetre_[k][slot] = hit.cubesPerMetre[k];
      if (hit.height[k] > 0) levels_ = std::max(levels_, k + 1);
    }
    moveTo(slot, -hit.reach);
  }

  // Moves the slot's position along its beam to `distance` (m, counted from the mesh).
  void moveTo(std::size_t slot, double distance) {
    const RoughHit& hit = *hit_[slot];
    distance_[slot] = distance;
    positions_.set(slot, hit.point + hit.direction * distance);
  }

  // Continues a slot's search. `height`: height (m) of the height field at the slot's position.
  void advance(std::size_t slot, double height) {
    const RoughHit& hit = *hit_[slot];
    const double distance = distance_[slot];
    const double clearance = -distance * hit.cosine - height;  // m, height of the beam over the height field
    if (below_[slot] < 0) {  // after the first interpolation: interpolate again, between this position and the step
                             // on the other side of the height field
      const double stepAbove = step_[slot] * hit.step - hit.reach;
      finish(slot, clearance > 0 ? distance + (stepAbove + hit.step - distance) * clearance / (clearance - below_[slot])
                                 : stepAbove + (distance - stepAbove) * above_[slot] / (above_[slot] - clearance));
    } else if (clearance > 0 && step_[slot] < hit.steps) {  // above the height field: take the next step
      above_[slot] = clearance;
      moveTo(slot, ++step_[slot] * hit.step - hit.reach);
    } else if (step_[slot] == 0 || clearance >= 0) {  // the first step is below the field or the last one above
      finish(slot, distance);
    } else {  // first step below the field: interpolate between this and the previous step
      below_[slot] = clearance;
      const double stepAbove = --step_[slot] * hit.step - hit.reach;
      moveTo(slot, stepAbove + hit.step * above_[slot] / (above_[slot] - clearance));
    }
  }

  // Ends a slot's search with a hit at `distance` (m along the beam, from the mesh) and starts the search of the next
  // beam. The new range is at least half the old range.
  void finish(std::size_t slot, double distance) {
    float& range = returns_.range[hit_[slot]->row];
    range = std::max(range / 2, range + static_cast<float>(distance));
    --running_;
    startNext(slot);
  }

  std::span<SpatialField> fields_;  // by entry of the relief
  std::span<const RoughHit> hits_;
  Returns& returns_;
  std::size_t next_ = 0;     // index in hits_ of the next beam
  std::size_t running_ = 0;  // number of slots with a beam
  std::size_t levels_ = 0;   // largest number of entries of a relief so far
  // The state of each slot.
  Batch<const RoughHit*> hit_{};  // null: no beam
  Batch<int> step_{};             // the current step; after below_ is set, the last step above the height field
  Batch<double> distance_{};      // m, current position along the beam, counted from the mesh
  Batch<double> above_{};         // m, height of the beam over the height field at the last step above it
  Batch<double> below_{};         // m, height (negative) at the first step below the height field; 0: not found yet
  Positions positions_{};         // m, world
  std::array<Batch<double>, kMostReliefs> height_{}, cubesPerMetre_{};  // by entry of the relief, see RoughHit
};

class ReliefEffect : public Effect {
 public:
  explicit ReliefEffect(double strength) : strength_(strength) {}

  Channels reads() const override { return Channel::Range | Channel::Incidence | Channel::Material; }

  void apply(const Hits& hits, const Shot& shot, std::span<const Material> materials, Returns& returns) const override {
    constexpr std::size_t kRowsOfMarch = 64 * kBatch;  // largest number of rows whose beams one March follows
    const PositionsOfHits positionsOfHits(hits, shot, returns);
    std::vector<SpatialField> fields;
    for (std::uint32_t k = 0; k < kMostReliefs; ++k) fields.emplace_back(shot.seed, Purpose::Relief, k);
    Positions positions;
    Positions directions;
    std::vector<RoughHit> rough;
    for (std::size_t start = 0; start < returns.size(); start += kRowsOfMarch) {
      rough.clear();
      for (std::size_t first = start; first < std::min(start + kRowsOfMarch, returns.size()); first += kBatch) {
        const std::size_t before = rough.size();
        const std::size_t count = std::min(kBatch, returns.size() - first);
        for (std::size_t row = first; row < first + count; ++row) {
          addIfRough(hits, shot, materials, returns, row, rough);
        }
        if (rough.size() == before) continue;
        positionsOfHits.compute(first, positions, &directions);
        for (std::size_t k = before; k < rough.size(); ++k) {
          rough[k].point = positions.at(rough[k].row - first);
          rough[k].direction = directions.at(rough[k].row - first);
        }
      }
      March(fields, rough, returns).run();
    }
  }

 private:
  // Appends a RoughHit, without `point` and `direction`, for the row if its hit has a material with a relief.
  void addIfRough(const Hits& hits, const Shot& shot, std::span<const Material> materials, const Returns& returns,
                  std::size_t row, std::vector<RoughHit>& rough) const {
    if (!returns.returned(row) || returns.hit(row) == kNoHit) return;
    const std::uint32_t hit = returns.hit(row);
    if (hits.material[hit] >= materials.size()) return;
    const std::vector<Relief>& reliefs = materials[hits.material[hit]].relief;
    if (reliefs.empty()) return;
    RoughHit roughHit;
    roughHit.row = row;
    roughHit.cosine = std::max(kLeastCosine, double{hits.incidence[hit]});
    const double area = beamArea(*shot.beams, double{hits.range[hit]}) / roughHit.cosine;
    double variance = 0;
    double smallest = double{reliefs.front().size};
    for (std::size_t k = 0; k < reliefs.size(); ++k) {
      const double size = reliefs[k].size;
      roughHit.height[k] = strength_ * reliefs[k].height / std::sqrt(1 + area / (size * size));
      roughHit.cubesPerMetre[k] = 1 / size;
      variance += roughHit.height[k] * roughHit.height[k];
      smallest = std::min(smallest, size);
    }
    if (variance == 0) return;
    roughHit.reach = kSearchDeviations * std::sqrt(variance) / roughHit.cosine;
    roughHit.steps = std::min(kMostSteps, static_cast<int>(std::ceil(2 * roughHit.reach / (kStepFraction * smallest))));
    roughHit.step = 2 * roughHit.reach / roughHit.steps;
    rough.push_back(roughHit);
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
