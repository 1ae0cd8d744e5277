#pragma once

// An effect turns the returns of an ideal receiver into the returns of a real one: it changes, removes and adds rows of
// the table of returns. A new effect needs a new file, a maker below and a row in effects().
//
//   const Value keys = parseYaml("sigma_m: 0.02", "effects.yaml");
//   Fields options(keys, "effect range_noise");
//   const EffectEntry& noise = requireEffect("range_noise", {});
//   const Effects effects{{&noise, noise.make(options), "{sigma_m: 0.02}"}};  // for Receiver::effects

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "config/fields.h"
#include "scan/channels.h"
#include "scan/hits.h"
#include "scene/material.h"
#include "sense/returns.h"
#include "sensors/shot.h"

namespace scanmill {

struct LightPaths;

class Effect {
 public:
  virtual ~Effect() = default;
  // Returns the channels of Hits that apply() reads. Every effect needs the ranges.
  virtual Channels reads() const { return Channel::Range; }
  virtual bool setsIntensity() const { return false; }     // true: apply() fills Returns::power and Returns::intensity
  virtual double intensityFullScale() const { return 1; }  // full scale of the intensity: 255 for bytes, else 1
  virtual bool needsIntensity() const { return false; }    // apply() requires an earlier effect with setsIntensity()
  virtual bool setsSnr() const { return false; }           // apply() fills Returns::snr
  virtual bool needsSnr() const { return false; }          // apply() requires an earlier effect with setsSnr()
  virtual bool setsGain() const { return false; }          // apply() fills Returns::gain
  // Returns how the power depends on the range; nullopt: this effect does not compute power.
  virtual std::optional<Falloff> falloff() const { return std::nullopt; }
  // Returns the power that is detected with a probability of one half; 0: this effect does not lose faint echoes.
  virtual double threshold() const { return 0; }
  // Returns the number of rays that sample the footprint of a beam.
  virtual std::uint32_t raysPerBeam() const { return 1; }
  // Returns how rays continue behind glass and off mirrors; null: they do not continue.
  virtual const LightPaths* lightPaths() const { return nullptr; }
  // Returns the largest number of returns of a beam after this effect. `before`: the largest number before it.
  virtual std::uint32_t mostReturns(std::uint32_t before) const { return before; }
  // Throws InputError if the options do not fit the sensor, for example if a list does not have one value per ring.
  virtual void check(const BeamTable& /*beams*/) const {}
  // Returns the effect's assumptions for values that the sensor's file lacks, as a phrase for users; may be empty.
  virtual std::string assumed(const BeamTable& /*beams*/) const { return {}; }
  // Sets `power` to the power that the receiver gets from each ray, weighted by the ray's fraction of the beam's power,
  // so that the power of an echo is the sum over its rays. Returns false if this effect does not compute power.
  [[nodiscard]] virtual bool powerOfRays(const Hits& /*hits*/, std::span<const Material> /*materials*/,
                                         std::vector<float>& /*power*/) const {
    return false;
  }
  // Changes the returns. `hits` are exact and never change. A beam without a return stays without one, unless the
  // effect adds rows. The result is deterministic, because random numbers depend on the shot's address. May be called
  // from several threads at once.
  virtual void apply(const Hits& hits, const Shot& shot, std::span<const Material> materials,
                     Returns& returns) const = 0;
};

struct EffectEntry {
  std::string_view name;
  std::string_view summary;
  std::string_view keys;  // the options, a line for each: "name: default, meaning"
  int stage;  // effects run by ascending stage, whatever their order in the YAML: 0 beams, lasers, surfaces, weather
              // and speckle, 1 intensity, 2 detection and dropout, 3 range errors, 4 quantisation, 5 pointing
  std::unique_ptr<Effect> (*make)(Fields& options);
};

// An effect that a pipeline uses.
struct ChosenEffect {
  const EffectEntry* entry = nullptr;
  std::shared_ptr<const Effect> effect;
  std::string options;  // the options as the pipeline gives them, on one line: "{rays: 7}"; empty: none

  const Effect* operator->() const { return effect.get(); }
  const Effect& operator*() const { return *effect; }
};
using Effects = std::vector<ChosenEffect>;  // ordered by stage, as they run
using EffectList = std::span<const ChosenEffect>;

// The requirements of all effects of a sensor together.
std::uint32_t raysPerBeam(EffectList effects);     // rays per beam; 1: no effect samples footprints
const LightPaths* lightPaths(EffectList effects);  // null: rays end at their first hit
std::uint32_t mostReturns(EffectList effects);     // returns per beam at most
double intensityFullScale(EffectList effects);     // full scale of the intensity; 0: no effect sets it

std::span<const EffectEntry> effects();
const EffectEntry& requireEffect(std::string_view name, const Location& where);

}  // namespace scanmill
