#pragma once

// Names of a dataset's shards (<split>/<split>-000000.tar), members and samples, and texts that list shard numbers
// ("0-9,12").

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace scanmill {

inline constexpr std::string_view kManifestName = "manifest.json";
// Name of the file that describes the dataset, beside the manifest (card.h).
inline constexpr std::string_view kCardName = "dataset_card.md";
// The folder that contains a dataset until the dataset is complete (dataset_folder.h); readers ignore it.
inline constexpr std::string_view kHiddenName = ".scanmill";

// Returns true if a split may have this name: the name is not empty and has only lower-case letters, digits, '-' and
// '_'.
bool isSplitName(std::string_view split);

// Returns the name of a split's shard, relative to the dataset's folder. `number`: from 0.
std::string shardName(const std::string& split, std::uint64_t number);
// Returns true if shardName() can return `name`, which is relative to the dataset's folder.
bool isShardName(std::string_view name);
// Returns true if `name` is the temporary name of a file that is written for a dataset: a shard, the file beside it,
// the manifest or the card. Killed runs leave files with temporary names behind.
bool isLeftover(std::string_view name);
// Returns the final name of a file that has the temporary name `name` (AtomicFile in base/file.h); nothing if `name` is
// not a temporary name.
std::optional<std::string_view> finalName(std::string_view name);

// Returns a text such as "0-9,12". `numbers` must be sorted and distinct.
std::string shardRanges(const std::vector<std::uint64_t>& numbers);

// Returns the numbers that a text such as "0-9,12" lists, sorted and distinct. Throws InputError if the text is not a
// list of ranges, or if a number is not below `count`.
std::vector<std::uint64_t> parseShardRanges(std::string_view text, std::uint64_t count);

// The parts of a member's name such as "dir/key.top.ray_tracing.pcd". As in WebDataset, the key ends at the first dot
// of the file's name. A part that the name does not have is empty.
struct MemberName {
  std::string key{};
  std::string sensor{};
  std::uint32_t revolution = 0;  // "dir/key.top.1.ray_tracing.pcd" is the second revolution of the sensor `top`
  std::string method{};
  std::string suffix{};  // suffix of the format
};
MemberName partsOfMember(const std::string& member);

// The parts of a key: "street-s1-drive-000004" is frame "000004" of the sequence "street-s1-drive". Both are empty if
// the key does not end in a number.
struct KeyParts {
  std::string sequence;
  std::string frame;

  // Returns a value by which frames of a sequence are sorted: digits as numbers, so that "10" comes after "9".
  std::pair<std::size_t, std::string> order() const { return {frame.size(), frame}; }
};
KeyParts partsOfKey(const std::string& key);

// Returns the index of the key that `query` specifies: the full key, an index from 0 ("12", "#12"), or a part of
// exactly one key. If `query` is empty, returns the index of the middle key. If no key or several match, throws an
// InputError that begins with `where` and lists the indices, the matching keys or the most similar key.
std::size_t findKey(const std::vector<std::string>& keys, const std::string& query, const std::string& where);

}  // namespace scanmill
