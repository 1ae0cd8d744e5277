#pragma once

#include <string>
#include <string_view>

#include "config/value.h"

namespace scanmill {

// Returns a value as YAML on one line, such as "{resolution: 512}"; a value of the kind Null gives "{}".
std::string flowText(const Value& value);

// Returns a text as a value in double quotes, on one line, which parseYaml() reads as this text, whatever characters it
// has but NUL. Characters that nobody sees are written as escapes. Throws InputError for a text that is not UTF-8.
std::string quotedValue(std::string_view text);

}  // namespace scanmill
