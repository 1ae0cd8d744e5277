#include "dataset/names.h"

#include <fmt/core.h>

#include <algorithm>
#include <charconv>
#include <set>

#include "base/error.h"
#include "base/short_text.h"
#include "config/fields.h"

namespace scanmill {

namespace {

bool isWholeNumber(std::string_view text) {
  return !text.empty() && text.find_first_not_of("0123456789") == std::string_view::npos;
}

// Removes the text up to the first dot and the dot, or all text if there is no dot. Returns the text before the dot.
std::string takePart(std::string_view& text) {
  const std::size_t length = std::min(text.find('.'), text.size());
  const std::string part(text.substr(0, length));
  text.remove_prefix(std::min(length + 1, text.size()));
  return part;
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
  return file.starts_with('-') && file.size() > kLeastDigits && isWholeNumber(file.substr(1));
}

bool isLeftover(std::string_view name) {
  const std::optional<std::string_view> final = finalName(name);
  if (!final) return false;
  constexpr std::string_view kJson = ".json";
  const bool isSamplesFile = final->ends_with(kJson) &&  // true for names that samplesFileOf() returns
                             isShardName(std::string(final->substr(0, final->size() - kJson.size())) + ".tar");
  return *final == kManifestName || *final == kCardName || isShardName(*final) || isSamplesFile;
}

std::optional<std::string_view> finalName(std::string_view name) {
  constexpr std::string_view kMark = ".partial-";
  const std::size_t mark = name.rfind(kMark);
  if (mark == std::string_view::npos) return std::nullopt;
  const std::string_view process = name.substr(mark + kMark.size());
  if (!isWholeNumber(process.substr(0, process.find('-')))) return std::nullopt;
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

MemberName partsOfMember(const std::string& member) {
  const std::size_t slash = member.rfind('/');
  const std::size_t keyEnd = member.find('.', slash == std::string::npos ? 0 : slash);
  if (keyEnd == std::string::npos) return {.key = member};
  const std::size_t lastDot = member.rfind('.');
  MemberName parts{.key = member.substr(0, keyEnd), .suffix = member.substr(lastDot + 1)};
  if (lastDot == keyEnd) return parts;
  std::string_view middle = std::string_view(member).substr(keyEnd + 1, lastDot - keyEnd - 1);  // "top.1.ray_tracing"
  parts.sensor = takePart(middle);
  const std::string_view number = middle.substr(0, middle.find('.'));
  const bool isNumber = number.size() < middle.size() && isWholeNumber(number);
  // A number that is too large is left to the method; std::from_chars() then does not set the revolution.
  if (isNumber && std::from_chars(number.begin(), number.end(), parts.revolution).ec == std::errc()) takePart(middle);
  parts.method = middle;
  return parts;
}

KeyParts partsOfKey(const std::string& key) {
  const std::size_t dash = key.rfind('-');
  if (dash == std::string::npos || dash + 1 == key.size()) return {};
  const std::string frame = key.substr(dash + 1);
  if (!isWholeNumber(frame)) return {};
  return {.sequence = key.substr(0, dash), .frame = frame};
}

std::size_t findKey(const std::vector<std::string>& keys, const std::string& query, const std::string& where) {
  if (keys.empty()) throw InputError({where}, "has no samples");
  if (query.empty()) return keys.size() / 2;
  const auto equal = std::ranges::find(keys, query);
  if (equal != keys.end()) return static_cast<std::size_t>(equal - keys.begin());
  const std::string digits = query.substr(query.front() == '#' ? 1 : 0);  // "#12", as in the viewer
  constexpr std::size_t kMostDigits = 18;                                 // fit into 64 bits
  const bool isIndex = isWholeNumber(digits);
  if (isIndex && digits.size() <= kMostDigits && std::stoull(digits) < keys.size()) return std::stoull(digits);
  std::vector<std::size_t> matches;  // indices of the keys that contain the query
  for (std::size_t i = 0; i < keys.size(); ++i) {
    if (keys[i].find(query) != std::string::npos) matches.push_back(i);
  }
  if (matches.size() == 1) return matches.front();
  if (isIndex) {
    throw InputError({where}, "has the samples 0 to {}, not {}: give such an index, or a key", keys.size() - 1, query);
  }
  if (!matches.empty()) {
    constexpr std::size_t kMostListed = 6;
    std::vector<std::string> matchingKeys;
    for (const std::size_t i : matches) matchingKeys.push_back(keys[i]);
    throw InputError({where}, "'{}' is part of {} keys: give more of one key: {}", query, matches.size(),
                     shortList(matchingKeys, kMostListed));
  }
  const std::string similarKey = nearest(query, keys);
  throw InputError({where}, "has no sample '{}'; it has {} samples, {} to {}{}", query, keys.size(), keys.front(),
                   keys.back(), similarKey.empty() ? "" : fmt::format(" (did you mean '{}'?)", similarKey));
}

}  // namespace scanmill
