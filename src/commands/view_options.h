#pragma once

// Reads the values of options of `scanmill view`.

#include <array>
#include <charconv>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "commands/arguments.h"
#include "viewer/coloring.h"
#include "viewer/frames/image_list.h"

namespace scanmill {

// Returns the index of a word in `names`. Throws InputError that names the option.
std::size_t wordAmong(const std::string& word, const std::string& option, std::span<const std::string_view> names);

// Reads the value of --color: one of colorNames(), or the name of a column of a recorded file that the table of columns
// lacks. Throws InputError for a word that is nearly one of the names.
ColorBy readColor(const std::string& word);

// Reads numbers with a separator between them: "8,-3.5,-1". Absent if the text is anything else.
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

// Returns the value of an option, a number within bounds (inclusive). Throws InputError.
double numberWithin(const Arguments& parsed, const std::string& option, double least, double most);

// The size of --size WxH (pixels).
struct PictureSize {
  int width = 0;
  int height = 0;
};
PictureSize readPictureSize(const std::string& text);

bool isExr(const std::filesystem::path& file);
// Returns the value of --ontology: a file, or a name from `scanmill list ontologies`. Empty if the option is not given.
std::filesystem::path ontologyOption(const Arguments& parsed);
// Opens the EXR images of a file or of a recording's folder, with --sample as the first and --ontology for the classes.
ImageList imagesOption(const std::filesystem::path& path, const Arguments& parsed);

}  // namespace scanmill
