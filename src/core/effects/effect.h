#pragma once

// Effects turn what the beams met into what the sensor reports. Adding one is a new file and a row in effects().

#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include "config/fields.h"
#include "scan/channels.h"
#include "scan/hits.h"
#include "scan/scan.h"
#include "scene/material.h"
#include "sensors/shot.h"

namespace scanmill {

// What the sensor would report, one entry per beam (ring * columns + column); effects change it in turn.
struct Returns {
  std::vector<float> range;      // m along the beam; kMiss: nothing is reported. Starts as Hits::range
  std::vector<float> power;      // of the echo, before the sensor's response; empty until an effect sets it
  std::vector<float> intensity;  // what the sensor makes of the power; empty until an effect sets it
  // m, sensor axes, added to origin + range * direction; empty until an effect needs it.
  std::vector<Vec3f> displacement;
};

class Effect {
 public:
  virtual ~Effect() = default;
  virtual Channels reads() const = 0;                    // columns of Hits that apply() looks at
  virtual bool setsIntensity() const { return false; }   // fills Returns::power and Returns::intensity
  virtual bool needsIntensity() const { return false; }  // cannot run unless an earlier effect sets it
  // Reads hits (exact, never changed), changes returns. A miss stays a miss. Deterministic: random numbers come from
  // the shot's address. Called from several threads at once.
  virtual void apply(const Hits& hits, const Shot& shot, std::span<const Material> materials,
                     Returns& returns) const = 0;
};

struct EffectEntry {
  std::string_view name;
  std::string_view summary;
  std::string_view keys;  // of its options, "name: default, what it is; ..."
  int stage;  // effects run in the order of their stages whatever the YAML's order: 0 intensity, 1 detection, 2 noise,
              // 3 quantisation, 4 pointing
  std::unique_ptr<Effect> (*make)(Fields& options);
};

std::span<const EffectEntry> effects();
const EffectEntry& requireEffect(std::string_view name, const Location& where);

// Which columns a scan keeps.
struct ScanColumns {
  bool organised = false;
  bool intensity = true;
  bool label = true;
  bool instance = true;
  bool ring = true;
  bool column = true;
  bool time = true;
  bool rangeTrue = false;
  bool incidence = false;
};

// Channels of Hits that the effects and the columns need.
Channels channelsFor(std::span<const std::unique_ptr<Effect>> effects, const ScanColumns& columns);

// Applies the effects in their given order and keeps the columns asked for. Where no effect sets intensity, the column
// is left out. Dense scans are ordered by column, then ring: the order of firing. `scratch` is reused between calls.
void sense(const Hits& hits, const Shot& shot, std::span<const std::unique_ptr<Effect>> effects,
           std::span<const Material> materials, const ScanColumns& columns, Returns& scratch, Scan& scan);

}  // namespace scanmill
