#pragma once

// Names of shards in a dataset's folder: <split>/<split>-000000.tar.

#include <cstdint>
#include <string>
#include <string_view>

namespace scanmill {

inline constexpr std::string_view kManifestName = "manifest.json";
// Where a dataset lies while it is made (dataset_folder.h); no reader looks into it.
inline constexpr std::string_view kHiddenName = ".scanmill";

// Whether a split may have this name: it holds lower-case letters, digits, '-' and '_', at least one.
bool isSplitName(std::string_view split);

// The name of a split's shard, relative to the dataset's folder; numbers count from 0.
std::string shardName(const std::string& split, std::uint64_t number);
// Whether `name`, relative to the dataset's folder, is what shardName() gives for some number.
bool isShardName(std::string_view name);
// Whether `name` is the temporary name of a shard, of the file beside it, or of a manifest, of a run that was killed.
bool isLeftover(std::string_view name);

}  // namespace scanmill
