#pragma once

// Reads the calibration of one sensor unit's beams: that of Velodyne's sensors as their ROS drivers keep it (.yaml: a
// map with a list `lasers`, each with `vert_correction` and `rot_correction` in rad and optionally
// `vert_offset_correction` and `horiz_offset_correction` in m), Ouster's metadata (.json: see ouster_metadata.h), and
// tables of beams such as Hesai's (.csv: see beam_files.h).

#include <filesystem>

#include "config/value.h"

namespace scanmill {

// Returns the sensor map `value` with its key `calibration` replaced by keys that the named file gives: elevation_deg,
// ring_order, azimuth_offset_deg, origin_left_m and origin_up_m, and unless the map has them itself, firing_time_us
// (tables) and model, columns, rate_hz, direction, first_azimuth_deg, field_deg, origin_offset_m and origin_height_m
// (Ouster). `source` then names the file too. Velodyne's lasers are sorted from top to bottom, others keep the order of
// their file. A driver's corrections of ranges and intensities are not read. A map without the key is returned
// unchanged. Throws InputError with the place, also if the map has one of the first five keys besides.
// `preset`: the preset that the map adds to; Velodyne's lasers are then sorted like its rings. Null: there is none.
Value withCalibration(const Value& value, const Value* preset = nullptr);

}  // namespace scanmill
