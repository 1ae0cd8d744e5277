#include "assets/meshes/stated_unit.h"

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <utility>

#include "base/error.h"
#include "config/text.h"

namespace scanmill {

void warnOfStatedUnit(std::string_view head, const AssetOptions& options, const std::filesystem::path& file) {
  static constexpr std::pair<std::string_view, const char*> kUnits[] = {
      {"mm millimeter millimeters millimetre millimetres", "0.001"},
      {"cm centimeter centimeters centimetre centimetres", "0.01"},
      {"in inch inches", "0.0254"},
      {"ft foot feet", "0.3048"},
      {"km kilometer kilometers kilometre kilometres", "1000"}};
  if (options.unitStated) return;
  const std::string text = lowerCase(head.substr(0, 2048));
  for (std::size_t at = 0; (at = text.find("unit", at)) != std::string::npos;) {
    at += 4;
    if (text.compare(at, 1, "s") == 0) ++at;
    const std::size_t sign = std::min(text.find_first_not_of(" \t", at), text.size());
    if (text.find_first_of(":=", sign) != sign) continue;
    const std::size_t from = std::min(text.find_first_not_of(" \t", sign + 1), text.size());
    const std::string word = text.substr(from, text.find_first_not_of("abcdefghijklmnopqrstuvwxyz", from) - from);
    const std::size_t behind = std::min(text.find_first_not_of(" \t", from + word.size()), text.size());
    if (word == "in" && behind < text.size() && text[behind] >= 'a' && text[behind] <= 'z') continue;  // "in metres"
    for (const auto& [names, metres] : kUnits) {
      if (word.empty() || fmt::format(" {} ", names).find(" " + word + " ") == std::string::npos) continue;
      warn(fmt::format(
          "{}: its comment says that units are {}: `unit: {}` reads it so, `unit: 1` says that they are metres",
          file.string(), word, metres));
      return;
    }
  }
}

}  // namespace scanmill
