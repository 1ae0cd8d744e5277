#pragma once

// Helpers of this room: which text a YAML file may hold, environment variables in it, and text for messages.

#include <cstddef>
#include <string>
#include <string_view>

#include "base/error.h"

namespace scanmill {

// A YAML file that is larger than this is taken for a mistake and refused.
constexpr std::size_t kMaxYamlBytes = std::size_t{64} << 20;

// Throws InputError with file:line:column for NUL bytes, other control characters, invalid UTF-8 and tabs in the
// indentation.
void checkText(std::string_view text, const std::string& file);

// Replaces ${NAME} and ${NAME:-fallback} by environment variables, and $$ by a dollar. Throws InputError at `where` for
// a variable that is not set and has no fallback.
std::string expandVariables(std::string_view text, const Location& where);

// The text in quotes, on one line, and cut to a length that fits into a message.
std::string quotedForMessage(std::string_view text);

}  // namespace scanmill
