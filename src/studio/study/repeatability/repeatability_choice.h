#pragma once

// What a repeatability study compares: the key `repeatability:` of a pipeline. All of it may be left out.
//
//   repeatability:
//     scans: 5                      # of each pose, with the seeds seed, seed + 1, ...
//     noise:                        # levels; default: one, the pipeline's own effects
//       - {name: 1 cm, effects: [{shell: {scale_m: 0.01}}]}
//       - {name: fitted, effects: sensor}      # those of the sensor's own file
//     reference: 1 cm               # the level of the first charts (default: the first)
//     methods: [ray_tracing, {depth_camera: {resolution: 512}}]   # default: the pipeline's own
//     object: crate                 # name of the thing in the scene (default: the one nearest to the sensor)
//     margin_m: 0.1                 # points farther from the thing's box are cropped away
//     icp: {iterations: 10, reach_m: 0.5, fitness_within_m: 0.5}  # default: as PCL's, 10 and no limits

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "evaluate/registration.h"
#include "pipeline/pipeline.h"
#include "pipeline/settings.h"
#include "sense/sense.h"

namespace scanmill {

struct NoiseLevel {
  std::string name;
  std::vector<SensorEffects> own;  // per sensor; empty: the pipeline's

  std::span<const EffectEntry* const> entries(const Pipeline& pipeline, std::size_t sensor) const {
    return own.empty() ? pipeline.effectEntriesOf(sensor) : own[sensor].entries;
  }
  std::span<const std::unique_ptr<Effect>> effects(const Pipeline& pipeline, std::size_t sensor) const {
    return own.empty() ? pipeline.effectsOf(sensor) : own[sensor].effects;
  }
};

struct RepeatabilityChoice {
  std::uint32_t scans = 5;
  std::vector<NoiseLevel> levels;
  std::size_t reference = 0;  // index into levels
  std::vector<MethodSetting> methods;
  std::string object;   // empty: the nearest thing
  double margin = 0.1;  // m
  IcpOptions icp;
};

// Throws InputError with the place.
RepeatabilityChoice readRepeatabilityChoice(const Pipeline& pipeline);

// What the scans keep of the sensor's report: where points are, and which column fired them.
ScanLayout repeatabilityLayout();
// Channels that the noise levels read; a plan must know of them to load textures.
Channels repeatabilityChannels(const Pipeline& pipeline);

}  // namespace scanmill
