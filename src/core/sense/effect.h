#pragma once

// An effect turns what the receiver would ideally report into what it does report: it changes, removes and adds rows of
// the table of returns. Adding an effect is a new file and a row in effects().

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
  virtual Channels reads() const = 0;                      // columns of Hits that apply() looks at
  virtual bool setsIntensity() const { return false; }     // fills Returns::power and Returns::intensity
  virtual double intensityFullScale() const { return 1; }  // what stands for 1 in the intensity that it sets
  virtual bool needsIntensity() const { return false; }    // cannot run unless an earlier effect sets it
  virtual bool setsSnr() const { return false; }           // fills Returns::snr
  virtual bool needsSnr() const { return false; }          // cannot run unless an earlier effect sets it
  virtual bool setsGain() const { return false; }          // fills Returns::gain, which means nothing without intensity
  // How many rays sample the footprint of a beam.
  virtual std::uint32_t raysPerBeam() const { return 1; }
  // How rays go on behind glass and off mirrors; null: they do not.
  virtual const LightPaths* lightPaths() const { return nullptr; }
  // How many returns a beam may have after the effect, that may have so many before.
  virtual std::uint32_t mostReturns(std::uint32_t before) const { return before; }
  // Throws InputError where the options do not fit the sensor, such as lists of one figure per ring.
  virtual void check(const BeamTable& /*beams*/) const {}
  // The power that comes back from each ray, with its share of the beam's: what echoes add up. False: it is not this
  // effect that knows.
  virtual bool powerOfRays(const Hits& /*hits*/, std::span<const Material> /*materials*/,
                           std::vector<float>& /*power*/) const {
    return false;
  }
  // Reads hits (exact, never changed), changes returns. A beam without a return stays one, unless the effect adds rows.
  // Deterministic: random numbers come from the shot's address. Called from several threads at once.
  virtual void apply(const Hits& hits, const Shot& shot, std::span<const Material> materials,
                     Returns& returns) const = 0;
};

struct EffectEntry {
  std::string_view name;
  std::string_view summary;
  std::string_view keys;  // of its options, "name: default, what it is; ..."
  int stage;  // effects run in the order of their stages whatever the YAML's order: 0 what beams, lasers and speckle
              // do, 1 intensity, 2 detection, 3 noise, 4 quantisation, 5 pointing
  std::unique_ptr<Effect> (*make)(Fields& options);
};

// An effect as a pipeline chooses it.
struct ChosenEffect {
  const EffectEntry* entry = nullptr;
  std::shared_ptr<const Effect> effect;
  std::string options;  // as the pipeline has them, on one line: "{rays: 7}"; empty: none

  const Effect* operator->() const { return effect.get(); }
  const Effect& operator*() const { return *effect; }
};
using Effects = std::vector<ChosenEffect>;  // in the order in which they run
using EffectList = std::span<const ChosenEffect>;

// What the effects of a sensor together ask for.
std::uint32_t raysPerBeam(EffectList effects);                     // 1 where none samples the footprint
const LightPaths* lightPaths(EffectList effects);                  // null: rays end at what they meet first
std::uint32_t mostReturns(EffectList effects, std::uint32_t met);  // of a beam, whose rays meet so many surfaces
double intensityFullScale(EffectList effects);                     // what stands for 1; 0: none sets the intensity

std::span<const EffectEntry> effects();
const EffectEntry& requireEffect(std::string_view name, const Location& where);

}  // namespace scanmill
