#include "evaluate/feature_costs.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "base/parallel.h"
#include "base/stage_clock.h"
#include "base/wall_timer.h"
#include "pipeline/run/run_shot.h"
#include "pipeline/scenes/shot_source.h"

namespace scanmill {

namespace {

constexpr int kFewestRounds = 2;

// The pipeline, unchanged or with one feature added or removed, and the measured times of each round (s).
struct Variant {
  std::string feature;
  bool present = true;
  std::unique_ptr<const Plan> plan;
  std::unique_ptr<ShotSource> source;
  std::shared_ptr<const Scene> scene;
  std::shared_ptr<const Method> method;
  std::vector<double> trace, effects, encode;
  double bytes = 0;
  std::uint64_t points = 0;
};

void runOnce(Variant& v, std::uint32_t frame) {
  const Pipeline& pipeline = v.plan->pipeline;
  ShotBuffers buffers;
  StageClock clock{"trace", "effects", "encode"};
  v.bytes = 0;
  v.points = 0;
  for (const Shot& shot : v.source->frame(0, frame).shots) {
    runShot(setupOf(*v.source, *v.scene, *v.method, shot.sensor), shot, buffers, clock);
    for (const Vec3f& p : buffers.scan.position) v.points += isFinite(p) ? 1 : 0;
    const ThreadLimit one(1);
    const StageTimer timer(clock, "encode");
    for (const ChosenFormat& f : pipeline.output.formats) {
      v.bytes += static_cast<double>(f.format->encode(buffers.scan).size());
    }
  }
  StageSeconds seconds = clock.seconds();
  v.trace.push_back(seconds["trace"]);
  v.effects.push_back(seconds["effects"]);
  v.encode.push_back(seconds["encode"]);
}

// Returns a measure of timing noise: the difference (s) between the fastest odd round and the fastest even round;
// the complete time if there is only one round.
double scatterOf(const Variant& v) {
  double least[2] = {INFINITY, INFINITY};
  for (std::size_t round = 0; round < v.trace.size(); ++round) {
    least[round % 2] = std::min(least[round % 2], v.trace[round] + v.effects[round] + v.encode[round]);
  }
  return v.trace.size() < 2 ? least[0] : std::abs(least[0] - least[1]);
}

FrameCost costOf(const Variant& v) {
  // The minimum is used, since other processes on the machine can only make a round slower.
  return {std::ranges::min(v.trace), std::ranges::min(v.effects), std::ranges::min(v.encode), v.bytes};
}

FrameCost difference(const FrameCost& with, const FrameCost& without) {
  return {with.traceSeconds - without.traceSeconds, with.effectsSeconds - without.effectsSeconds,
          with.encodeSeconds - without.encodeSeconds, with.bytes - without.bytes};
}

// Returns for each effect whether it must be removed together with `entry`. This is true for `entry` itself and, if it
// sets the intensity or the signal-to-noise ratio, for all effects that need these.
std::vector<bool> dependents(EffectList effects, const EffectEntry* entry) {
  const auto any = [&](auto sets) {
    return std::ranges::any_of(effects, [&](const ChosenEffect& e) { return e.entry == entry && sets(*e); });
  };
  const bool lights = any([](const Effect& e) { return e.setsIntensity(); });
  const bool measures = any([](const Effect& e) { return e.setsSnr(); });
  std::vector<bool> go;
  for (const ChosenEffect& e : effects) {
    go.push_back(e.entry == entry || (lights && e->needsIntensity()) || (measures && e->needsSnr()));
  }
  return go;
}

// Removes an effect, and the effects that depend on it, from the lists of all sensors.
void removeEffect(Pipeline& pipeline, const EffectEntry* entry) {
  for (MountedSensor& sensor : pipeline.sensors) {
    const std::vector<bool> go = dependents(*sensor.effects, entry);
    Effects left;
    for (std::size_t e = 0; e < go.size(); ++e) {
      if (!go[e]) left.push_back((*sensor.effects)[e]);
    }
    sensor.effects = std::make_shared<const Effects>(std::move(left));
  }
}

class Features {
 public:
  explicit Features(const Pipeline& pipeline) : pipeline_(pipeline) {
    whole_ = variant("", true, [](Pipeline&) {});
    whole_.scene = std::make_shared<const Scene>(whole_.source->load(0));
    whole_.method = whole_.source->method(*whole_.scene);
    again_ = variant("", true, [](Pipeline&) {});
    share(again_);
    addEffects();
    addColumns();
    addFormats();
    addMotion();
    addAlpha();
  }

  FeatureCosts measure(const FeatureEffort& effort) {
    const Sequence& sequence = pipeline_.sequences.front();
    const std::uint32_t frame = sequence.frames / 2;
    std::vector<Variant*> all{&whole_, &again_};
    for (Variant& v : variants_) all.push_back(&v);
    for (Variant* v : all) {
      for (const Shot& shot : v->source->frame(0, frame).shots) v->method->prepare(shot);
    }
    // The variants run in turn, so that other processes on the machine slow down all of them equally. The first round
    // is a warm-up.
    int rounds = effort.rounds;
    for (int i = 0; i <= rounds; ++i) {
      if (effort.begun) effort.begun(i, rounds);
      const WallTimer timer;
      for (Variant* v : all) {
        runOnce(*v, frame);
        if (i == 0) v->trace.clear(), v->effects.clear(), v->encode.clear();
      }
      if (i > 0) continue;
      const double fitting = std::min(effort.seconds / timer.seconds(), 1e6);
      rounds = std::min(rounds, std::max(kFewestRounds, static_cast<int>(fitting)));
    }
    FeatureCosts costs;
    costs.frame = sequence.key(frame);
    costs.points = whole_.points;
    costs.whole = costOf(whole_);
    const double equal = std::abs(costs.whole.seconds() - costOf(again_).seconds());
    for (const Variant& v : variants_) {
      const FrameCost other = costOf(v);
      costs.features.push_back({v.feature, v.present,
                                v.present ? difference(costs.whole, other) : difference(other, costs.whole),
                                std::max({equal, scatterOf(whole_), scatterOf(v)})});
    }
    return costs;
  }

 private:
  Variant variant(std::string feature, bool present, const auto& change) const {
    Pipeline pipeline = pipeline_;
    change(pipeline);
    Variant v;
    v.feature = std::move(feature);
    v.present = present;
    v.plan = std::make_unique<const Plan>(makePlan(std::move(pipeline)));
    v.source = std::make_unique<ShotSource>(*v.plan);
    return v;
  }

  // Lets a variant use the scene and the method of the unchanged pipeline. The variant's change must affect neither.
  void share(Variant& v) const {
    v.scene = whole_.scene;
    v.method = whole_.method;
  }

  void add(std::string feature, bool present, const auto& change) {
    variants_.push_back(variant(std::move(feature), present, change));
    share(variants_.back());
  }

  // Adds one variant for each effect, without this effect. An effect that several sensors have is counted once.
  void addEffects() {
    std::vector<const EffectEntry*> seen;
    for (const MountedSensor& sensor : pipeline_.sensors) {
      for (const ChosenEffect& effect : *sensor.effects) {
        if (std::ranges::find(seen, effect.entry) != seen.end()) continue;
        seen.push_back(effect.entry);
        const std::vector<bool> go = dependents(*sensor.effects, effect.entry);
        std::string name = fmt::format("effect {}", effect.entry->name);
        for (std::size_t e = 0; e < go.size(); ++e) {
          const EffectEntry* const other = (*sensor.effects)[e].entry;
          if (go[e] && other != effect.entry) name += fmt::format(" and {}", other->name);
        }
        add(std::move(name), true, [&](Pipeline& p) { removeEffect(p, effect.entry); });
      }
    }
  }

  // Adds a variant for each column, with the column added or removed. The intensity is skipped, since it is removed
  // together with its effect. The power is skipped if no effect sets the intensity.
  void addColumns() {
    for (std::size_t c = 0; c < kColumnCount; ++c) {
      if (c == kIntensity.index || (c == kPower.index && !setsIntensity(pipeline_))) continue;
      const bool present = pipeline_.output.layout.columns.has(c);
      add(fmt::format("column {}", kColumns[c].name), present,
          [&](Pipeline& p) { present ? p.output.layout.columns.remove(c) : p.output.layout.columns.add(c); });
    }
  }

  void addFormats() {
    for (std::size_t f = 0; pipeline_.output.formats.size() > 1 && f < pipeline_.output.formats.size(); ++f) {
      add(fmt::format("format {}", pipeline_.output.formats[f].entry->name), true,
          [&](Pipeline& p) { p.output.formats.erase(p.output.formats.begin() + static_cast<std::ptrdiff_t>(f)); });
    }
  }

  void addMotion() {
    const MotionKind kind = pipeline_.motion.kind;
    const bool present = kind != MotionKind::None;
    add("ego motion", present,
        [&](Pipeline& p) { p.motion.kind = present ? MotionKind::None : MotionKind::PerColumn; });
  }

  void addAlpha() {
    const auto tested = [](const Material& m) { return m.alphaTested; };
    if (std::ranges::none_of(whole_.scene->materials, tested)) return;
    Variant v = variant("alpha cut-outs", true, [](Pipeline&) {});
    auto solid = std::make_shared<Scene>(*whole_.scene);
    for (Material& m : solid->materials) m.alphaTested = false;
    v.method = v.source->method(*solid);
    v.scene = std::move(solid);
    variants_.push_back(std::move(v));
  }

  const Pipeline& pipeline_;
  Variant whole_;
  Variant again_;  // a second copy of whole_, which shows by how much measured times of equal frames differ
  std::vector<Variant> variants_;
};

}  // namespace

FeatureCosts measureFeatures(const Pipeline& pipeline, const FeatureEffort& effort) {
  return Features(pipeline).measure(effort);
}

}  // namespace scanmill
