#pragma once

// An effect turns what the receiver would ideally report into what it does report: it changes, removes and adds rows of
// the table of returns. Adding an effect is a new file and a row in effects().

#include <memory>
#include <span>
#include <string_view>

#include "config/fields.h"
#include "scan/channels.h"
#include "scan/hits.h"
#include "scene/material.h"
#include "sense/returns.h"
#include "sensors/shot.h"

namespace scanmill {

class Effect {
 public:
  virtual ~Effect() = default;
  virtual Channels reads() const = 0;                    // columns of Hits that apply() looks at
  virtual bool setsIntensity() const { return false; }   // fills Returns::power and Returns::intensity
  virtual bool needsIntensity() const { return false; }  // cannot run unless an earlier effect sets it
  virtual bool setsGain() const { return false; }        // fills Returns::gain, which means nothing without intensity
  // Throws InputError where the options do not fit the sensor, such as lists of one figure per ring.
  virtual void check(std::uint32_t /*rings*/) const {}
  // Reads hits (exact, never changed), changes returns. A beam without a return stays one, unless the effect adds rows.
  // Deterministic: random numbers come from the shot's address. Called from several threads at once.
  virtual void apply(const Hits& hits, const Shot& shot, std::span<const Material> materials,
                     Returns& returns) const = 0;
};

struct EffectEntry {
  std::string_view name;
  std::string_view summary;
  std::string_view keys;  // of its options, "name: default, what it is; ..."
  int stage;  // effects run in the order of their stages whatever the YAML's order: 0 what lasers and speckle do, 1
              // intensity, 2 detection, 3 noise, 4 quantisation, 5 pointing
  std::unique_ptr<Effect> (*make)(Fields& options);
};

std::span<const EffectEntry> effects();
const EffectEntry& requireEffect(std::string_view name, const Location& where);

}  // namespace scanmill
