#include "study/repeatability/repeatability.h"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "base/append_new.h"
#include "base/parallel.h"
#include "config/version.h"
#include "dataset/json_text.h"
#include "evaluate/beam_errors.h"
#include "pipeline/run/progress.h"
#include "pipeline/run/run_shot.h"
#include "pipeline/scenes/shot_source.h"

namespace scanmill {

namespace {

// Returns all object instances of a scene, sorted by instance id.
std::vector<BoxedObject> boxedObjects(const Scene& scene) {
  const std::vector<std::vector<Box>> boxes = objectBoxes(scene);
  std::vector<BoxedObject> objects;
  for (const Instance& instance : scene.instances) {
    const Affine meshFromWorld = inverse(instance.worldFromMesh);
    for (const Box& box : boxes[instance.mesh]) {
      if (!box.empty()) objects.push_back({instance.name, instance.worldFromMesh, meshFromWorld, box});
    }
  }
  return objects;
}

// Returns the object named `name` that is nearest to the sensor's position (world frame, m); if `name` is empty, the
// nearest of all objects. Throws InputError, which names the scene's file, if there is no such object.
const BoxedObject& objectToScan(const std::vector<BoxedObject>& objects, const std::string& name,
                                const Vec3d& sensorPosition, const Scene& scene) {
  const BoxedObject* nearest = nullptr;
  double leastDistance = 0;  // distance of `nearest` (m)
  std::vector<std::string> objectNames;
  for (const BoxedObject& object : objects) {
    appendNew({object.name}, objectNames);
    if (!name.empty() && object.name != name) continue;
    const double distance = object.distance(sensorPosition);
    if (nearest != nullptr && distance >= leastDistance) continue;
    nearest = &object;
    leastDistance = distance;
  }
  if (nearest != nullptr) return *nearest;
  if (objects.empty()) {
    throw InputError({scene.file.string()},
                     "has no thing to scan repeatedly: give an object a class of things, such as `object` or `car`");
  }
  throw InputError({scene.file.string()}, "has no thing '{}'{}", name, suggestion(name, objectNames));
}

using ObjectCloud = std::vector<Vec3f>;  // points relative to the object's centre, along the world's axes (m)

// Returns the points of a scan that are at most `margin` (m) from the object's box. `shot`: the shot of the scan.
ObjectCloud cropToObject(const Scan& scan, const Shot& shot, const BoxedObject& object, double margin) {
  ObjectCloud cloud;
  const Vec3d center = object.center();
  for (std::size_t i = 0; i < scan.size(); ++i) {
    // Points of deskewed scans are in the sensor's frame at the revolution's start, others at the time of their column.
    const std::size_t step = shot.deskew ? 0 : shot.stepOf(scan[kColumn][i]);
    const Vec3d p = shot.worldFromSensor[step] * Vec3d(scan.position[i]);
    if (object.distance(p) <= margin) cloud.push_back(static_cast<Vec3f>(p - center));
  }
  return cloud;
}

// Two clouds from one pose, as indices in the result of cloudsOf(): index = noise level * number of scans + scan.
struct CloudPair {
  std::size_t source, target;
};

// Returns all ordered pairs, sorted by source level, target level, source scan and target scan. Scans with the same
// index have the same random numbers, so they form no pair.
std::vector<CloudPair> cloudPairs(std::size_t levels, std::size_t scans) {
  std::vector<CloudPair> pairs;
  for (std::size_t sourceLevel = 0; sourceLevel < levels; ++sourceLevel) {
    for (std::size_t targetLevel = 0; targetLevel < levels; ++targetLevel) {
      for (std::size_t source = 0; source < scans; ++source) {
        for (std::size_t target = 0; target < scans; ++target) {
          if (source != target) pairs.push_back({sourceLevel * scans + source, targetLevel * scans + target});
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
        pairs_(cloudPairs(choice_.levels.size(), choice_.scans)),
        progress_("repeatability", choice_.methods.size() * plan.pipeline.sensors.size() * plan.pipeline.frames(),
                  "poses", "poses", options.quiet) {}

  // Measures every sequence with every method. The outer loop is over sequences, so that each scene is loaded once; the
  // result is ordered by method instead.
  Repeatability run() {
    describe();
    const Pipeline& pipeline = plan_.pipeline;
    std::unique_ptr<Scene> scene;
    std::vector<std::unique_ptr<Method>> methods;
    std::vector<BoxedObject> objects;
    const std::size_t sensors = pipeline.sensors.size();
    for (std::size_t s = 0; s < pipeline.sequences.size(); ++s) {
      const Sequence& sequence = pipeline.sequences[s];
      if (s == 0 || !sequence.sameScene(pipeline.sequences[s - 1])) {
        methods.clear();
        scene = std::make_unique<Scene>(source_.load(s));
        standStill(*scene, 0);
        for (const MethodSetting& setting : choice_.methods) methods.push_back(makeMethod(setting.choice, *scene));
        objects = boxedObjects(*scene);
      }
      for (std::size_t m = 0; m < methods.size(); ++m) {
        const std::size_t firstView = (m * pipeline.sequences.size() + s) * sensors;
        for (std::uint32_t frame = 0; frame < sequence.frames; ++frame) {
          const std::vector<Shot> shots = source_.frame(s, frame).shots;
          for (std::size_t sensor = 0; sensor < sensors; ++sensor) {
            const Vec3d sensorPosition = shots[sensor].worldFromSensor.front().translation;
            const BoxedObject& object = objectToScan(objects, choice_.object, sensorPosition, *scene);
            result_.views[firstView + sensor].poses.push_back(measurePose(*methods[m], *scene, shots[sensor], object));
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
  // Sets all members of the result except the measurements. Adds an empty view for each method, sequence and sensor;
  // the sensor changes fastest.
  void describe() {
    const Pipeline& pipeline = plan_.pipeline;
    result_.programVersion = kVersion;
    result_.pipelineName = pipeline.name;
    result_.pipelineText = pipeline.text;
    result_.seed = pipeline.seed;
    result_.scans = choice_.scans;
    result_.margin = choice_.margin;
    result_.icpIterations = choice_.icpIterations;
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
          const bool severalSeeds = std::ranges::any_of(pipeline.sequences, [&](const Sequence& other) {
            return other.scene == sequence.scene && other.sceneSeed != sequence.sceneSeed;
          });
          view.name = severalSeeds ? fmt::format("{} {}", sequence.scene, sequence.sceneSeed) : sequence.scene;
          view.name += " " + sequence.trajectoryName;
          if (pipeline.sensors.size() > 1) view.name += " " + sensor.name;
        }
      }
    }
  }

  // Warns if the object has no points at any noise level from some poses of a view.
  void warnOfPosesWithoutPoints() {
    constexpr std::size_t kShownPoses = 5;
    for (const RepeatedView& view : result_.views) {
      std::vector<std::string> blindPoses;  // frame and distance of each pose without points
      std::string object;
      for (const RepeatedPose& pose : view.poses) {
        if (std::ranges::any_of(pose.points, [](const PointCount& c) { return c.most > 0; })) continue;
        blindPoses.push_back(fmt::format("{} ({:.4g} m)", pose.frame, pose.distance));
        object = pose.object;
      }
      if (blindPoses.empty()) continue;
      const std::size_t count = blindPoses.size();
      blindPoses.resize(std::min(count, kShownPoses));
      result_.warnings.push_back(
          fmt::format("{}{}: no point hits {} from {} of {} poses: frame {}{}; is the object in the sensor's field and "
                      "not occluded?",
                      view.name, result_.methods.size() > 1 ? ", " + result_.methods[view.method] : "", object, count,
                      view.poses.size(), fmt::join(blindPoses, ", "), count > kShownPoses ? ", ..." : ""));
    }
  }

  // Warns if all scans of a level are equal: their agreement is then perfect but says nothing about the sensor. Does
  // not warn for `effects: []`, with which equal scans are intended.
  void warnOfNoiseThatMovesNothing() {
    for (std::size_t level = 0; level < choice_.levels.size(); ++level) {
      std::vector<std::string> effectNames;
      for (std::size_t s = 0; s < plan_.pipeline.sensors.size(); ++s) {
        for (const ChosenEffect& effect : *choice_.levels[level].effects[s]) {
          appendNew({std::string(effect.entry->name)}, effectNames);
        }
      }
      if (effectNames.empty() && !choice_.levels[level].fromPipeline) continue;
      bool anyPair = false;
      bool scansDiffer = false;
      for (const RepeatedView& view : result_.views) {
        for (const RepeatedPose& pose : view.poses) {
          const FitnessSpread& withinLevel = result_.at(pose, level, level).unmoved;
          anyPair = anyPair || withinLevel.count > 0;
          scansDiffer = scansDiffer || withinLevel.high > 0;
        }
      }
      if (!anyPair || scansDiffer) continue;
      result_.warnings.push_back(fmt::format(
          "noise '{}': no effect of this noise moves points ({}), so that its scans are all the same: give shell, "
          "range_noise or angular_jitter",
          result_.levels[level],
          effectNames.empty() ? "it has no effects" : fmt::format("{}", fmt::join(effectNames, ", "))));
    }
  }

  bool stopped() const { return options_.stop != nullptr && *options_.stop; }

  // Returns the object's points in each scan of the shot, by noise level, then by seed (see CloudPair). Traces once,
  // since noise does not change the hits.
  std::vector<ObjectCloud> cloudsOf(const Method& method, const Scene& scene, const Shot& shot,
                                    const BoxedObject& object) const {
    Hits hits;
    method.trace(shot, channels_, hits);
    std::vector<ObjectCloud> clouds(choice_.levels.size() * choice_.scans);
    parallelFor(clouds.size(), choice_.scans, [&](std::size_t first, std::size_t last) {
      Shot repeated = shot;
      Returns scratch;
      Scan scan;
      for (std::size_t c = first; c < last; ++c) {
        repeated.seed = shot.seed + c % choice_.scans;
        const Effects& effects = *choice_.levels[c / choice_.scans].effects[shot.sensor];
        senseShot({method, channels_, {effects, scene.materials, kRepeatabilityLayout}}, repeated, hits, scratch, scan);
        clouds[c] = cropToObject(scan, repeated, object, choice_.margin);
      }
    });
    return clouds;
  }

  // Scans the object repeatedly from the pose of the shot and registers all pairs of scans.
  RepeatedPose measurePose(const Method& method, const Scene& scene, const Shot& shot,
                           const BoxedObject& object) const {
    const std::vector<ObjectCloud> clouds = cloudsOf(method, scene, shot, object);
    std::vector<Registered> registered(pairs_.size());
    parallelForEach(pairs_.size(), 1, [&](std::size_t p) {
      if (!stopped())
        registered[p] = registerClouds(clouds[pairs_[p].source], clouds[pairs_[p].target], choice_.icpIterations);
    });
    if (stopped()) throw Error("stopped: nothing was written");

    RepeatedPose pose{.frame = shot.frame,
                      .object = object.name,
                      .distance = object.distance(shot.worldFromSensor.front().translation)};
    for (std::size_t first = 0; first < clouds.size(); first += choice_.scans) {
      pose.points.push_back(countPoints(std::span(clouds).subspan(first, choice_.scans)));
    }
    // The pairs of one source level and one target level are consecutive.
    const std::size_t pairsOfLevels = std::size_t{choice_.scans} * (choice_.scans - 1);
    for (std::size_t first = 0; first < registered.size(); first += pairsOfLevels) {
      pose.fitness.push_back(fitnessOf(std::span(registered).subspan(first, pairsOfLevels)));
    }
    return pose;
  }

  // Returns the numbers of points on the object. `clouds`: the object's points in each scan of a level; not empty.
  static PointCount countPoints(std::span<const ObjectCloud> clouds) {
    PointCount count{.mean = 0, .least = clouds.front().size(), .most = 0};
    for (const ObjectCloud& cloud : clouds) {
      count.mean += static_cast<double>(cloud.size()) / static_cast<double>(clouds.size());
      count.least = std::min<std::uint64_t>(count.least, cloud.size());
      count.most = std::max<std::uint64_t>(count.most, cloud.size());
    }
    return count;
  }

  // Returns the statistics of pairs of scans. `pairs` counts all pairs. `registered` and `unmoved` ignore pairs without
  // a fitness; `registered` also ignores pairs for which ICP found no motion.
  static LevelFitness fitnessOf(std::span<const Registered> pairs) {
    std::vector<std::optional<double>> registered, unmoved;
    for (const Registered& pair : pairs) {
      registered.push_back(pair.moved ? pair.fitness : std::nullopt);
      unmoved.push_back(pair.unmoved);
    }
    return {.registered = fitnessSpread(registered), .unmoved = fitnessSpread(unmoved), .pairs = pairs.size()};
  }

  const Plan& plan_;
  ShotSource source_;
  const RepeatabilityOptions& options_;
  RepeatabilityChoice choice_;
  Channels channels_;
  std::vector<CloudPair> pairs_;
  Progress progress_;
  Repeatability result_;
};

// Returns the spread as JSON; null if there are no pairs, since zeros would suggest perfect agreement.
OrderedJson spreadJson(const FitnessSpread& spread) {
  if (spread.count == 0) return nullptr;
  return {{"pairs", spread.count},
          {"mean", spread.mean},
          {"deviation", spread.deviation},
          {"min", spread.low},
          {"max", spread.high}};
}

// Returns the JSON of a pose, with the points at each noise level and the fitness for each pair of levels.
OrderedJson poseJson(const Repeatability& result, const RepeatedPose& pose) {
  OrderedJson json{{"frame", pose.frame}, {"object", pose.object}, {"distance_m", pose.distance}};
  json["points"] = OrderedJson::array();
  for (std::size_t level = 0; level < result.levels.size(); ++level) {
    const PointCount& count = pose.points[level];
    json["points"].push_back(
        {{"noise", result.levels[level]}, {"mean", count.mean}, {"min", count.least}, {"max", count.most}});
  }
  json["fitness_m2"] = OrderedJson::array();
  for (std::size_t source = 0; source < result.levels.size(); ++source) {
    for (std::size_t target = 0; target < result.levels.size(); ++target) {
      const LevelFitness& cell = result.at(pose, source, target);
      json["fitness_m2"].push_back({{"source", result.levels[source]},
                                    {"target", result.levels[target]},
                                    {"pairs", cell.pairs},
                                    {"registered", spreadJson(cell.registered)},
                                    {"unmoved", spreadJson(cell.unmoved)}});
    }
  }
  return json;
}

}  // namespace

Repeatability measureRepeatability(const Plan& plan, const RepeatabilityOptions& options) {
  return RepeatabilityRun(plan, options).run();
}

std::string repeatabilityJson(const Repeatability& result) {
  OrderedJson json{{"schema", Repeatability::kSchemaVersion},
                   {"program", result.programVersion},
                   {"pipeline", {{"name", result.pipelineName}, {"text", result.pipelineText}}},
                   {"seed", result.seed},
                   {"scans", result.scans},
                   {"margin_m", result.margin},
                   {"icp", {{"iterations", result.icpIterations}}},
                   {"methods", result.methods},
                   {"noise", result.levels},
                   {"reference", result.levels[result.reference]},
                   {"views", OrderedJson::array()}};
  for (const RepeatedView& view : result.views) {
    OrderedJson poses = OrderedJson::array();
    for (const RepeatedPose& pose : view.poses) poses.push_back(poseJson(result, pose));
    json["views"].push_back(
        {{"method", result.methods[view.method]}, {"name", view.name}, {"places", std::move(poses)}});
  }
  return layOut(json) + "\n";
}

}  // namespace scanmill
