#pragma once

#include <string>

#include "config/value.h"

namespace scanmill {

// A value as YAML on one line, "{resolution: 512}"; a value of the kind Null gives "{}".
std::string flowText(const Value& value);

}  // namespace scanmill
