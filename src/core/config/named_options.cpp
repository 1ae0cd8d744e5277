#include "config/named_options.h"

#include <fmt/core.h>

namespace scanmill {

NamedOptions readNamed(const Value& value, const std::string& what) {
  NamedOptions named{"", value.where, {}};
  named.options.where = value.where;
  if (value.kind == Value::Kind::Map && value.entries.size() == 1) {
    named.name = value.entries.front().key;
    named.options = value.entries.front().value;
    return named;
  }
  if (value.kind != Value::Kind::Scalar) {
    throw InputError(value.where, fmt::format("{} must be a name or one pair `name: {{options}}`", what));
  }
  named.name = readText(value, what);
  return named;
}

}  // namespace scanmill
