#include "study/repeatability/repeatability.h"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <memory>

#include "base/append_new.h"
#include "base/parallel.h"
#include "config/version.h"
#include "pipeline/run/progress.h"
#include "pipeline/run/run_shot.h"
#include "pipeline/scenes/shot_source.h"
#include "study/repeatability/repeatability_choice.h"

namespace scanmill {

namespace {

using ObjectCloud = std::vector<Vec3f>;  // points relative to the object's centre, along the world's axes (m)

ObjectCloud cropToObject(const Scan& scan, const Shot& shot, const BoxedObject& thing, double margin) {
  ObjectCloud cloud;
  const Vec3d middle = thing.center();
  for (std::size_t i = 0; i < scan.size(); ++i) {
    // A point is in the sensor's frame at the time of its column, or at the start of the revolution if it is deskewed.
    const std::size_t step = shot.deskew ? 0 : shot.stepOf(scan[kColumn][i]);
    const Vec3d p = shot.worldFromSensor[step] * Vec3d(scan.position[i]);
    if (thing.distance(p) <= margin) cloud.push_back(static_cast<Vec3f>(p - middle));
  }
  return cloud;
}

// Two scans from one pose. `source` and `target` are indices into the clouds: level * number of scans + scan.
struct ScanPair {
  std::size_t source, target;
};

// Returns all ordered pairs, sorted by source level, target level, source and target. Pairs with the same seed are left
// out, since their random numbers are the same.
std::vector<ScanPair> scanPairs(std::size_t levels, std::size_t scans) {
  std::vector<ScanPair> pairs;
  for (std::size_t a = 0; a < levels; ++a) {
    for (std::size_t b = 0; b < levels; ++b) {
      for (std::size_t i = 0; i < scans; ++i) {
        for (std::size_t j = 0; j < scans; ++j) {
          if (i != j) pairs.push_back({a * scans + i, b * scans + j});
        }
      }
    }
  }
  return pairs;
}

class RepeatabilityRun {
 public:
  RepeatabilityRun(const Plan& plan, const RepeatabilityOptions& options)
      : plan_(plan),
        source_(plan),
        options_(options),
        choice_(readRepeatabilityChoice(plan.pipeline)),
        channels_(repeatabilityChannels(plan.pipeline)),
        pairs_(scanPairs(choice_.levels.size(), choice_.scans)),
        progress_("repeatability", choice_.methods.size() * plan.pipeline.sensors.size() * plan.pipeline.frames(),
                  "poses", "poses", options.quiet) {}

  Repeatability run() {
    describe();
    const Pipeline& pipeline = plan_.pipeline;
    std::unique_ptr<Scene> scene;
    std::vector<std::unique_ptr<Method>> methods;
    std::vector<BoxedObject> things;
    const std::size_t sensors = pipeline.sensors.size();
    for (std::size_t s = 0; s < pipeline.sequences.size(); ++s) {
      const Sequence& sequence = pipeline.sequences[s];
      if (s == 0 || !sequence.sameScene(pipeline.sequences[s - 1])) {
        methods.clear();
        scene = std::make_unique<Scene>(source_.load(s));
        standStill(*scene, 0);
        for (const MethodSetting& setting : choice_.methods) methods.push_back(makeMethod(setting.choice, *scene));
        things = boxedObjects(*scene);
      }
      for (std::size_t m = 0; m < methods.size(); ++m) {
        const std::size_t firstView = (m * pipeline.sequences.size() + s) * sensors;
        for (std::uint32_t frame = 0; frame < sequence.frames; ++frame) {
          const std::vector<Shot> shots = source_.frame(s, frame).shots;
          for (std::size_t sensor = 0; sensor < sensors; ++sensor) {
            const Vec3d from = shots[sensor].worldFromSensor.front().translation;
            const BoxedObject& thing = objectToScan(things, choice_.object, from, *scene);
            result_.views[firstView + sensor].poses.push_back(measurePose(*methods[m], *scene, shots[sensor], thing));
            progress_.advance(1, 1);
          }
        }
      }
    }
    warnOfPosesWithoutPoints();
    warnOfNoiseThatMovesNothing();
    return std::move(result_);
  }

 private:
  // Sets all members of the result but the measurements, with one view for each method, sequence and sensor.
  void describe() {
    const Pipeline& pipeline = plan_.pipeline;
    result_.programVersion = kVersion;
    result_.pipelineName = pipeline.name;
    result_.pipelineText = pipeline.text;
    result_.seed = pipeline.seed;
    result_.scans = choice_.scans;
    result_.margin = choice_.margin;
    result_.icp = choice_.icp;
    result_.reference = choice_.reference;
    for (const MethodSetting& m : choice_.methods) result_.methods.push_back(m.setting.name);
    for (const NoiseLevel& level : choice_.levels) result_.levels.push_back(level.name);
    for (std::size_t m = 0; m < choice_.methods.size(); ++m) {
      for (const Sequence& sequence : pipeline.sequences) {
        for (std::size_t s = 0; s < pipeline.sensors.size(); ++s) {
          const MountedSensor& sensor = pipeline.sensors[s];
          const BeamTable& beams = *plan_.sensors[s].beams;
          RepeatedView& view = result_.views.emplace_back();
          view.method = m;
          view.sensor = fmt::format("{} ({}{}{} x {} beams)", sensor.name, beams.model, beams.model.empty() ? "" : ", ",
                                    beams.rings, beams.columns);
          const bool seeds = std::ranges::any_of(pipeline.sequences, [&](const Sequence& q) {
            return q.scene == sequence.scene && q.sceneSeed != sequence.sceneSeed;
          });
          view.name = seeds ? fmt::format("{} {}", sequence.scene, sequence.sceneSeed) : sequence.scene;
          view.name += " " + sequence.trajectoryName;
          if (pipeline.sensors.size() > 1) view.name += " " + sensor.name;
        }
      }
    }
  }

  void warnOfPosesWithoutPoints() {
    constexpr std::size_t kShown = 5;
    for (const RepeatedView& view : result_.views) {
      std::vector<std::string> blind;
      std::string object;
      for (const RepeatedPose& pose : view.poses) {
        if (std::ranges::any_of(pose.points, [](const PointCount& c) { return c.most > 0; })) {
          continue;
        }
        blind.push_back(fmt::format("{} ({:.4g} m)", pose.frame, pose.distance));
        object = pose.object;
      }
      if (blind.empty()) continue;
      const std::size_t count = blind.size();
      blind.resize(std::min(count, kShown));
      result_.warnings.push_back(
          fmt::format("{}{}: no point hits {} from {} of {} poses: frame {}{}; is the object in the sensor's field and "
                      "not occluded?",
                      view.name, result_.methods.size() > 1 ? ", " + result_.methods[view.method] : "", object, count,
                      view.poses.size(), fmt::join(blind, ", "), count > kShown ? ", ..." : ""));
    }
  }

  // Warns if all scans of a level are equal, since perfect agreement then says nothing. `effects: []` causes no
  // warning, since equal scans are then intended.
  void warnOfNoiseThatMovesNothing() {
    for (std::size_t level = 0; level < choice_.levels.size(); ++level) {
      std::vector<std::string> names;
      for (std::size_t s = 0; s < plan_.pipeline.sensors.size(); ++s) {
        for (const ChosenEffect& effect : *choice_.levels[level].effects[s]) {
          appendNew({std::string(effect.entry->name)}, names);
        }
      }
      if (names.empty() && choice_.levels[level].named) continue;
      bool any = false;
      bool moves = false;
      for (const RepeatedView& view : result_.views) {
        for (const RepeatedPose& pose : view.poses) {
          const FitnessSpread& same = result_.at(pose, level, level).unmoved;
          any = any || same.count > 0;
          moves = moves || same.high > 0;
        }
      }
      if (!any || moves) continue;
      result_.warnings.push_back(fmt::format(
          "noise '{}': no effect of this noise moves points ({}), so that its scans are all the same: give shell, "
          "range_noise or angular_jitter",
          result_.levels[level], names.empty() ? "it has no effects" : fmt::format("{}", fmt::join(names, ", "))));
    }
  }

  bool stopped() const { return options_.stop != nullptr && *options_.stop; }

  // Returns the object's points in the scans with all noise levels and seeds. Traces once, since the hits are the same
  // for all.
  std::vector<ObjectCloud> scansOf(const Method& method, const Scene& scene, const Shot& shot,
                                   const BoxedObject& thing) const {
    Hits hits;
    method.trace(shot, channels_, hits);
    const std::size_t levels = choice_.levels.size();
    std::vector<ObjectCloud> clouds(levels * choice_.scans);
    parallelFor(clouds.size(), choice_.scans, [&](std::size_t first, std::size_t last) {
      Shot repeated = shot;
      Returns scratch;
      Scan scan;
      for (std::size_t c = first; c < last; ++c) {
        repeated.seed = shot.seed + c % choice_.scans;
        const Effects& effects = *choice_.levels[c / choice_.scans].effects[shot.sensor];
        senseShot({method, channels_, {effects, scene.materials, repeatabilityLayout()}}, repeated, hits, scratch,
                  scan);
        clouds[c] = cropToObject(scan, repeated, thing, choice_.margin);
      }
    });
    return clouds;
  }

  RepeatedPose measurePose(const Method& method, const Scene& scene, const Shot& shot, const BoxedObject& thing) const {
    const std::vector<ObjectCloud> clouds = scansOf(method, scene, shot, thing);
    std::vector<Registered> registered(pairs_.size());
    parallelFor(pairs_.size(), 1, [&](std::size_t first, std::size_t last) {
      for (std::size_t p = first; p < last && !stopped(); ++p) {
        registered[p] = registerClouds(clouds[pairs_[p].source], clouds[pairs_[p].target], choice_.icp);
      }
    });
    if (stopped()) throw Error("stopped: nothing was written");

    RepeatedPose pose{shot.frame, thing.name(), thing.distance(shot.worldFromSensor.front().translation), {}, {}};
    for (std::size_t level = 0; level < choice_.levels.size(); ++level) {
      pose.points.push_back(countPoints(std::span(clouds).subspan(level * choice_.scans, choice_.scans)));
    }
    const std::size_t perCell = std::size_t{choice_.scans} * (choice_.scans - 1);
    for (std::size_t first = 0; first < registered.size(); first += perCell) {
      pose.fitness.push_back(fitnessOf(std::span(registered).subspan(first, perCell)));
    }
    return pose;
  }

  static PointCount countPoints(std::span<const ObjectCloud> clouds) {
    PointCount count{0, clouds.front().size(), 0};
    for (const ObjectCloud& cloud : clouds) {
      count.mean += static_cast<double>(cloud.size()) / static_cast<double>(clouds.size());
      count.least = std::min<std::uint64_t>(count.least, cloud.size());
      count.most = std::max<std::uint64_t>(count.most, cloud.size());
    }
    return count;
  }

  static LevelFitness fitnessOf(std::span<const Registered> pairs) {
    std::vector<std::optional<double>> after, before;
    LevelFitness cell;
    for (const Registered& r : pairs) {
      after.push_back(r.moved ? r.fitness : std::nullopt);
      before.push_back(r.unmoved);
    }
    cell.pairs = pairs.size();
    cell.registered = fitnessSpread(after);
    cell.unmoved = fitnessSpread(before);
    return cell;
  }

  const Plan& plan_;
  ShotSource source_;
  const RepeatabilityOptions& options_;
  RepeatabilityChoice choice_;
  Channels channels_;
  std::vector<ScanPair> pairs_;
  Progress progress_;
  Repeatability result_;
};

}  // namespace

Repeatability measureRepeatability(const Plan& plan, const RepeatabilityOptions& options) {
  return RepeatabilityRun(plan, options).run();
}

}  // namespace scanmill
