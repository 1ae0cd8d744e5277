#pragma once

// Tokens, times and file names of the layout of nuScenes, which is described in nuscenes.cpp.

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

#include "exports/layout.h"

namespace scanmill {

inline constexpr std::string_view kNuScenesVersion = "v1.0-trainval";
inline constexpr double kNuScenesDay = 86400;  // s, time from the start of a scene to the start of the next one

// Returns the token (key) of a row of a table: the first 32 hexadecimal digits of the SHA-256 of the dataset's name,
// the table's name and `row`, a text that identifies the row. The same dataset therefore always has the same tokens.
std::string nuScenesToken(const ExportPlan& plan, std::string_view table, std::string_view row);

// nuScenesTime() returns the start of a scan (microseconds of Unix time), nuScenesDate() a sequence's day (YYYY-MM-DD).
// The first sequence is on 2020-01-01, and each further sequence is one day later.
std::int64_t nuScenesTime(std::size_t sequence, const ScanRecord& scan);
std::string nuScenesDate(std::size_t sequence);

// Returns the channel of an exported sensor (index in ExportPlan::sensors): "LIDAR_TOP" for the first one, and for the
// others "LIDAR_" with the sensor's name in capital letters, such as "LIDAR_FRONT_LEFT".
std::string nuScenesChannel(const ExportPlan& plan, std::size_t sensor);

// Returns the text that identifies a sensor's scan of a sample, for nuScenesToken(). `revolution`: see ScanRecord.
std::string nuScenesScan(const ExportPlan& plan, const SampleRecord& sample, std::size_t sensor,
                         std::uint32_t revolution = 0);

// pointsFile() and labelFile() return paths relative to the output folder. A sensor's first revolution in a sample is
// the key frame and has labels; later revolutions are sweeps and have no labels.
std::filesystem::path pointsFile(const ExportPlan& plan, std::size_t sequence, const SampleRecord& sample,
                                 std::size_t sensor, const ScanRecord& scan);
enum class NuScenesLabels { Lidarseg, Panoptic };
std::filesystem::path labelFile(const ExportPlan& plan, const SampleRecord& sample, std::size_t sensor,
                                NuScenesLabels kind);

// Writes all tables, splits.json and the map, and creates the folders that may stay empty. Returns the number of boxes.
std::size_t writeNuScenesTables(const ExportPlan& plan, const ReadObjects& read, const ExportFolder& folder);

}  // namespace scanmill
