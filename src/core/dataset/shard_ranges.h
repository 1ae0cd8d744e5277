#pragma once

// Numbers of shards as people write them: "0-9,12".

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace scanmill {

// `numbers` are sorted.
std::string shardRanges(const std::vector<std::uint64_t>& numbers);

// The numbers in `text`, sorted, none twice. Throws InputError for what is no list of ranges, and for numbers that are
// not below `count`.
std::vector<std::uint64_t> parseShardRanges(std::string_view text, std::uint64_t count);

}  // namespace scanmill
