#pragma once

// What the layout of nuScenes calls things: tokens, times and files. The layout is described in nuscenes.cpp.

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

#include "exports/layout.h"

namespace scanmill {

inline constexpr std::string_view kNuScenesVersion = "v1.0-trainval";
inline constexpr double kNuScenesDay = 86400;  // s, that each scene has to itself

// The key of a row of a table: 32 hexadecimal digits, the beginning of the SHA-256 of the dataset's name, the table's
// and what the row stands for. So the same dataset always has the same tokens.
std::string nuScenesToken(const ExportPlan& plan, std::string_view table, std::string_view row);

// When a scan begins, in microseconds of Unix' time, and on which day (YYYY-MM-DD): the first sequence is on
// 2020-01-01, each other on the day after the one before.
std::int64_t nuScenesTime(std::size_t sequence, const ScanRecord& scan);
std::string nuScenesDate(std::size_t sequence);

// Files of a frame, relative to the folder of the dataset.
std::filesystem::path lidarTopFile(const ExportPlan& plan, std::size_t sequence, std::size_t frame);
std::filesystem::path lidarsegFile(const ExportPlan& plan, const SampleRecord& sample);
std::filesystem::path panopticFile(const ExportPlan& plan, const SampleRecord& sample);

}  // namespace scanmill
