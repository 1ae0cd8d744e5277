#pragma once

// Names of shards: <split>/<split>-000000.tar.

#include <cstdint>
#include <string>
#include <string_view>

namespace scanmill {

inline constexpr std::string_view kManifestName = "manifest.json";

// Lower-case letters, digits, '-' and '_'; not empty.
bool isSplitName(std::string_view split);

std::string shardName(const std::string& split, std::uint64_t number);
// Whether `name`, relative to the dataset's folder, is what shardName() gives for some number.
bool isShardName(std::string_view name);
// Whether `name` is the temporary name of a shard or a manifest of a run that was killed.
bool isLeftover(std::string_view name);

}  // namespace scanmill
