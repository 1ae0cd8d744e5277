#pragma once

// Reads what vendors and drivers say of a unit's beams: the calibration of Velodyne's sensors as their ROS drivers keep
// it (.yaml: a map with a list `lasers`, of which each has `vert_correction` and `rot_correction` in rad and may have
// `vert_offset_correction` and `horiz_offset_correction` in m), Ouster's metadata (.json: see ouster_metadata.h), and
// tables of beams such as Hesai's (.csv: see beam_files.h).

#include <filesystem>

#include "config/value.h"

namespace scanmill {

// The sensor map `value` with what its key `calibration` names in place of that key: elevation_deg, ring_order,
// azimuth_offset_deg, origin_left_m and origin_up_m, lasers of Velodyne's sorted from top to bottom, others in the
// order of their file; of Ouster's, unless the map says it itself, model, columns, rate_hz, direction,
// first_azimuth_deg, field_deg, origin_offset_m and origin_height_m too; and `source` names the file. A map without the
// key stays as it is. What a driver takes off ranges and intensities is not read. Throws InputError with the place,
// also where the map has one of the first five keys besides.
// `preset`: what is beside it; lasers of Velodyne's are then sorted as its rings are. Null: there is none.
Value withCalibration(const Value& value, const Value* preset = nullptr);

}  // namespace scanmill
