#pragma once

// Tables of numbers in text files.

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"

namespace scanmill {

struct TextLine {
  Location where;
  std::string_view text;  // of `bytes`, without spaces around it
};

// Without those that are empty or begin with #, and without a byte order mark. Throws InputError where there is none.
std::vector<TextLine> linesOf(const std::string& bytes, const std::filesystem::path& file);

// Separated by any number of spaces and tabs, or by single commas or semicolons.
std::vector<std::string_view> cellsOf(std::string_view text);

// Throws InputError for what is no finite number.
double numberOf(std::string_view text, const Location& where);

}  // namespace scanmill
