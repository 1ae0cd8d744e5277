#pragma once

// An item of YAML that is a name with options, such as a method, an effect or a format.

#include <string>

#include "config/value.h"

namespace scanmill {

struct NamedOptions {
  std::string name;
  Location where;
  Value options;  // a value of the kind Null if only a name is given
};

// Reads "name" or {name: {options}}. `what` describes the item in messages, such as "an effect". Throws InputError.
NamedOptions readNamed(const Value& value, const std::string& what);

}  // namespace scanmill
