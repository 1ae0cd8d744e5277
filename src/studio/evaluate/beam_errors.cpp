#include "evaluate/beam_errors.h"

#include <fmt/core.h>

#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "base/error.h"
#include "base/parallel.h"

namespace scanmill {

namespace {

constexpr double kOpen = std::numeric_limits<double>::infinity();
constexpr float kUnknown = std::numeric_limits<float>::quiet_NaN();

// The ends of bands: the lower end of each band, then the upper end of the last band.
constexpr std::array kRangeEdges{0.0, 5.0, 10.0, 20.0, 40.0, 80.0, kOpen};      // bands of the range (m)
constexpr std::array kIncidenceEdges{0.0, 30.0, 45.0, 60.0, 75.0, 85.0, 90.0};  // bands of the incidence (degrees)
constexpr std::array kThicknessEdges{0.0, 0.05, 0.2, 0.5, 1.0, kOpen};          // bands of a box's shortest edge (m)
constexpr std::array kLengthEdges{0.0, 0.3, 1.0, 2.0, 5.0, kOpen};              // bands of a box's longest edge (m)

// Returns the index of the band that contains `value`. A value at or above the last edge belongs to the last band.
// `value` must not be below the first edge.
std::size_t bandOf(std::span<const double> edges, double value) {
  std::size_t band = 0;
  while (band + 2 < edges.size() && value >= edges[band + 1]) ++band;
  return band;
}

std::string bandName(double low, double high, const char* unit) {
  return std::isinf(high) ? fmt::format("{:g} {} and more", low, unit)
                          : fmt::format("{:g} to {:g} {}", low, high, unit);
}

struct BeamOutcome {
  bool truth = false;   // the exact tracer has a hit
  bool tested = false;  // the tested method has a hit
  bool unresolved = false;
  bool sameClass = false;
  bool sameInstance = false;
  float range = 0;               // absolute error (m) if `truth` and `tested`; otherwise 0
  float intensity = kUnknown;    // absolute error; NaN if not known
  float nearestTo = kUnknown;    // distance from the true point to the nearest tested point (m); NaN if not known
  float nearestFrom = kUnknown;  // distance from the tested point to the nearest true point (m); NaN if not known
};

// Counts and errors of a group of beams. All individual errors are stored, since percentiles need them; they are stored
// as float, since seven digits are enough.
struct GroupSum {
  GroupErrors errors;
  std::vector<float> range, intensity, nearestTo, nearestFrom;

  void add(const BeamOutcome& beam) {
    ++errors.beams;
    if (beam.unresolved) {
      ++errors.unresolved;
    } else if (!beam.truth && !beam.tested) {
      ++errors.bothMiss;
    } else if (!beam.tested) {
      ++errors.falseNegatives;
    } else if (!beam.truth) {
      ++errors.falsePositives;
    } else {
      ++errors.bothHit;
      errors.sameClass += beam.sameClass ? 1 : 0;
      errors.sameInstance += beam.sameInstance ? 1 : 0;
      errors.sameLabel += beam.sameClass && beam.sameInstance ? 1 : 0;
      range.push_back(beam.range);
      if (std::isfinite(beam.intensity)) intensity.push_back(beam.intensity);
    }
    if (std::isfinite(beam.nearestTo)) nearestTo.push_back(beam.nearestTo);
    if (std::isfinite(beam.nearestFrom)) nearestFrom.push_back(beam.nearestFrom);
  }
};

// Returns a group for each band up to the last band with beams; `sums`: one per band.
template <std::size_t N>
std::vector<ErrorGroup> bands(const std::array<double, N>& edges, const char* unit,
                              const std::array<GroupSum, N - 1>& sums) {
  std::vector<ErrorGroup> groups;
  for (std::size_t i = 0; i + 1 < N; ++i) {
    groups.push_back({bandName(edges[i], edges[i + 1], unit), edges[i], edges[i + 1], sums[i].errors});
  }
  while (!groups.empty() && groups.back().errors.beams == 0) groups.pop_back();
  return groups;
}

}  // namespace

class BeamErrorSum::Impl {
 public:
  explicit Impl(const Scene& scene) : scene_(scene), sizes_(instanceSizes(scene)), instances_(sizes_.size()) {}

  void add(const TrueShot& shot, const Hits& tested, std::span<const float> intensity, std::span<const float> nearestTo,
           std::span<const float> nearestFrom) {
    const Hits& exact = shot.truth.hits;
    if (tested.size() != exact.size()) {
      throw Error("hits of {} and of {} beams cannot be compared", exact.size(), tested.size());
    }
    for (const std::size_t size :
         {shot.edges.size(), shot.intensity.size(), intensity.size(), nearestTo.size(), nearestFrom.size()}) {
      if (size == 0 || size == exact.size()) continue;
      throw Error("a list of {} entries is not one of {} beams", size, exact.size());
    }
    const bool comparesIntensity = !shot.intensity.empty() && !intensity.empty();
    for (std::size_t i = 0; i < exact.size(); ++i) {
      BeamOutcome beam = outcomeOf(shot, tested, i);
      if (comparesIntensity && beam.truth && beam.tested) beam.intensity = std::abs(intensity[i] - shot.intensity[i]);
      if (beam.truth && !nearestTo.empty()) beam.nearestTo = nearestTo[i];
      if (beam.tested && !nearestFrom.empty()) beam.nearestFrom = nearestFrom[i];
      all_.add(beam);
      byEdge_[shot.edges.empty() || shot.edges[i] == 0 ? 0 : 1].add(beam);
      if (beam.truth) {
        addToGroups(exact.semantic[i], shot.truth.range[i], beam);
        addToTrueGroups(exact, i, beam);
      } else if (beam.tested) {
        addToGroups(tested.semantic[i], double{tested.range[i]}, beam);
      }
    }
  }

  BeamErrors finish() {
    // Pairs of a list of errors and the spread to compute from it.
    std::vector<std::pair<const std::vector<float>*, Spread*>> spreads;
    const auto addSpreads = [&](GroupSum& sum) {
      spreads.insert(spreads.end(), {{&sum.range, &sum.errors.range},
                                     {&sum.intensity, &sum.errors.intensity},
                                     {&sum.nearestTo, &sum.errors.nearestTo},
                                     {&sum.nearestFrom, &sum.errors.nearestFrom}});
    };
    addSpreads(all_);
    std::ranges::for_each(byEdge_, addSpreads);
    std::ranges::for_each(ranges_, addSpreads);
    std::ranges::for_each(incidences_, addSpreads);
    for (auto& [id, sum] : classes_) addSpreads(sum);
    // Computing percentiles takes most of the time, so several threads share the lists of errors.
    parallelForEach(spreads.size(), 1, [&](std::size_t i) {
      const auto& [values, result] = spreads[i];
      *result = spreadOf({values->begin(), values->end()});
    });
    BeamErrors errors;
    errors.all = all_.errors;
    errors.byEdge = {{"interior", 0, 0, byEdge_[0].errors}, {"edges", 0, 0, byEdge_[1].errors}};
    errors.byRange = bands(kRangeEdges, "m", ranges_);
    errors.byIncidence = bands(kIncidenceEdges, "deg", incidences_);
    for (const auto& [id, sum] : classes_) {
      const SemanticClass* c = scene_.ontology.find(id);
      errors.byClass.push_back({c != nullptr ? c->name : fmt::format("class {}", id), 0, 0, sum.errors});
    }
    errors.byThickness = recall(kThicknessEdges, &InstanceSize::smallest);
    errors.byLength = recall(kLengthEdges, &InstanceSize::largest);
    return errors;
  }

 private:
  // `beams`: number of beams with a true hit on the instance; `beamsFound`: those that also have a tested hit on it.
  struct InstanceBeams {
    std::uint64_t beams = 0, beamsFound = 0;
  };

  // Returns the outcome of beam `i` without intensity and distances to nearest points.
  static BeamOutcome outcomeOf(const TrueShot& shot, const Hits& tested, std::size_t i) {
    const Hits& exact = shot.truth.hits;
    BeamOutcome beam;
    beam.truth = std::isfinite(shot.truth.range[i]);
    beam.unresolved = std::ranges::binary_search(tested.unresolved, i);
    beam.tested = std::isfinite(tested.range[i]) && !beam.unresolved;
    if (!beam.truth || !beam.tested) return beam;
    beam.sameClass = tested.semantic[i] == exact.semantic[i];
    beam.sameInstance = tested.instance[i] == exact.instance[i];
    beam.range = static_cast<float>(std::abs(double{tested.range[i]} - shot.truth.range[i]));
    return beam;
  }

  void addToGroups(std::uint16_t semantic, double range, const BeamOutcome& beam) {
    ranges_[bandOf(kRangeEdges, range)].add(beam);
    classes_[semantic].add(beam);
  }

  // Adds beam `i`, which has a true hit, to the groups by incidence and to the counts of the instance that it hits.
  void addToTrueGroups(const Hits& exact, std::size_t i, const BeamOutcome& beam) {
    if (const double cosine = exact.incidence[i]; !std::isnan(cosine)) {
      incidences_[bandOf(kIncidenceEdges, degrees(std::acos(std::clamp(cosine, 0.0, 1.0))))].add(beam);
    }
    if (exact.instance[i] == 0) return;
    if (exact.instance[i] >= instances_.size())
      throw Error("the hits belong to another scene, which has more instances");
    ++instances_[exact.instance[i]].beams;
    instances_[exact.instance[i]].beamsFound += beam.sameInstance ? 1 : 0;
  }

  // Returns the groups of instances by `side` of their boxes, up to the last group with instances. `edges`: group ends.
  std::vector<SizeRecall> recall(std::span<const double> edges, double InstanceSize::*side) const {
    std::vector<SizeRecall> groups;
    for (std::size_t i = 0; i + 1 < edges.size(); ++i) {
      groups.push_back({bandName(edges[i], edges[i + 1], "m"), edges[i], edges[i + 1]});
    }
    for (std::size_t id = 1; id < instances_.size(); ++id) {
      if (instances_[id].beams == 0) continue;
      SizeRecall& group = groups[bandOf(edges, sizes_[id].*side)];
      ++group.instances;
      group.instancesFound += instances_[id].beamsFound > 0 ? 1 : 0;
      group.beams += instances_[id].beams;
      group.beamsFound += instances_[id].beamsFound;
    }
    while (!groups.empty() && groups.back().instances == 0) groups.pop_back();
    return groups;
  }

  const Scene& scene_;
  std::vector<InstanceSize> sizes_;
  std::vector<InstanceBeams> instances_;  // indexed by instance id
  GroupSum all_;
  std::array<GroupSum, 2> byEdge_;  // beams away from edges, beams near edges
  std::array<GroupSum, kRangeEdges.size() - 1> ranges_;
  std::array<GroupSum, kIncidenceEdges.size() - 1> incidences_;
  std::map<std::uint16_t, GroupSum> classes_;
};

BeamErrorSum::BeamErrorSum(const Scene& scene) : impl_(std::make_unique<Impl>(scene)) {}
BeamErrorSum::~BeamErrorSum() = default;

void BeamErrorSum::add(const TrueShot& truth, const Hits& tested, std::span<const float> intensity,
                       std::span<const float> nearestTo, std::span<const float> nearestFrom) {
  impl_->add(truth, tested, intensity, nearestTo, nearestFrom);
}

BeamErrors BeamErrorSum::finish() {
  return impl_->finish();
}

std::vector<std::vector<Box>> objectBoxes(const Scene& scene) {
  std::vector<std::vector<Box>> boxes;
  for (const Mesh& mesh : scene.meshes) {
    std::vector<Box>& ofMesh = boxes.emplace_back(mesh.objects);
    for (std::size_t t = 0; mesh.objects > 0 && t < mesh.triangles.size(); ++t) {
      const std::uint32_t object = mesh.surfaces[mesh.surfaceOf[t]].object;
      if (object == 0) continue;
      for (const std::uint32_t corner : mesh.triangles[t]) ofMesh[object - 1].add(Vec3d(mesh.positions[corner]));
    }
  }
  return boxes;
}

std::vector<InstanceSize> instanceSizes(const Scene& scene) {
  const std::vector<std::vector<Box>> boxes = objectBoxes(scene);
  std::vector<InstanceSize> sizes(1);
  for (const Instance& instance : scene.instances) {
    const Mat3& linear = instance.worldFromMesh.linear;
    for (std::size_t object = 0; object < boxes[instance.mesh].size(); ++object) {
      const std::size_t id = instance.firstInstanceId + object;
      if (id >= sizes.size()) sizes.resize(id + 1);
      const Box& box = boxes[instance.mesh][object];
      if (box.empty()) continue;
      const Vec3d size = box.high - box.low;
      const auto [smallest, largest] =
          std::minmax({size.x * length(linear.x), size.y * length(linear.y), size.z * length(linear.z)});
      // If several objects form one instance, the largest object determines the instance's size.
      if (largest > sizes[id].largest) sizes[id] = {smallest, largest};
    }
  }
  return sizes;
}

}  // namespace scanmill
