#pragma once

#include <string>

#include "config/value.h"

namespace scanmill {

// Returns a value as YAML on one line, such as "{resolution: 512}"; a value of the kind Null gives "{}".
std::string flowText(const Value& value);

}  // namespace scanmill
