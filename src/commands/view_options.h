#pragma once

// Reads the values of options of `scanmill view`.

#include <array>
#include <charconv>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "commands/arguments.h"
#include "viewer/coloring.h"

namespace scanmill {

// Returns the index of a word in `names`. Throws an InputError that names the option if `names` does not contain the
// word.
std::size_t wordAmong(const std::string& word, const std::string& option, std::span<const std::string_view> names);

// Reads the value of --color: one of colorNames(), or the name of a column of a recorded file that the table of columns
// lacks. Throws InputError for a word that is empty or seems to be a misspelt entry of colorNames().
ColorBy readColor(const std::string& word);

// Reads kCount numbers with a separator between them, such as "8,-3.5,-1". Returns nothing for any other text.
template <class T, std::size_t kCount>
std::optional<std::array<T, kCount>> readNumbers(std::string_view text, char separator = ',') {
  std::array<T, kCount> values{};
  const char* at = text.data();
  const char* const end = at + text.size();
  for (std::size_t i = 0; i < kCount; ++i) {
    const auto read = std::from_chars(at, end, values[i]);
    const bool followed = i + 1 < kCount ? read.ptr != end && *read.ptr == separator : read.ptr == end;
    if (read.ec != std::errc() || !followed) return {};
    at = read.ptr + 1;
  }
  return values;
}

// The size of --size WxH (pixels).
struct PictureSize {
  int width = 0;
  int height = 0;
};
PictureSize readPictureSize(const std::string& text);

bool isExr(const std::filesystem::path& file);
// Returns the file that --ontology names, by a path or a name of `scanmill list ontologies`; empty if not given.
std::filesystem::path ontologyOption(const Arguments& parsed);

}  // namespace scanmill
