#pragma once

// Names of shards in a dataset's folder, <split>/<split>-000000.tar, and lists of shard numbers as text: "0-9,12".

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace scanmill {

inline constexpr std::string_view kManifestName = "manifest.json";
// The descriptions beside the manifest (card.h).
inline constexpr std::string_view kCardName = "dataset_card.md";
inline constexpr std::string_view kCroissantName = "croissant.json";
// The folder that contains a dataset until the dataset is complete (dataset_folder.h); readers ignore it.
inline constexpr std::string_view kHiddenName = ".scanmill";

// Returns true if a split may have this name: the name is not empty and has only lower-case letters, digits, '-' and
// '_'.
bool isSplitName(std::string_view split);

// Returns the name of a split's shard, relative to the dataset's folder. `number`: from 0.
std::string shardName(const std::string& split, std::uint64_t number);
// Returns true if shardName() can return `name`, which is relative to the dataset's folder.
bool isShardName(std::string_view name);
// Returns true if `name` is the temporary name, left by a killed run, of a shard, of a file that describes a shard's
// samples, or of a manifest.
bool isLeftover(std::string_view name);
// Returns the final name of a file that has the temporary name `name` (AtomicFile in base/file.h); nothing if `name` is
// not a temporary name.
std::optional<std::string_view> finalName(std::string_view name);

// Returns the ranges of numbers, which must be sorted, as a text such as "0-9,12".
std::string shardRanges(const std::vector<std::uint64_t>& numbers);

// Returns the numbers in `text`, sorted and without duplicates. Throws InputError if the text is not a list of ranges,
// or if a number is not below `count`.
std::vector<std::uint64_t> parseShardRanges(std::string_view text, std::uint64_t count);

}  // namespace scanmill
