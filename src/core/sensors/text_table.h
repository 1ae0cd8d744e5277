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
  std::string_view text;  // part of the file's bytes, without surrounding spaces
};

// Returns the lines of a file's bytes, without empty lines, lines that begin with #, and a byte order mark. Throws
// InputError if no line is left. The lines refer to `bytes`.
std::vector<TextLine> linesOf(const std::string& bytes, const std::filesystem::path& file);

// Splits a line into cells at its semicolons; if it has none, at its commas; if it has neither, at its spaces and tabs,
// any number of which separate two cells. Quotes around a cell are left out.
std::vector<std::string_view> cellsOf(std::string_view text);

// The name of a column in lower case, and the unit that stands in brackets or after a slash behind it: "Time/s",
// "time (s)" and "Time [sec]" are {"time", "s"}, "q_RS_w []" is {"q_rs_w", ""}.
struct ColumnName {
  std::string name;
  std::string unit;  // s, ms, us, ns, m, deg or rad, or as it stands; empty: none is stated
};
ColumnName columnName(std::string_view cell);

// Returns the number that a text spells. Throws InputError if the text is not a finite number.
double numberOf(std::string_view text, const Location& where);

}  // namespace scanmill
