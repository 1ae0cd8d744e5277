#pragma once

// The statements of OBJ files and of their material libraries, one after the other: a keyword, and the rest of its
// line.

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace scanmill::obj {

// A line that ends with a backslash goes on in the next line. Lines that begin with # are comments.
class Statements {
 public:
  // `text` must outlive the object.
  Statements(std::string_view text, const std::filesystem::path& file);

  // Goes to the next statement. Returns false at the end of the text.
  bool next();

  std::string_view keyword() const { return keyword_; }
  // The rest of the line, without blanks at both ends. Names may contain #, so a comment behind numbers is part of it.
  std::string_view rest() const { return rest_; }
  // Splits the rest of the line, up to a comment, into words. The result is valid until the next call.
  const std::vector<std::string_view>& words();

  // Converts a word to a number, which may be "nan" or "inf". Throws InputError with the line.
  double number(std::string_view word) const;
  // Throws an InputError that names file, line and keyword.
  [[noreturn]] void fail(const std::string& what) const;

 private:
  std::string_view nextLine();

  std::string_view text_;  // the lines that are not read yet
  std::string file_;
  int lines_ = 0;       // number of lines read so far
  int line_ = 0;        // line of the statement, counted from 1
  std::string joined_;  // the text of a statement of several lines
  std::string_view keyword_, rest_;
  std::vector<std::string_view> words_;
};

}  // namespace scanmill::obj
