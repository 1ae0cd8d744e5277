#pragma once

// Tables of numbers in text files.

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"
#include "config/fields.h"

namespace scanmill {

struct TextLine {
  Location where;
  std::string_view text;  // part of the file's bytes, without surrounding spaces
};

// Returns the lines of `bytes`, which are the contents of `file`, without empty lines, comment lines that begin with #,
// and a byte order mark. Throws InputError if no line is left. The lines refer to `bytes`.
std::vector<TextLine> linesOf(std::string_view bytes, const std::filesystem::path& file);

// Returns the number that a text spells. Throws InputError if the text is not a finite number.
double numberOf(std::string_view text, const Location& where);

// A table in a text file. The first line names the columns; it may begin with a #. Cells are separated by semicolons;
// if the first line has none, by commas; if it has neither, by blanks. Names are converted to lower-case letters,
// digits and _. A unit in brackets or after a slash is appended, except metres: "Time/s", "time (s)" and "Time [sec]"
// become time_s, "x [m]" becomes x. All methods throw InputError with the line.
class TextTable {
 public:
  explicit TextTable(const std::filesystem::path& file);

  const Location& head() const { return head_; }
  const std::vector<std::string>& names() const { return names_; }
  std::size_t size() const { return rows_.size(); }
  const Location& where(std::size_t row) const { return rows_[row].where; }

  bool has(std::string_view name) const { return find(name).has_value(); }
  // Renames the first column called `oldName`, if there is one.
  void rename(std::string_view oldName, const char* newName);
  // Throws InputError if the table has no column with this name.
  void require(std::string_view name) const;
  // Throws InputError if the table has a column that `columns` does not list.
  void expectOnly(const std::vector<std::string>& columns) const;
  // Returns the number in a column, or 0 if the table has no such column.
  double number(std::size_t row, std::string_view name, Range range = {}) const;
  // Returns the time (s) in a row, from the column time, time_s, time_ms, time_us or time_ns; 0 without such a column.
  double time(std::size_t row, Range range = {}) const;
  // Returns the name of the column of times; empty if there is none.
  std::string_view timeName() const;

 private:
  struct Row {
    Location where;
    std::vector<std::string_view> cells;
  };
  std::optional<std::size_t> find(std::string_view name) const;

  std::string bytes_;
  Location head_;
  std::vector<std::string> names_;
  std::vector<Row> rows_;
};

}  // namespace scanmill
