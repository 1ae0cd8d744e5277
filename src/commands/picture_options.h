#pragma once

// Options that commands which make pictures have in common.

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

// The place of a word among `names`. Throws InputError that names the option.
std::size_t wordAmong(const std::string& word, const std::string& option, std::span<const std::string_view> names);

// Of --color: one of colorNames(), or a column of a recorded file that the table of columns does not have. Throws
// InputError for a word that is nearly one of the names.
ColorBy readColor(const std::string& word);

// Empty where the option is not given.
std::string textOption(const Arguments& parsed, const std::string& option);
std::vector<std::string> listOption(const Arguments& parsed, const std::string& option);
bool hasOption(const Arguments& parsed, const std::string& option);

// Numbers with a separator between them: "8,-3.5,-1". None where the text is anything else.
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

// Of an option that has a value: a number within bounds, both included. Throws InputError.
double numberWithin(const Arguments& parsed, const std::string& option, double least, double most);

// Pixels, of --size WxH.
struct PictureSize {
  int width = 0;
  int height = 0;
};
PictureSize readPictureSize(const std::string& text);

bool isExr(const std::filesystem::path& file);
// Of --ontology: a file, or a name of `scanmill list ontologies`. Empty where it is not given.
std::filesystem::path ontologyOption(const Arguments& parsed);
// The EXR images of a file or of a recording's folder: --sample says which is first, --ontology what classes mean.
ImageList imagesOption(const std::filesystem::path& path, const Arguments& parsed);

}  // namespace scanmill
