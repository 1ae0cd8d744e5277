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

// Effect name -> YAML options that replace the pipeline's; an empty text removes the effect.
using Changes = std::map<std::string, std::string>;

struct Variation {
  std::string name;
  Changes changes;
};

std::string footprintOf(std::uint32_t rays) {
  return fmt::format("footprint: {{rays: {}}}", rays);
}

std::string lightPathsOf(std::uint32_t bounces) {
  return fmt::format("light_paths: {{panes: {}, bounces: {}, least: 0.0001}}", kTruePanes, bounces);
}

Effects changedEffects(const Pipeline& pipeline, const MountedSensor& sensor, const Changes& changes) {
  Value list;
  list.kind = Value::Kind::Sequence;
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

// The effects and the setup of one sensor in one variation.
struct VariedSensor {
  Effects effects;
  std::optional<Footprint> footprint;
  ShotSetup setup;
};

std::unique_ptr<VariedSensor> makeSensor(const Plan& plan, const Scene& scene, const Method& method, std::size_t sensor,
                                         const Changes& changes) {
  ScanLayout layout;
  layout.columns = ColumnSet().with(kLabel).with(kRing).with(kColumn).with(kIntensity).with(kReturn);
  auto varied =
      std::make_unique<VariedSensor>(VariedSensor{changedEffects(plan.pipeline, plan.pipeline.sensors[sensor], changes),
                                                  std::nullopt,
                                                  {method, {}, {{}, scene.materials, layout}}});
  const BeamTable& beams = *plan.sensors[sensor].beams;
  const std::uint32_t rays = raysPerBeam(varied->effects);
  if (rays > 1) varied->footprint = makeFootprint(beams, rays);
  varied->setup.receiver.effects = varied->effects;
  varied->setup.channels = channelsFor(varied->effects, layout.columns);
  varied->setup.footprint = varied->footprint ? &*varied->footprint : nullptr;
  varied->setup.paths = lightPaths(varied->effects);
  if (varied->setup.paths != nullptr) varied->setup.channels |= kLightChannels;
  return varied;
}

struct NearestReturn {
  bool hit = false;
  Vec3f position;
  std::uint16_t label = 0;
  float intensity = 0;
};

std::vector<NearestReturn> nearestReturns(const Scan& scan) {
  std::vector<NearestReturn> ofBeam(std::size_t{scan.rings} * scan.columns);
  for (std::size_t i = 0; i < scan.size(); ++i) {
    if (scan[kReturn][i] != 1) continue;
    ofBeam[std::size_t{scan[kRing][i]} * scan.columns + scan[kColumn][i]] = {
        true, scan.position[i], scan[kLabel][i], scan[kIntensity].empty() ? 0 : scan[kIntensity][i]};
  }
  return ofBeam;
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
    for (const Variation& variation : variations) results.push_back(measure(variation));
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
      truth.changes["footprint"] = footprintOf(kTrueRays);
      truth.name += fmt::format(" {} rays a beam,", kTrueRays);
    }
    if (paths) {
      truth.changes["light_paths"] = lightPathsOf(kTrueBounces);
      truth.name += fmt::format(" {} mirrors, {} panes,", kTrueBounces, kTruePanes);
    }
    if (weather) truth.name += " weather,";
    truth.name.pop_back();  // the last comma
    std::vector<Variation> list{truth};
    const auto add = [&](const std::string& name, const Changes& changes) {
      list.push_back({name, truth.changes});
      for (const auto& [effect, options] : changes) list.back().changes[effect] = options;
    };
    if (manyRays) {
      add("1 ray a beam", {{"footprint", ""}});
      for (const std::uint32_t rays : kFootprintRays) {
        if (rays > 1 && rays < kTrueRays) add(fmt::format("{} rays a beam", rays), {{"footprint", footprintOf(rays)}});
      }
    }
    if (paths) {
      add("no glass, no mirrors", {{"light_paths", ""}});
      add("glass, no mirrors", {{"light_paths", lightPathsOf(0)}});
      add("glass and 1 mirror", {{"light_paths", lightPathsOf(1)}});
    }
    if (weather) add("clear air", {{"weather", ""}});
    if (manyRays && paths) add("1 ray a beam, no glass, no mirrors", {{"footprint", ""}, {"light_paths", ""}});
    if (manyRays || paths) list.push_back({"as the pipeline is", {}});
    return list;
  }

  SensingResult measure(const Variation& variation) {
    SensingResult result;
    result.name = variation.name;
    try {
      std::vector<double> distances;
      double intensity = 0;
      for (std::size_t i = 0; i < shots_.size(); ++i) compare(variation, i, result, distances, intensity);
      result.traceSeconds /= static_cast<double>(shots_.size());
      result.effectsSeconds /= static_cast<double>(shots_.size());
      if (result.both > 0) result.intensity = intensity / static_cast<double>(result.both);
      result.distance = spreadOf(std::move(distances));
    } catch (const InputError& error) {
      result = {};
      result.name = variation.name;
      result.failure = error.what();
    }
    return result;
  }

  void compare(const Variation& variation, std::size_t i, SensingResult& result, std::vector<double>& distances,
               double& intensity) {
    if (stop_ && stop_()) throw Error("interrupted: nothing was written");
    if (say_) say_(variation.name);
    const Shot& shot = shots_[i];
    const auto sensor = makeSensor(plan_, scene_, *method_, shot.sensor, variation.changes);
    ShotBuffers buffers;
    traceShot(sensor->setup, shot, buffers.hits);  // first without timing, to allocate memory
    const WallTimer tracing;
    traceShot(sensor->setup, shot, buffers.hits);
    result.traceSeconds += tracing.seconds();
    {
      const ThreadLimit one(1);
      senseShot(sensor->setup, shot, buffers.hits, buffers.returns, buffers.scan);
      const WallTimer effects;
      senseShot(sensor->setup, shot, buffers.hits, buffers.returns, buffers.scan);
      result.effectsSeconds += effects.seconds();
    }
    const std::vector<NearestReturn> found = nearestReturns(buffers.scan);
    if (truth_.size() <= i) truth_.push_back(found);
    const std::vector<NearestReturn>& truth = truth_[i];
    result.beams += truth.size();
    for (std::size_t beam = 0; beam < truth.size(); ++beam) {
      result.missing += truth[beam].hit && !found[beam].hit ? 1 : 0;
      result.added += !truth[beam].hit && found[beam].hit ? 1 : 0;
      if (!truth[beam].hit || !found[beam].hit) continue;
      ++result.both;
      result.sameClass += truth[beam].label == found[beam].label ? 1 : 0;
      distances.push_back(length(Vec3d(truth[beam].position) - Vec3d(found[beam].position)));
      intensity += std::abs(double{truth[beam].intensity} - double{found[beam].intensity});
    }
  }

  const Plan& plan_;
  const Scene& scene_;
  std::span<const Shot> shots_;
  const std::function<void(const std::string&)>& say_;
  const std::function<bool()>& stop_;
  std::unique_ptr<Method> method_;
  std::vector<std::vector<NearestReturn>> truth_;  // nearest return of each beam in the reference scan, per shot
};

}  // namespace

std::vector<SensingResult> measureSensing(const Plan& plan, const Scene& scene, std::span<const Shot> shots,
                                          const std::function<void(const std::string&)>& say,
                                          const std::function<bool()>& stop) {
  return SensingStudy(plan, scene, shots, say, stop).run();
}

}  // namespace scanmill
