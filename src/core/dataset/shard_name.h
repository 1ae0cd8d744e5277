#pragma once

// Names of shards in a dataset's folder: <split>/<split>-000000.tar.

#include <cstdint>
#include <string>
#include <string_view>

namespace scanmill {

inline constexpr std::string_view kManifestName = "manifest.json";
// The folder that holds a dataset until it is complete (dataset_folder.h); readers ignore it.
inline constexpr std::string_view kHiddenName = ".scanmill";

// True if a split may have this name: it is not empty and has only lower-case letters, digits, '-' and '_'.
bool isSplitName(std::string_view split);

// Returns the name of a split's shard, relative to the dataset's folder; numbers count from 0.
std::string shardName(const std::string& split, std::uint64_t number);
// True if `name`, relative to the dataset's folder, is a name that shardName() returns.
bool isShardName(std::string_view name);
// True if `name` is a temporary name, left by a killed run, of a shard, of the file beside a shard, or of a manifest.
bool isLeftover(std::string_view name);

}  // namespace scanmill
