#include "dataset/shard_name.h"

#include <fmt/core.h>

#include <algorithm>

namespace scanmill {

namespace {

bool isDigits(std::string_view text) {
  return !text.empty() && std::all_of(text.begin(), text.end(), [](char c) { return c >= '0' && c <= '9'; });
}

}  // namespace

bool isSplitName(std::string_view split) {
  return !split.empty() && std::all_of(split.begin(), split.end(), [](char c) {
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
  std::string_view file = name.substr(slash + 1);
  if (!file.starts_with(split) || !file.ends_with(".tar")) return false;
  file.remove_prefix(split.size());
  file.remove_suffix(4);
  return file.starts_with('-') && file.size() >= 7 && isDigits(file.substr(1));
}

bool isLeftover(std::string_view name) {
  constexpr std::string_view kMark = ".partial-";
  const std::size_t mark = name.rfind(kMark);
  if (mark == std::string_view::npos || !isDigits(name.substr(mark + kMark.size()))) return false;
  const std::string_view final = name.substr(0, mark);
  constexpr std::string_view kJson = ".json";
  const bool ofSamples = final.ends_with(kJson) &&  // file names from samplesFileOf()
                         isShardName(std::string(final.substr(0, final.size() - kJson.size())) + ".tar");
  return final == kManifestName || isShardName(final) || ofSamples;
}

}  // namespace scanmill
