#pragma once

// Reads sensor files, such as those in pipelines/sensors.
//
//   const std::shared_ptr<const BeamTable> beams = makeBeams(readYaml("pipelines/sensors/vlp_16.yaml"));
//
// The keys of a sensor file, besides `pattern: flash`, `raster`, `rosette` and `beams`, for which see beam_patterns.h:
//
//   model: OS1-128                     # name of the sensor, for the manifest
//   source: ...                        # where the sensor's figures were published, for the manifest
//   columns: 1024                      # per revolution (if the field is partial: per field)
//   rate_hz: 10                        # revolutions per second
//   direction: clockwise               # or counterclockwise (default), seen from above
//   first_azimuth_deg: 180             # where column 0 points: 0 is forward, 90 is left (default 0)
//   field_deg: 360                     # horizontal field of view; a partial one is swept from edge to edge (default
//                                      # 360)
//   sweep_ms: 50                       # time in which a partial field is swept (default: the part of the revolution
//   that
//                                      # the field is of a full circle)
//   elevation_deg: [15, 13, ...]       # one per ring, or {top: 15, bottom: -15, rings: 16}
//   ring_order: top_down               # or bottom_up; a list may be `unordered` (default top_down)
//   azimuth_offset_deg: [4.2, ...]     # counter-clockwise, one per ring or a list that is repeated (default 0)
//   origin_offset_m: 0.0158            # distance of the beam origin from the axis of rotation, along the head's
//                                      # azimuth (default 0)
//   origin_height_m: 0.036             # height of the beam origin above the sensor's origin (default 0)
//   origin_left_m: [0.026, ...]        # further offset of the beam origin to the left of the beam: one per ring or one
//                                      # for all
//   origin_up_m: [0.195, ...]          # further offset of the beam origin upwards, perpendicular to the beam
//   calibration: 64e_s2.yaml           # replaces elevation_deg, ring_order, azimuth_offset_deg, origin_left_m and
//                                      # origin_up_m: see calibration.h
//   firing_time_us: [0, 2.3, ...]      # time of each ring within a column; or {step_us: 2.3} from ring to ring; or
//                                      # {file: NAME}, see calibration.h (default 0)
//   turns_while_firing: true           # adds to each ring's azimuth the head's rotation up to the ring's firing time;
//                                      # needed for vendors' azimuths, which lack this rotation (default false)
//   range_m: [0.5, 120]                # nearest and farthest range that is reported
//   divergence_mrad: [3, 1.5]          # full angle of the beam, across and up, or one value for both (default 0). For
//                                      # a Gaussian beam it extends to 1/e^2 of the power, which is 1.699 times the
//                                      # angle at half of the power
//   exit_width_mm: [12.7, 9.5]         # width of the beam at the sensor: across and up, or one value (default 0)
//   beam_shape: gaussian               # or uniform (default gaussian)
//   pulse_ns: 6                        # emitted pulse, full width at half of its maximum
//   effects: [range_noise: {...}]      # for pipelines with `effects: sensor`; not part of the beam table

#include <cstdint>
#include <memory>

#include "config/value.h"
#include "sensors/beams.h"

namespace scanmill {

// The number of beams of a sensor file. The number is known without building the table, so that a plan with too many
// beams is refused before memory is allocated.
struct SensorSize {
  std::uint64_t rings = 0;
  std::uint64_t columns = 0;
};

// Returns the complete map of a sensor: the keys of its preset, if it names one, overridden by the keys of `value`.
// `value` is a sensor of a pipeline, {name:, preset: sensors/os1_128.yaml, mount: {...}, any sensor key}. Each key
// keeps its location in its file. Throws InputError.
[[nodiscard]] Value resolveSensor(const Value& value);

// Both functions read a sensor map, from a sensor file or a pipeline. A sensor has 1 to 4096 rings and 1 to 65536
// columns. They throw InputError with the place.
SensorSize sensorSize(const Value& description);
std::shared_ptr<const BeamTable> makeBeams(const Value& description);

}  // namespace scanmill
