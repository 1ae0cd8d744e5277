#pragma once

// Reads the calibration of a multi-laser sensor as the ROS drivers of Velodyne sensors keep it: a YAML map with a list
// `lasers`, of which each has `vert_correction` and `rot_correction` (rad) and may have `vert_offset_correction` and
// `horiz_offset_correction` (m).

#include <filesystem>

#include "config/value.h"

namespace scanmill {

// The sensor map `value` with what its key `calibration` names in place of that key: elevation_deg (top down),
// azimuth_offset_deg, origin_left_m and origin_up_m, lasers sorted from top to bottom; and `source` names the file. A
// map without the key stays as it is. The laser's range corrections are what its driver takes off, and its intensity
// corrections say nothing of geometry: neither is read. Throws InputError with the place, also where the map has one of
// these keys besides.
Value withCalibration(const Value& value);

}  // namespace scanmill
