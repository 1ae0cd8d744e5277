#pragma once

// Checks the text of YAML files, expands environment variables in it, and prepares text for messages and comparisons.

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>

#include "base/error.h"

namespace scanmill {

// The largest size of a YAML file (bytes). A larger file is refused, since it is probably a mistake.
constexpr std::size_t kMaxYamlBytes = std::size_t{64} << 20;

// Throws InputError with file:line:column for NUL bytes, other control characters, invalid UTF-8 and tabs in the
// indentation.
void checkText(std::string_view text, const std::string& file);

// Replaces ${NAME} and ${NAME:-fallback} by environment variables, and $$ by a dollar. Throws InputError at `where` for
// a variable that is not set and has no fallback, and for ${...} in any other form.
std::string expandVariables(std::string_view text, const Location& where);

// Returns the text in quotes, on one line, and cut to a length that fits into a message.
std::string quotedForMessage(std::string_view text);

// Returns advice on how to write a text as a number; empty if the text is a valid number or has no digit.
std::string numberAdvice(std::string_view text);

// Returns the text with the letters A to Z in lower case.
[[nodiscard]] std::string lowerCase(std::string_view text);

// Returns the extension of a file's name, such as ".jpg", in lower case.
std::string lowerExtension(const std::filesystem::path& file);

}  // namespace scanmill
