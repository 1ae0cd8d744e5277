#pragma once

// An effect turns the returns of an ideal receiver into those of a real one: it changes, removes and adds rows of the
// table of returns. A new effect needs a new file and a row in effects().

#include <memory>
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
  virtual Channels reads() const = 0;                      // channels of Hits that apply() reads
  virtual bool setsIntensity() const { return false; }     // fills Returns::power and Returns::intensity
  virtual double intensityFullScale() const { return 1; }  // the value that means 1 in the intensity that it sets
  virtual bool needsIntensity() const { return false; }    // cannot run unless an earlier effect sets it
  virtual bool setsSnr() const { return false; }           // fills Returns::snr
  virtual bool needsSnr() const { return false; }          // cannot run unless an earlier effect sets it
  virtual bool setsGain() const { return false; }          // fills Returns::gain, which only matters with intensity
  // Returns how many rays sample the footprint of a beam.
  virtual std::uint32_t raysPerBeam() const { return 1; }
  // Returns how rays continue behind glass and off mirrors; null: they do not.
  virtual const LightPaths* lightPaths() const { return nullptr; }
  // Returns how many returns a beam may have after this effect, given how many it may have before.
  virtual std::uint32_t mostReturns(std::uint32_t before) const { return before; }
  // Throws InputError if the options do not fit the sensor, for example a list that has not one figure per ring.
  virtual void check(const BeamTable& /*beams*/) const {}
  // Sets `power` to the power that each ray receives, times the ray's share of the beam's power; the power of an echo
  // is the sum over its rays. Returns false if this effect does not compute power.
  virtual bool powerOfRays(const Hits& /*hits*/, std::span<const Material> /*materials*/,
                           std::vector<float>& /*power*/) const {
    return false;
  }
  // Reads hits (exact, never changed), changes returns. A beam without a return stays without, unless the effect adds
  // rows. Deterministic: random numbers come from the shot's address. Called from several threads at once.
  virtual void apply(const Hits& hits, const Shot& shot, std::span<const Material> materials,
                     Returns& returns) const = 0;
};

struct EffectEntry {
  std::string_view name;
  std::string_view summary;
  std::string_view keys;  // the options: "name: default, meaning; ..."
  int stage;  // effects run by ascending stage, whatever their order in the YAML: 0 beams, lasers, surfaces, weather
              // and speckle, 1 intensity, 2 detection and dropout, 3 range noise, 4 quantisation, 5 pointing
  std::unique_ptr<Effect> (*make)(Fields& options);
};

// An effect that a pipeline has chosen.
struct ChosenEffect {
  const EffectEntry* entry = nullptr;
  std::shared_ptr<const Effect> effect;
  std::string options;  // as the pipeline gives them, on one line: "{rays: 7}"; empty: none

  const Effect* operator->() const { return effect.get(); }
  const Effect& operator*() const { return *effect; }
};
using Effects = std::vector<ChosenEffect>;  // in the order in which they run
using EffectList = std::span<const ChosenEffect>;

// The needs of all effects of a sensor together.
std::uint32_t raysPerBeam(EffectList effects);     // 1 if no effect samples the footprint
const LightPaths* lightPaths(EffectList effects);  // null: rays end at their first hit
std::uint32_t mostReturns(EffectList effects,
                          std::uint32_t met);   // most returns of a beam whose rays hit `met` surfaces
double intensityFullScale(EffectList effects);  // the intensity that means 1; 0: no effect sets it

std::span<const EffectEntry> effects();
const EffectEntry& requireEffect(std::string_view name, const Location& where);

}  // namespace scanmill
