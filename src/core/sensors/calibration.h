#pragma once

// Reads calibration files with the beams of one sensor unit. Three kinds are known: the files of Velodyne's ROS drivers
// (.yaml: a map with a list `lasers`, each with `vert_correction` and `rot_correction` in rad and optionally
// `vert_offset_correction` and `horiz_offset_correction` in m), Ouster's metadata (.json: see ouster_metadata.h), and
// tables of beams such as Hesai's (.csv: see beam_files.h).

#include <filesystem>

#include "config/value.h"

namespace scanmill {

struct FormatSupport;
const FormatSupport& velodyneFormat();

// Returns the sensor map `value` with its key `calibration` replaced by keys from the calibration file: elevation_deg,
// ring_order, azimuth_offset_deg, origin_left_m and origin_up_m. Further keys are added unless the map has them:
// firing_time_us (tables) and model, columns, rate_hz, direction, first_azimuth_deg, field_deg, origin_offset_m and
// origin_height_m (Ouster). The key `source` then also names the file. A map without the key `calibration` is returned
// unchanged. Velodyne's lasers are sorted from top to bottom, or from bottom to top if the preset has this ring order;
// other lasers keep the order of their file. Throws InputError with the place, also if the map has both `calibration`
// and one of the first five keys. `preset`: the preset that the map overrides; null if there is no preset.
[[nodiscard]] Value withCalibration(const Value& value, const Value* preset = nullptr);

}  // namespace scanmill
