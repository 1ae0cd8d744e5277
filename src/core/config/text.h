#pragma once

// Helpers of this layer: what a YAML file may hold as text, environment variables in it, and words for messages.

#include <cstddef>
#include <string>
#include <string_view>

#include "base/error.h"

namespace scanmill {

// A YAML file larger than this is a mistake.
constexpr std::size_t kMaxYamlBytes = std::size_t{64} << 20;

// Throws InputError with file:line:column for NUL bytes, other control characters, invalid UTF-8 and tabs in the
// indentation.
void checkText(std::string_view text, const std::string& file);

// Replaces ${NAME} and ${NAME:-fallback} by environment variables and $$ by a dollar.
std::string expandVariables(std::string_view text, const Location& where);

// 'text' on one line and cut to a length that a message bears.
std::string quotedForMessage(std::string_view text);

}  // namespace scanmill
