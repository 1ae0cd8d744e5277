#include "assets/references.h"

#include <fmt/format.h>

namespace scanmill {

bool leadsOutside(const std::string& name) {
  const std::filesystem::path path = std::filesystem::path(name).lexically_normal();
  return path.is_absolute() || (!path.empty() && *path.begin() == "..");
}

std::string refusalOf(const std::string& name) {
  return fmt::format(
      "names '{}', which lies outside its folder: move that file into the folder, or allow it by `allow_outside: true` "
      "of the object (--allow-outside of `info` and `draft`)",
      name);
}

}  // namespace scanmill
