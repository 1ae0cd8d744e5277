#pragma once

// Tokens, times and file names in the layout of nuScenes. The layout is described in nuscenes.cpp.

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

#include "exports/layout.h"

namespace scanmill {

inline constexpr std::string_view kNuScenesVersion = "v1.0-trainval";
inline constexpr double kNuScenesDay = 86400;  // s, the time that each scene has for itself

// Returns the key of a row of a table: the first 32 hexadecimal digits of the SHA-256 of the names of dataset and table
// and of `row`, which identifies the row. So the same dataset always has the same tokens.
std::string nuScenesToken(const ExportPlan& plan, std::string_view table, std::string_view row);

// These return the time at which a scan starts (microseconds of Unix time) and the day of a sequence (YYYY-MM-DD). The
// first sequence is on 2020-01-01, each of the others one day after the sequence before it.
std::int64_t nuScenesTime(std::size_t sequence, const ScanRecord& scan);
std::string nuScenesDate(std::size_t sequence);

// Return the files of a frame, relative to the folder of the exported dataset.
std::filesystem::path lidarTopFile(const ExportPlan& plan, std::size_t sequence, std::size_t frame);
std::filesystem::path lidarsegFile(const ExportPlan& plan, const SampleRecord& sample);
std::filesystem::path panopticFile(const ExportPlan& plan, const SampleRecord& sample);

}  // namespace scanmill
