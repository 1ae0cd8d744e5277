#include "evaluate/measure.h"

#include <malloc.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nanoflann.hpp>

#include "base/error.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "base/stage_clock.h"
#include "pipeline/read/pipeline.h"

namespace scanmill {

namespace {

constexpr float kUnknownDistance = std::numeric_limits<float>::quiet_NaN();

// Measures how much the process's resident memory grows between begin() and end(), which enclose the work of the
// method, but not the computation of its errors. Memory that has been returned to the allocator is not counted.
class ResidentGrowth {
 public:
  void begin() { before_ = resident(); }
  void end() { growth_ += resident() - before_; }
  std::uint64_t bytes() const { return static_cast<std::uint64_t>(std::max<std::int64_t>(growth_, 0)); }

 private:
  static std::int64_t resident() {
    ::malloc_trim(0);
    return static_cast<std::int64_t>(residentBytes());
  }

  std::int64_t before_ = 0, growth_ = 0;
};

void checkStop(const MeasureOptions& options) {
  if (options.stop && options.stop()) throw Error("stopped: the measurement is not finished");
}

// Distributes values of the points from hitPoints() to their beams. Returns one value per beam; NaN for misses.
std::vector<float> byBeam(const Hits& hits, const std::vector<float>& pointValues) {
  std::vector<float> beamValues(hits.size(), kUnknownDistance);
  std::size_t point = 0;
  for (std::size_t beam = 0; beam < hits.size(); ++beam) {
    if (hits.hit(beam)) beamValues[beam] = pointValues[point++];
  }
  return beamValues;
}

// Traces a shot repeatedly into `hits` and appends the duration of each scan to `seconds`. Returns the sum of the
// accounts that Method::trace() returned.
TraceAccount timeScans(const Method& method, const Shot& shot, const MeasureOptions& options, Hits& hits,
                       std::vector<double>& seconds) {
  constexpr int kMostRepeats = 30;
  TraceAccount account;
  double timedSeconds = 0;
  for (int scans = 0; options.repeats > 0; ++scans) {
    const bool isLongEnough = scans >= kMostRepeats || timedSeconds >= options.leastSeconds;
    if (scans >= options.repeats && isLongEnough) break;
    checkStop(options);
    const WallTimer timer;
    const TraceAccount accountOfScan = method.trace(shot, options.channels | Channel::Range, hits);
    seconds.push_back(timer.seconds());
    timedSeconds += seconds.back();
    account += accountOfScan;
  }
  return account;
}

// Sets the times per scan in `cost`. `secondsOfSensor`: durations (s) of all timed scans, by sensor. `timed`,
// `untimed`: sums of the accounts of the timed scans, and of all other work.
void addTimes(const std::map<std::uint32_t, std::vector<double>>& secondsOfSensor, const TraceAccount& timed,
              const TraceAccount& untimed, Cost& cost) {
  double scans = 0;
  for (const auto& [sensor, seconds] : secondsOfSensor) scans += static_cast<double>(seconds.size());
  for (const auto& [sensor, seconds] : secondsOfSensor) {
    if (seconds.empty()) continue;
    const double share = static_cast<double>(seconds.size()) / scans;
    const Spread spread = spreadOf(seconds);
    cost.scanSeconds += share * spread.median;
    cost.fastest += share * *std::ranges::min_element(seconds);
    cost.slowest += share * spread.max;
  }
  if (scans == 0) return;
  for (const auto& [stage, seconds] : untimed.seconds) cost.stages[stage] = 0;
  for (const auto& [stage, seconds] : timed.seconds) cost.stages[stage] = seconds / scans;
}

// The finite points of a cloud (m), with the functions that nanoflann calls.
struct FiniteCloud {
  explicit FiniteCloud(std::span<const Vec3f> cloud) {
    std::ranges::copy_if(cloud, std::back_inserter(points), isFinite<float>);
  }

  std::vector<Vec3f> points;

  std::size_t kdtree_get_point_count() const { return points.size(); }
  float kdtree_get_pt(std::size_t i, std::size_t axis) const {
    return axis == 0 ? points[i].x : axis == 1 ? points[i].y : points[i].z;
  }
  template <class Bounds>
  bool kdtree_get_bbox(Bounds&) const {
    return false;
  }
};

using Tree = nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<float, FiniteCloud>, FiniteCloud, 3>;

}  // namespace

std::function<std::vector<float>(const Shot&, const Hits&)> intensityOfEffects(const Pipeline& pipeline,
                                                                               const Scene& scene) {
  if (!setsIntensity(pipeline)) return {};
  return [&pipeline, &scene](const Shot& shot, const Hits& hits) {
    Returns returns;
    returns.start(hits);
    for (const auto& effect : *pipeline.sensors[shot.sensor].effects) {
      if (effect->setsIntensity()) effect->apply(hits, shot, scene.materials, returns);
    }
    return std::move(returns.intensity);
  };
}

void requireOneRay(const Hits& hits) {
  if (hits.beamOfRay.empty() && hits.rays() == hits.size()) return;
  throw Error("{} beams have {} rays, but methods are compared with one ray per beam", hits.size(), hits.rays());
}

std::vector<std::uint8_t> edgeBeams(const Method& method, const Shot& shot, double angle) {
  // Fraction of the range by which ranges of neighbouring beams may differ on one surface.
  constexpr double kStep = 0.1;
  const Channels channels = Channel::Range | Channel::Instance | Channels(Channel::Semantic);
  Hits middle, neighbour;
  method.trace(shot, channels, middle);
  requireOneRay(middle);
  std::vector<std::uint8_t> edges(middle.size(), 0);
  for (int up = -1; up <= 1; ++up) {
    for (int left = -1; left <= 1; ++left) {
      if (up == 0 && left == 0) continue;
      auto beams = std::make_shared<BeamTable>(*shot.beams);
      for (Vec3d& direction : beams->direction) {
        const Vec3d leftwards = normalized(cross(Vec3d{0, 0, 1}, direction));
        const Vec3d upwards = cross(direction, leftwards);
        direction = normalized(direction + (leftwards * left + upwards * up) * std::tan(angle));
      }
      Shot neighbourShot = shot;
      neighbourShot.beams = beams;
      method.trace(neighbourShot, channels, neighbour);
      for (std::size_t i = 0; i < edges.size(); ++i) {
        const double step = std::abs(middle.range[i] - neighbour.range[i]);
        if (middle.hit(i) != neighbour.hit(i) || middle.instance[i] != neighbour.instance[i] ||
            middle.semantic[i] != neighbour.semantic[i] || (middle.hit(i) && step > kStep * middle.range[i])) {
          edges[i] = 1;
        }
      }
    }
  }
  return edges;
}

std::vector<TrueShot> trueShots(const Scene& scene, std::vector<Shot> shots, const MeasureOptions& options) {
  const ExactTracer tracer(scene);
  const std::unique_ptr<Method> rays = makeReference(scene);
  std::vector<TrueShot> traced;
  traced.reserve(shots.size());
  for (Shot& shot : shots) {
    checkStop(options);
    TrueShot& truth = traced.emplace_back();
    truth.shot = std::move(shot);
    tracer.trace(truth.shot, kErrorChannels | options.channels, truth.truth);
    // A method that samples as finely as the sensor may shift an edge by the angle between neighbouring columns. The
    // angle is limited to one degree, since tables with few columns have larger angles.
    const BeamTable& beams = *truth.shot.beams;
    truth.edges = edgeBeams(*rays, truth.shot, std::min(beams.field / std::max(beams.columns, 1u), radians(1)));
    if (options.intensity) truth.intensity = options.intensity(truth.shot, truth.truth.hits);
  }
  return traced;
}

bool anyHit(std::span<const TrueShot> shots) {
  const auto hit = [](double range) { return std::isfinite(range); };
  return std::ranges::any_of(shots, [&](const TrueShot& t) { return std::ranges::any_of(t.truth.range, hit); });
}

Measurement measure(const std::function<std::unique_ptr<Method>()>& make, const Scene& scene,
                    std::span<const TrueShot> shots, const MeasureOptions& options) {
  if (shots.empty()) throw Error("the list of shots to measure on is empty");
  const Channels timed = options.channels | Channel::Range;
  const Channels compared = kErrorChannels | timed;
  Measurement result;
  BeamErrorSum errors(scene);
  Hits hits;
  ResidentGrowth growth;
  // Durations (s) by sensor, since the sizes of scans differ between sensors.
  std::map<std::uint32_t, std::vector<double>> secondsOfSensor;
  TraceAccount timedAccount, untimedAccount;

  // Memory for the hits is allocated before growth.begin(), so that only the method's memory counts.
  checkStop(options);
  hits.reset(shots.front().shot.beams->rings, shots.front().shot.beams->columns, compared);
  growth.begin();
  const WallTimer setup;
  const std::unique_ptr<Method> method = make();
  untimedAccount += method->prepare(shots.front().shot);
  result.cost.setupSeconds = setup.seconds();
  growth.end();

  for (const TrueShot& truth : shots) {
    checkStop(options);
    hits.reset(truth.shot.beams->rings, truth.shot.beams->columns, timed);
    growth.begin();
    untimedAccount += method->trace(truth.shot, timed, hits);
    growth.end();
    requireOneRay(hits);
    timedAccount += timeScans(*method, truth.shot, options, hits, secondsOfSensor[truth.shot.sensor]);
    checkStop(options);
    // All scans of a shot have equal hits. If the timed scans have all channels that are compared, the hits of the last
    // timed scan are used; otherwise the shot is traced again.
    if (timed != compared) untimedAccount += method->trace(truth.shot, compared, hits);
    const bool comparesIntensity = options.intensity && !truth.intensity.empty();
    const std::vector<float> intensity = comparesIntensity ? options.intensity(truth.shot, hits) : std::vector<float>();
    const Hits& exact = truth.truth.hits;
    const std::vector<Vec3f> truePoints = hitPoints(truth.shot, exact), points = hitPoints(truth.shot, hits);
    errors.add(truth, hits, intensity, byBeam(exact, nearestDistances(truePoints, points)),
               byBeam(hits, nearestDistances(points, truePoints)));
  }

  addTimes(secondsOfSensor, timedAccount, untimedAccount, result.cost);
  result.cost.memoryBytes = method->memoryBytes();
  result.cost.residentBytes = growth.bytes();
  result.errors = errors.finish();
  untimedAccount += timedAccount;
  result.warnings = untimedAccount.warningTexts();
  return result;
}

std::vector<Vec3f> hitPoints(const Shot& shot, const Hits& hits) {
  const BeamTable& beams = *shot.beams;
  if (hits.size() != beams.size()) throw Error("hits and beams are not of one sensor");
  requireOneRay(hits);
  // Transforms from the sensor's frame at each step to its frame at the first step; empty: points are not transformed.
  std::vector<Affine> toStart;
  for (std::size_t step = 0; shot.deskew && step < shot.worldFromSensor.size(); ++step) {
    toStart.push_back(shot.startFromStep(step));
  }
  std::vector<Vec3f> points;
  points.reserve(hits.size());
  for (std::size_t i = 0; i < hits.size(); ++i) {
    if (!hits.hit(i)) continue;
    Vec3d p = beams.originOf(i) + beams.direction[i] * double{hits.range[i]};
    if (!toStart.empty()) p = toStart[shot.stepOf(static_cast<std::uint32_t>(i % hits.columns))] * p;
    points.push_back(Vec3f(p));
  }
  return points;
}

std::vector<float> nearestDistances(std::span<const Vec3f> from, std::span<const Vec3f> to) {
  std::vector<float> distances(from.size(), kUnknownDistance);
  const FiniteCloud target(to);
  if (target.points.empty()) return distances;
  const Tree tree(3, target);
  parallelForEach(from.size(), 1024, [&](std::size_t i) {
    if (!isFinite(from[i])) return;
    std::uint32_t index = 0;
    float squaredDistance = 0;
    tree.knnSearch(&from[i].x, 1, &index, &squaredDistance);
    distances[i] = static_cast<float>(std::sqrt(double{squaredDistance}));
  });
  return distances;
}

}  // namespace scanmill
