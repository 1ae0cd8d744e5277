#pragma once

// Writes text for people to standard output and standard error. Names that come from files (of members, nodes, columns)
// may contain any bytes: a terminal must not execute them as commands, nor a reader take them for this program's text.

#include <fmt/core.h>

#include <cstddef>
#include <cstdio>
#include <string>
#include <string_view>
#include <utility>

namespace scanmill {

// Characters of texts in UTF-8.

constexpr char32_t kNoCharacter = 0xFFFFFFFF;

struct Utf8Character {
  char32_t code = kNoCharacter;  // kNoCharacter: a byte that does not begin a well-formed character
  std::size_t bytes = 1;
};

// Returns the character that begins at the byte `at`. A well-formed character is one of Unicode 15, table 3-7: no
// overlong form, no surrogate, nothing beyond U+10FFFF. Returns kNoCharacter if the text has no byte `at`.
[[nodiscard]] Utf8Character utf8At(std::string_view text, std::size_t at);

[[nodiscard]] bool isUtf8(std::string_view text);

// True for invisible characters that change how a terminal or a page shows the text: the control characters C0, DEL and
// C1, Unicode's bidirectional controls, its line and paragraph separators, and the byte order mark.
[[nodiscard]] bool isUnseenControl(char32_t c);

// Returns the text with escapes: \x1b for control characters and bytes that are not UTF-8, \u202e for other characters
// for which isUnseenControl() is true. Line feeds and tabs stay; a carriage return becomes \r.
[[nodiscard]] std::string forTerminal(std::string_view text);
// Does the same as forTerminal(), and also writes line feeds and tabs as \n and \t, so that the text stays on one line.
[[nodiscard]] std::string oneLine(std::string_view text);
// Does the same as forTerminal(), and indents the second and later lines, so that no line of the text looks like a
// message of this program.
[[nodiscard]] std::string indented(std::string_view text);

// Writes a text through forTerminal().
void writeTo(std::FILE* stream, std::string_view text);

// Format like fmt::print(), and write the result through forTerminal() to standard output or standard error.
template <class... T>
void printText(fmt::format_string<T...> format, T&&... values) {
  writeTo(stdout, fmt::format(format, std::forward<T>(values)...));
}
template <class... T>
void printError(fmt::format_string<T...> format, T&&... values) {
  writeTo(stderr, fmt::format(format, std::forward<T>(values)...));
}

}  // namespace scanmill
