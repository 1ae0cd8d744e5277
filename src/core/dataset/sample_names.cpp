#include "dataset/sample_names.h"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <span>
#include <string_view>

#include "base/error.h"
#include "config/fields.h"

namespace scanmill {

namespace {

bool isWholeNumber(std::string_view text) {
  return !text.empty() && text.find_first_not_of("0123456789") == std::string_view::npos;
}

// Returns the text up to the first dot, and removes it and the dot from `text`; without a dot returns all of the text.
std::string takePart(std::string_view& text) {
  const std::size_t length = std::min(text.find('.'), text.size());
  const std::string part(text.substr(0, length));
  text.remove_prefix(std::min(length + 1, text.size()));
  return part;
}

}  // namespace

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
  if (number.size() < middle.size() && isWholeNumber(number)) {
    std::uint32_t revolution = 0;
    if (std::from_chars(number.data(), number.data() + number.size(), revolution).ec == std::errc()) {
      parts.revolution = revolution;
      takePart(middle);
    }
  }
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
    throw InputError(
        {where}, fmt::format("has the samples 0 to {}, not {}: give such an index, or a key", keys.size() - 1, query));
  }
  if (!matches.empty()) {
    constexpr std::size_t kMostListed = 6;
    std::vector<std::string> listed;
    for (const std::size_t i : std::span(matches).first(std::min(kMostListed, matches.size()))) {
      listed.push_back(keys[i]);
    }
    const std::size_t unlisted = matches.size() - listed.size();
    throw InputError({where}, fmt::format("'{}' is part of {} keys: give more of one key: {}{}", query, matches.size(),
                                          fmt::join(listed, ", "),
                                          unlisted > 0 ? fmt::format(" and {} more", unlisted) : std::string()));
  }
  const std::string similarKey = nearest(query, keys);
  throw InputError(
      {where}, fmt::format("has no sample '{}'; it has {} samples, {} to {}{}", query, keys.size(), keys.front(),
                           keys.back(), similarKey.empty() ? "" : fmt::format(" (did you mean '{}'?)", similarKey)));
}

}  // namespace scanmill
