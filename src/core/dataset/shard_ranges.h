#pragma once

// Numbers of shards as people write them, such as "0-9,12".

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace scanmill {

// Returns the text for the numbers, which must be sorted: "0-9,12".
std::string shardRanges(const std::vector<std::uint64_t>& numbers);

// Returns the numbers in `text`, sorted and without duplicates. Throws InputError if the text is not a list of ranges,
// or if a number is not below `count`.
std::vector<std::uint64_t> parseShardRanges(std::string_view text, std::uint64_t count);

}  // namespace scanmill
