#pragma once

// Text for people, on standard output and standard error. Names that come from files (of members, nodes, columns) may
// contain any bytes: a terminal must not execute them as commands, and a reader must not take them for lines of this
// program.

#include <fmt/core.h>

#include <string>
#include <string_view>
#include <utility>

namespace scanmill {

// Returns the text with escapes in place of control characters and bytes that are not UTF-8 (\x1b), and of the other
// characters of isUnseenControl(), such as \u202e. Line feeds and tabs stay; a carriage return becomes \r.
[[nodiscard]] std::string forTerminal(std::string_view text);
// Does the same as forTerminal(), and also writes line feeds and tabs as \n and \t, so that the text stays on one line.
[[nodiscard]] std::string oneLine(std::string_view text);
// Does the same as forTerminal(), and indents the second and later lines, so that no line of the text looks like a
// message of this program.
[[nodiscard]] std::string indented(std::string_view text);

void writeText(std::string_view text);
void writeError(std::string_view text);

// Formats like fmt::print() and writes the result through forTerminal().
template <class... T>
void printText(fmt::format_string<T...> format, T&&... values) {
  writeText(fmt::format(format, std::forward<T>(values)...));
}
template <class... T>
void printError(fmt::format_string<T...> format, T&&... values) {
  writeError(fmt::format(format, std::forward<T>(values)...));
}

}  // namespace scanmill
