#include "dataset/shard_name.h"

#include <fmt/core.h>

#include <algorithm>
#include <charconv>
#include <set>

#include "base/error.h"

namespace scanmill {

namespace {

bool isDigits(std::string_view text) {
  return !text.empty() && std::ranges::all_of(text, [](char c) { return c >= '0' && c <= '9'; });
}

}  // namespace

bool isSplitName(std::string_view split) {
  return !split.empty() && std::ranges::all_of(split, [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '-' || c == '_';
  });
}

std::string shardName(const std::string& split, std::uint64_t number) {
  return fmt::format("{0}/{0}-{1:06}.tar", split, number);
}

bool isShardName(std::string_view name) {
  const std::size_t slash = name.find('/');
  if (slash == std::string_view::npos || !isSplitName(name.substr(0, slash))) return false;
  const std::string_view split = name.substr(0, slash);
  constexpr std::string_view kSuffix = ".tar";
  constexpr std::size_t kLeastDigits = 6;
  std::string_view file = name.substr(slash + 1);  // "train-000000.tar"
  if (!file.starts_with(split) || !file.ends_with(kSuffix)) return false;
  file.remove_prefix(split.size());
  file.remove_suffix(kSuffix.size());
  return file.starts_with('-') && file.size() > kLeastDigits && isDigits(file.substr(1));
}

bool isLeftover(std::string_view name) {
  const std::optional<std::string_view> final = finalName(name);
  if (!final) return false;
  constexpr std::string_view kJson = ".json";
  const bool isSamplesFile = final->ends_with(kJson) &&  // true for names that samplesFileOf() returns
                             isShardName(std::string(final->substr(0, final->size() - kJson.size())) + ".tar");
  return *final == kManifestName || *final == kCardName || *final == kCroissantName || isShardName(*final) ||
         isSamplesFile;
}

std::optional<std::string_view> finalName(std::string_view name) {
  constexpr std::string_view kMark = ".partial-";
  const std::size_t mark = name.rfind(kMark);
  if (mark == std::string_view::npos) return std::nullopt;
  const std::string_view process = name.substr(mark + kMark.size());
  if (!isDigits(process.substr(0, process.find('-')))) return std::nullopt;
  return name.substr(0, mark);
}

std::string shardRanges(const std::vector<std::uint64_t>& numbers) {
  std::string text;
  for (std::size_t first = 0; first < numbers.size();) {
    std::size_t last = first;
    while (last + 1 < numbers.size() && numbers[last + 1] == numbers[last] + 1) ++last;
    if (!text.empty()) text += ',';
    text += first == last ? std::to_string(numbers[first]) : fmt::format("{}-{}", numbers[first], numbers[last]);
    first = last + 1;
  }
  return text;
}

std::vector<std::uint64_t> parseShardRanges(std::string_view text, std::uint64_t count) {
  const auto fail = [&](const std::string& why) {
    throw InputError(fmt::format("'{}': {}; give shards such as 0-9,12", text, why));
  };
  std::set<std::uint64_t> numbers;
  const auto readNumber = [&](std::string_view digits) {
    std::uint64_t value = 0;
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
    if (error != std::errc() || end != digits.data() + digits.size()) fail(fmt::format("'{}' is not a number", digits));
    if (value >= count) {
      fail(count == 1 ? "the plan has only the shard 0" : fmt::format("the plan has the shards 0 to {}", count - 1));
    }
    return value;
  };
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t comma = std::min(text.find(',', begin), text.size());
    const std::string_view range = text.substr(begin, comma - begin);
    const std::size_t dash = range.find('-');
    const std::uint64_t low = readNumber(range.substr(0, dash));
    const std::uint64_t high = dash == std::string_view::npos ? low : readNumber(range.substr(dash + 1));
    if (high < low) fail(fmt::format("{} is greater than {}", low, high));
    for (std::uint64_t number = low; number <= high; ++number) numbers.insert(number);
    begin = comma + 1;
  }
  return {numbers.begin(), numbers.end()};
}

}  // namespace scanmill
