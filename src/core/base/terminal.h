#pragma once

// Text for people, on standard output and standard error. What comes from files (names of members, nodes, columns) may
// hold anything; a terminal must not take it for commands, nor a reader for lines of this program.

#include <fmt/core.h>

#include <string>
#include <string_view>
#include <utility>

namespace scanmill {

// With control characters written as \x1b, but for line breaks and tabs; also those of Unicode that turn the direction
// of writing, as \u202e.
std::string forTerminal(std::string_view text);
// The same with line breaks and tabs written as \n, \r and \t: a name, a cell, a line of a list.
std::string oneLine(std::string_view text);
// The same as forTerminal(), with further lines indented, so that none of them begins as a line of this program does.
std::string indented(std::string_view text);

void writeText(std::string_view text);
void writeError(std::string_view text);

// fmt::print, with all that is printed made fit by forTerminal().
template <class... T>
void printText(fmt::format_string<T...> format, T&&... values) {
  writeText(fmt::format(format, std::forward<T>(values)...));
}
template <class... T>
void printError(fmt::format_string<T...> format, T&&... values) {
  writeError(fmt::format(format, std::forward<T>(values)...));
}

}  // namespace scanmill
