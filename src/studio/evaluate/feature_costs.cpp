#include "evaluate/feature_costs.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>

#include "base/parallel.h"
#include "base/stage_clock.h"
#include "base/wall_timer.h"
#include "pipeline/run/run_shot.h"

namespace scanmill {

namespace {

constexpr int kFewestRounds = 2;

double leastOf(const std::vector<double>& values) {
  return *std::min_element(values.begin(), values.end());
}

// A way to run a frame: the pipeline as it stands, or with one feature changed.
struct Variant {
  std::string feature;
  bool present = true;
  std::unique_ptr<const Plan> plan;
  std::shared_ptr<const Scene> scene;
  std::shared_ptr<const Method> method;
  std::vector<double> trace, effects, encode;
  double bytes = 0;
  std::uint64_t points = 0;
};

void runOnce(Variant& v, std::uint32_t frame) {
  const Pipeline& pipeline = v.plan->pipeline();
  ShotBuffers buffers;
  StageClock clock{"trace", "effects", "encode"};
  v.bytes = 0;
  v.points = 0;
  for (const Shot& shot : v.plan->shots(0, frame)) {
    runShot(setupOf(*v.plan, *v.scene, *v.method, shot.sensor), shot, buffers, clock);
    for (const Vec3f& p : buffers.scan.position) v.points += isFinite(p) ? 1 : 0;
    const ThreadLimit one(1);
    const StageTimer timer(clock, "encode");
    for (const FormatChoice& f : pipeline.formats) {
      v.bytes += static_cast<double>(f.format->encode(buffers.scan).size());
    }
  }
  StageSeconds seconds = clock.seconds();
  v.trace.push_back(seconds["trace"]);
  v.effects.push_back(seconds["effects"]);
  v.encode.push_back(seconds["encode"]);
}

double roundSeconds(const Variant& v, std::size_t round) {
  return v.trace[round] + v.effects[round] + v.encode[round];
}

// By how much the least of the odd rounds differs from that of the even ones.
double scatterOf(const Variant& v) {
  double least[2] = {INFINITY, INFINITY};
  for (std::size_t round = 0; round < v.trace.size(); ++round) {
    least[round % 2] = std::min(least[round % 2], roundSeconds(v, round));
  }
  return v.trace.size() < 2 ? least[0] : std::abs(least[0] - least[1]);
}

FrameCost costOf(const Variant& v) {
  // What else the machine does only adds to a round.
  return {leastOf(v.trace), leastOf(v.effects), leastOf(v.encode), v.bytes};
}

FrameCost difference(const FrameCost& with, const FrameCost& without) {
  return {with.traceSeconds - without.traceSeconds, with.effectsSeconds - without.effectsSeconds,
          with.encodeSeconds - without.encodeSeconds, with.bytes - without.bytes};
}

// Those that go with an effect: itself and, where it sets the intensity or the signal to noise ratio, what looks at
// that.
std::vector<bool> dependents(std::span<const std::unique_ptr<Effect>> effects,
                             std::span<const EffectEntry* const> entries, const EffectEntry* entry) {
  bool lights = false;
  bool measures = false;
  for (std::size_t e = 0; e < entries.size(); ++e) {
    lights |= entries[e] == entry && effects[e]->setsIntensity();
    measures |= entries[e] == entry && effects[e]->setsSnr();
  }
  std::vector<bool> go;
  for (std::size_t e = 0; e < entries.size(); ++e) {
    go.push_back(entries[e] == entry || (lights && effects[e]->needsIntensity()) ||
                 (measures && effects[e]->needsSnr()));
  }
  return go;
}

void removeEffect(std::vector<std::unique_ptr<Effect>>& effects, std::vector<const EffectEntry*>& entries,
                  const EffectEntry* entry) {
  const std::vector<bool> go = dependents(effects, entries, entry);
  for (std::size_t e = go.size(); e-- > 0;) {
    if (!go[e]) continue;
    effects.erase(effects.begin() + static_cast<std::ptrdiff_t>(e));
    entries.erase(entries.begin() + static_cast<std::ptrdiff_t>(e));
  }
}

// From the pipeline's list and from those of its sensors.
void removeEffect(Pipeline& pipeline, const EffectEntry* entry) {
  removeEffect(pipeline.effects, pipeline.effectEntries, entry);
  for (MountedSensor& sensor : pipeline.sensors) {
    if (sensor.ownEffects != nullptr) removeEffect(sensor.ownEffects->effects, sensor.ownEffects->entries, entry);
  }
}

class Features {
 public:
  explicit Features(const std::function<Pipeline()>& reread) : reread_(reread) {
    whole_ = variant("", true, [](Pipeline&) {});
    const Plan& plan = *whole_.plan;
    whole_.scene = std::make_shared<const Scene>(plan.loadScene(plan.pipeline().sequences.front()));
    whole_.method = plan.makeMethod(*whole_.scene);
    again_ = variant("", true, [](Pipeline&) {});
    share(again_);
    addEffects();
    addColumns();
    addFormats();
    addMotion();
    addNormals();
    addAlpha();
  }

  FeatureCosts measure(const FeatureEffort& effort) {
    const Sequence& sequence = whole_.plan->pipeline().sequences.front();
    const std::uint32_t frame = sequence.frames / 2;
    std::vector<Variant*> all{&whole_, &again_};
    for (Variant& v : variants_) all.push_back(&v);
    for (Variant* v : all) {
      for (const Shot& shot : v->plan->shots(0, frame)) v->method->prepare(shot);
    }
    // In turn, so that what else the machine does falls on all alike; the first round warms up.
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
  template <class Change>
  Variant variant(std::string feature, bool present, const Change& change, Channels kept = {}) const {
    Pipeline pipeline = reread_();
    change(pipeline);
    Variant v;
    v.feature = std::move(feature);
    v.present = present;
    v.plan = std::make_unique<const Plan>(std::move(pipeline), kept);
    return v;
  }

  // What the variant changes is not the scene's or the method's business.
  void share(Variant& v) const {
    v.scene = whole_.scene;
    v.method = whole_.method;
  }

  template <class Change>
  void add(std::string feature, bool present, const Change& change, Channels kept = {}) {
    variants_.push_back(variant(std::move(feature), present, change, kept));
    share(variants_.back());
  }

  // Each effect once, whatever sensors have it.
  void addEffects() {
    const Pipeline& pipeline = whole_.plan->pipeline();
    std::vector<const EffectEntry*> seen;
    for (std::size_t s = 0; s < pipeline.sensors.size(); ++s) {
      const auto entries = pipeline.effectEntriesOf(s);
      for (const EffectEntry* entry : entries) {
        if (std::find(seen.begin(), seen.end(), entry) != seen.end()) continue;
        seen.push_back(entry);
        const std::vector<bool> go = dependents(pipeline.effectsOf(s), entries, entry);
        std::string name = fmt::format("effect {}", entry->name);
        for (std::size_t e = 0; e < go.size(); ++e) {
          if (go[e] && entries[e] != entry) name += fmt::format(" and {}", entries[e]->name);
        }
        add(std::move(name), true, [&](Pipeline& p) { removeEffect(p, entry); });
      }
    }
  }

  // The intensity goes with its effect.
  void addColumns() {
    for (std::size_t c = 0; c < kColumnCount; ++c) {
      if (c == kIntensity.index || (c == kPower.index && !setsIntensity(whole_.plan->pipeline()))) continue;
      const bool present = whole_.plan->pipeline().layout.columns.has(c);
      add(fmt::format("column {}", kColumns[c].name), present,
          [&](Pipeline& p) { present ? p.layout.columns.remove(c) : p.layout.columns.add(c); });
    }
  }

  void addFormats() {
    const Pipeline& pipeline = whole_.plan->pipeline();
    for (std::size_t f = 0; pipeline.formats.size() > 1 && f < pipeline.formats.size(); ++f) {
      add(fmt::format("format {}", pipeline.formats[f].entry->name), true,
          [&](Pipeline& p) { p.formats.erase(p.formats.begin() + static_cast<std::ptrdiff_t>(f)); });
    }
  }

  void addMotion() {
    const MotionKind kind = whole_.plan->pipeline().motion.kind;
    const bool present = kind != MotionKind::None;
    add("ego motion", present,
        [&](Pipeline& p) { p.motion.kind = present ? MotionKind::None : MotionKind::PerColumn; });
  }

  // No scan holds normals; recordings do.
  void addNormals() {
    add(
        "normals (kept by --keep-hits)", false, [](Pipeline&) {}, Channel::Normal);
  }

  void addAlpha() {
    const auto tested = [](const Material& m) { return m.alphaTested; };
    if (std::none_of(whole_.scene->materials.begin(), whole_.scene->materials.end(), tested)) return;
    Variant v = variant("alpha cut-outs", true, [](Pipeline&) {});
    auto solid = std::make_shared<Scene>(*whole_.scene);
    for (Material& m : solid->materials) m.alphaTested = false;
    v.method = v.plan->makeMethod(*solid);
    v.scene = std::move(solid);
    variants_.push_back(std::move(v));
  }

  const std::function<Pipeline()>& reread_;
  Variant whole_;
  Variant again_;  // the same once more: how much equal frames differ
  std::vector<Variant> variants_;
};

}  // namespace

FeatureCosts measureFeatures(const std::function<Pipeline()>& reread, const FeatureEffort& effort) {
  return Features(reread).measure(effort);
}

}  // namespace scanmill
