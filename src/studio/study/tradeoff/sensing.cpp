#include <fmt/core.h>

#include <map>
#include <memory>
#include <optional>

#include "base/error.h"
#include "base/parallel.h"
#include "base/stage_clock.h"
#include "config/fields.h"
#include "pipeline/read/effects.h"
#include "pipeline/run/run_shot.h"
#include "study/tradeoff/study.h"

namespace scanmill {

namespace {

constexpr int kFirstNoiseStage = 3;  // EffectEntry::stage of the first effects that only add noise

// Maps an effect's name to the YAML options that replace the pipeline's options; an empty text removes the effect.
using Changes = std::map<std::string, std::string>;

struct Variation {
  std::string name;
  Changes changes;
};

std::string footprintYaml(std::uint32_t rays) {
  return fmt::format("footprint: {{rays: {}}}", rays);
}

std::string lightPathsYaml(std::uint32_t bounces) {
  return fmt::format("light_paths: {{panes: {}, bounces: {}, least: 0.0001}}", kTruePanes, bounces);
}

// Returns the sensor's effects after applying `changes`. Omits effects that only add noise.
Effects changedEffects(const Pipeline& pipeline, const MountedSensor& sensor, const Changes& changes) {
  Value list = sequenceValue();
  for (const Value& item : sensorEffectItems(pipeline.effectItems, sensor)) {
    const std::string name = readNamed(item, "an effect").name;
    if (requireEffect(name, item.where).stage >= kFirstNoiseStage) continue;
    const auto change = changes.find(name);
    if (change == changes.end()) {
      list.items.push_back(item);
    } else if (!change->second.empty()) {
      list.items.push_back(parseYaml(change->second, "study"));
    }
  }
  return readSensorEffects(list, EffectClasses(pipeline), sensor);
}

struct NearestReturn {
  Vec3f position;  // in the sensor's frame (m)
  std::uint16_t label = 0;
  float intensity = 0;  // 0 if the scan has no intensities
};

std::vector<std::optional<NearestReturn>> nearestReturns(const Scan& scan) {
  std::vector<std::optional<NearestReturn>> ofBeams(std::size_t{scan.rings} * scan.columns);
  for (std::size_t i = 0; i < scan.size(); ++i) {
    if (scan[kReturn][i] != 1) continue;  // returns are numbered from the nearest
    ofBeams[std::size_t{scan[kRing][i]} * scan.columns + scan[kColumn][i]] = {
        scan.position[i], scan[kLabel][i], scan[kIntensity].empty() ? 0 : scan[kIntensity][i]};
  }
  return ofBeams;
}

class SensingStudy {
 public:
  SensingStudy(const Plan& plan, const Scene& scene, std::span<const Shot> shots,
               const std::function<void(const std::string&)>& say, const std::function<bool()>& stop)
      : plan_(plan), scene_(scene), shots_(shots), say_(say), stop_(stop) {}

  std::vector<SensingResult> run() {
    const std::vector<Variation> variations = listVariations();
    if (variations.empty()) return {};
    method_ = makeReference(scene_);
    for (const Shot& shot : shots_) method_->prepare(shot);
    std::vector<SensingResult> results;
    results.reserve(variations.size());
    for (const Variation& variation : variations) {
      const bool hasTruth = results.empty() || results.front().failure.empty();
      results.push_back(hasTruth ? measure(variation)
                                 : SensingResult{.name = variation.name, .failure = "the truth could not be measured"});
    }
    return results;
  }

 private:
  // Returns the variations to measure; the first has the complete physics and is the reference.
  std::vector<Variation> listVariations() const {
    const Pipeline& pipeline = plan_.pipeline;
    bool manyRays = false, paths = false, weather = false;  // true: some sensor has the effect
    for (std::size_t s = 0; s < pipeline.sensors.size(); ++s) {
      manyRays = manyRays || pipeline.raysPerBeam(s) > 1;
      paths = paths || pipeline.lightPaths(s) != nullptr;
      for (const ChosenEffect& effect : *pipeline.sensors[s].effects) {
        weather = weather || effect.entry->name == "weather";
      }
    }
    if (!manyRays && !paths && !weather) return {};
    Variation truth{"truth:", {}};
    if (manyRays) {
      truth.changes["footprint"] = footprintYaml(kTrueRays);
      truth.name += fmt::format(" {} rays a beam,", kTrueRays);
    }
    if (paths) {
      truth.changes["light_paths"] = lightPathsYaml(kTrueBounces);
      truth.name += fmt::format(" {} mirrors, {} panes,", kTrueBounces, kTruePanes);
    }
    if (weather) truth.name += " weather,";
    truth.name.pop_back();  // removes the last comma
    std::vector<Variation> list{truth};
    // Adds a variation that differs from the truth by `changes`.
    const auto add = [&](const std::string& name, const Changes& changes) {
      Variation& variation = list.emplace_back(Variation{name, changes});
      variation.changes.insert(truth.changes.begin(), truth.changes.end());  // does not overwrite `changes`
    };
    if (manyRays) {
      add("1 ray a beam", {{"footprint", ""}});
      for (const std::uint32_t rays : kFootprintRays) {
        if (rays > 1 && rays < kTrueRays)
          add(fmt::format("{} rays a beam", rays), {{"footprint", footprintYaml(rays)}});
      }
    }
    if (paths) {
      add("no glass, no mirrors", {{"light_paths", ""}});
      add("glass, no mirrors", {{"light_paths", lightPathsYaml(0)}});
      add("glass and 1 mirror", {{"light_paths", lightPathsYaml(1)}});
    }
    if (weather) add("clear air", {{"weather", ""}});
    if (manyRays && paths) add("1 ray a beam, no glass, no mirrors", {{"footprint", ""}, {"light_paths", ""}});
    if (manyRays || paths) list.push_back({"as the pipeline is", {}});
    return list;
  }

  SensingResult measure(const Variation& variation) {
    SensingResult result{.name = variation.name};
    try {
      std::vector<double> distances;  // distances (m) between the two returns of beams in `both`
      double intensitySum = 0;        // sum of the absolute intensity differences of these beams
      for (std::size_t i = 0; i < shots_.size(); ++i) {
        const std::vector<std::optional<NearestReturn>> found = nearestReturns(scan(variation, shots_[i], result));
        if (truth_.size() <= i) truth_.push_back(found);  // the first variation is the truth
        result.beams += found.size();
        for (std::size_t beam = 0; beam < found.size(); ++beam) {
          const std::optional<NearestReturn>&expected = truth_[i][beam], &actual = found[beam];
          result.missing += expected && !actual ? 1 : 0;
          result.added += !expected && actual ? 1 : 0;
          if (!expected || !actual) continue;
          ++result.both;
          result.sameClass += expected->label == actual->label ? 1 : 0;
          distances.push_back(length(Vec3d(expected->position) - Vec3d(actual->position)));
          intensitySum += std::abs(double{expected->intensity} - double{actual->intensity});
        }
      }
      result.traceSeconds /= static_cast<double>(shots_.size());
      result.effectsSeconds /= static_cast<double>(shots_.size());
      if (result.both > 0) result.intensity = intensitySum / static_cast<double>(result.both);
      result.distance = spreadOf(std::move(distances));
    } catch (const InputError& error) {
      result = {.name = variation.name, .failure = error.what()};
    }
    return result;
  }

  // Returns the scan of a shot with the variation, and adds the times for tracing and effects to the result.
  Scan scan(const Variation& variation, const Shot& shot, SensingResult& result) const {
    if (stop_ && stop_()) throw Error("interrupted: nothing was written");
    if (say_) say_(variation.name);
    const Effects effects = changedEffects(plan_.pipeline, plan_.pipeline.sensors[shot.sensor], variation.changes);
    const std::uint32_t rays = raysPerBeam(effects);
    std::optional<Footprint> footprint;
    if (rays > 1) footprint = makeFootprint(*plan_.sensors[shot.sensor].beams, rays);
    const ScanLayout layout{ColumnSet().with(kLabel).with(kRing).with(kColumn).with(kIntensity).with(kReturn)};
    ShotSetup setup{*method_, channelsFor(effects, layout.columns), {effects, scene_.materials, layout}};
    setup.footprint = footprint ? &*footprint : nullptr;
    setup.paths = lightPaths(effects);
    if (setup.paths != nullptr) setup.channels |= kLightChannels;
    ShotBuffers buffers;
    // The first call of each stage is not timed: it allocates memory.
    traceShot(setup, shot, buffers.hits);
    result.traceSeconds += secondsOf([&] { traceShot(setup, shot, buffers.hits); });
    const ThreadLimit oneThread(1);
    const auto applyEffects = [&] { senseShot(setup, shot, buffers.hits, buffers.returns, buffers.scan); };
    applyEffects();
    result.effectsSeconds += secondsOf(applyEffects);
    return std::move(buffers.scan);
  }

  const Plan& plan_;
  const Scene& scene_;
  std::span<const Shot> shots_;
  const std::function<void(const std::string&)>& say_;
  const std::function<bool()>& stop_;
  std::unique_ptr<Method> method_;
  std::vector<std::vector<std::optional<NearestReturn>>> truth_;  // nearestReturns() of the truth, per shot
};

}  // namespace

std::vector<SensingResult> measureSensing(const Plan& plan, const Scene& scene, std::span<const Shot> shots,
                                          const std::function<void(const std::string&)>& say,
                                          const std::function<bool()>& stop) {
  return SensingStudy(plan, scene, shots, say, stop).run();
}

}  // namespace scanmill
