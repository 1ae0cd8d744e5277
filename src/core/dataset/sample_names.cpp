#include "dataset/sample_names.h"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>

#include "base/error.h"
#include "config/fields.h"

namespace scanmill {

MemberName partsOfMember(const std::string& member) {
  const std::size_t slash = member.rfind('/');
  const std::size_t first = member.find('.', slash == std::string::npos ? 0 : slash);
  if (first == std::string::npos) return {member, {}, 0, {}, {}};
  const std::size_t last = member.rfind('.');
  MemberName parts{member.substr(0, first), {}, 0, {}, member.substr(last + 1)};
  if (last == first) return parts;
  const std::size_t second = member.find('.', first + 1);
  parts.sensor = member.substr(first + 1, second - first - 1);
  if (second == last) return parts;
  parts.method = member.substr(second + 1, last - second - 1);
  const std::size_t third = parts.method.find('.');
  const auto [end, failure] = std::from_chars(
      parts.method.data(), parts.method.data() + std::min(third, parts.method.size()), parts.revolution);
  if (third != std::string::npos && failure == std::errc() && end == parts.method.data() + third) {
    parts.method.erase(0, third + 1);
  } else {
    parts.revolution = 0;
  }
  return parts;
}

KeyParts partsOfKey(const std::string& key) {
  const std::size_t dash = key.rfind('-');
  if (dash == std::string::npos || dash + 1 == key.size()) return {};
  const std::string frame = key.substr(dash + 1);
  if (frame.find_first_not_of("0123456789") != std::string::npos) return {};
  return {key.substr(0, dash), frame};
}

std::size_t findKey(const std::vector<std::string>& keys, const std::string& wanted, const std::string& where) {
  if (keys.empty()) throw InputError({where}, "has no samples");
  if (wanted.empty()) return keys.size() / 2;
  const auto found = std::ranges::find(keys, wanted);
  if (found != keys.end()) return static_cast<std::size_t>(found - keys.begin());
  const std::string digits = wanted.substr(wanted.front() == '#' ? 1 : 0);  // "#12", as in the viewer
  const bool number = !digits.empty() && digits.find_first_not_of("0123456789") == std::string::npos;
  if (number) {
    const std::uint64_t index = digits.size() > 18 ? UINT64_MAX : std::stoull(digits);
    if (index < keys.size()) return index;
  }
  std::vector<std::size_t> holding;
  for (std::size_t i = 0; i < keys.size(); ++i) {
    if (keys[i].find(wanted) != std::string::npos) holding.push_back(i);
  }
  if (holding.size() == 1) return holding.front();
  if (number) {
    throw InputError(
        {where}, fmt::format("has the samples 0 to {}, not {}: give such an index, or a key", keys.size() - 1, wanted));
  }
  if (!holding.empty()) {
    constexpr std::size_t kListed = 6;
    std::vector<std::string> some;
    for (std::size_t i = 0; i < std::min(kListed, holding.size()); ++i) some.push_back(keys[holding[i]]);
    const std::string more =
        holding.size() > kListed ? fmt::format(" and {} more", holding.size() - kListed) : std::string();
    throw InputError({where}, fmt::format("'{}' is part of {} keys: give more of one key: {}{}", wanted, holding.size(),
                                          fmt::join(some, ", "), more));
  }
  const std::string near = nearest(wanted, keys);
  throw InputError({where},
                   fmt::format("has no sample '{}'; it has {} samples, {} to {}{}", wanted, keys.size(), keys.front(),
                               keys.back(), near.empty() ? "" : fmt::format(" (did you mean '{}'?)", near)));
}

}  // namespace scanmill
