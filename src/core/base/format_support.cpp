#include "base/format_support.h"

#include <fmt/format.h>

#include <algorithm>
#include <mutex>
#include <set>

#include "base/error.h"
#include "base/short_text.h"
#include "base/text_scan.h"

namespace scanmill {

FormatSupport::Use FormatSupport::useOf(std::string_view keyword) const {
  const auto hasKeyword = [&](std::string_view names) { return containsWord(names, keyword); };
  if (std::ranges::any_of(keywords.read, hasKeyword)) return Use::Read;
  if (std::ranges::any_of(keywords.unused, hasKeyword)) return Use::Unused;
  return noteOf(keyword).empty() ? Use::Unknown : Use::LeftOut;
}

std::string_view FormatSupport::noteOf(std::string_view keyword) const {
  for (const FormatKeywords::Row& row : keywords.leftOut) {
    if (containsWord(row.names, keyword)) return row.note;
  }
  return {};
}

void LeftOut::add(const std::string& what, std::uint64_t count) {
  if (count > 0) counts_[what] += count;
}

void LeftOut::addKeyword(const FormatSupport& format, std::string_view keyword) {
  const FormatSupport::Use use = format.useOf(keyword);
  if (use == FormatSupport::Use::Unknown) add(fmt::format("unknown '{}'", keyword.substr(0, 40)));
  if (use == FormatSupport::Use::LeftOut) add(std::string(format.noteOf(keyword)));
}

void LeftOut::add(const LeftOut& other) {
  for (const auto& [what, count] : other.counts_) add(what, count);
}

void LeftOut::addRest(std::string_view rest) {
  constexpr std::string_view kPadding(" \t\r\n\0", 5);
  if (rest.find_first_not_of(kPadding) != std::string_view::npos) add("bytes behind the stated contents", rest.size());
}

std::string LeftOut::text() const {
  std::string text;
  for (const auto& [what, count] : counts_) {
    text += fmt::format("{}{} {}", text.empty() ? "" : ", ", grouped(count), what);
  }
  return text;
}

void LeftOut::warn(const std::string& file) const {
  if (empty()) return;
  static std::mutex mutex;
  static std::map<std::string, std::set<std::string>> filesOf;  // by folder and text
  const std::scoped_lock lock(mutex);
  constexpr std::size_t kMostNamed = 3;  // files of a folder named in warnings with the same text
  const std::size_t slash = file.rfind('/');
  std::set<std::string>& files = filesOf[file.substr(0, slash == std::string::npos ? 0 : slash) + "\n" + text()];
  if (files.size() > kMostNamed) return;
  files.insert(file);
  scanmill::warn(files.size() <= kMostNamed
                     ? fmt::format("{}: left out: {}", file, text())
                     : fmt::format("{} and other files, not named one by one: left out in each: {}", file, text()));
}

}  // namespace scanmill
