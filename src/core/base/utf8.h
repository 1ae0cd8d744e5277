#pragma once

// Characters of texts in UTF-8, such as names that come from files.

#include <cstddef>
#include <string_view>

namespace scanmill {

constexpr char32_t kNoCharacter = 0xFFFFFFFF;

struct Utf8Character {
  char32_t code = kNoCharacter;  // kNoCharacter: a byte that does not begin a well-formed character
  std::size_t bytes = 1;
};

// Returns the character that begins at the byte `at`. A well-formed character is one of Unicode 15, table 3-7: no
// overlong form, no surrogate, nothing beyond U+10FFFF. Behind the end of the text there is no character.
[[nodiscard]] Utf8Character utf8At(std::string_view text, std::size_t at);

[[nodiscard]] bool isUtf8(std::string_view text);

// True for characters that nobody sees, but that act on a terminal, a page or the text around them: control characters
// (C0, DEL and C1), Unicode's controls of the writing direction, its separators of lines, and the byte order mark.
[[nodiscard]] bool isUnseenControl(char32_t c);

}  // namespace scanmill
