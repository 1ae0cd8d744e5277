#include "commands/view_options.h"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "base/error.h"
#include "config/fields.h"
#include "config/resources.h"
#include "viewer/picture.h"

namespace scanmill {

ColorBy readColor(const std::string& word) {
  for (const Column& column : kColumns) {
    if (column.name == word) return ColorBy(column);  // a column's name always means this column
  }
  const std::vector<std::string>& names = colorNames();
  const bool known = std::ranges::find(names, word) != names.end();
  const std::string meant = nearest(word, names);
  if (word.empty() || (!known && !meant.empty())) {
    throw InputError(fmt::format("--color is one of {}, or a column of a recorded file, not '{}'{}",
                                 fmt::join(names, ", "), word,
                                 meant.empty() ? "" : fmt::format(" (did you mean '{}'?)", meant)));
  }
  return ColorBy(word);
}

std::size_t wordAmong(const std::string& word, const std::string& option, std::span<const std::string_view> names) {
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (names[i] == word) return i;
  }
  throw InputError(fmt::format("--{} is one of {}, not '{}'", option, fmt::join(names, ", "), word));
}

PictureSize readPictureSize(const std::string& text) {
  const auto sides = readNumbers<int, 2>(text, 'x');
  const auto fits = [](int side) { return side >= kLeastPictureSide && side <= kMostPictureSide; };
  if (sides && std::ranges::all_of(*sides, fits) && (*sides)[0] * (*sides)[1] <= kMostPicturePixels) {
    return {(*sides)[0], (*sides)[1]};
  }
  throw InputError(
      fmt::format("--size is WIDTHxHEIGHT in pixels, {} to {} each and {} million in all, such as 1600x900, "
                  "not '{}'",
                  kLeastPictureSide, kMostPictureSide, kMostPicturePixels / 1000000, text));
}

bool isExr(const std::filesystem::path& file) {
  return file.extension() == ".exr";
}

std::filesystem::path ontologyOption(const Arguments& parsed) {
  const std::string given = parsed.text("ontology");
  return given.empty() ? std::filesystem::path() : namedResource(given, "labels");
}

}  // namespace scanmill
