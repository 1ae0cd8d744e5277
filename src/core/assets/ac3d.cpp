#include "assets/ac3d.h"

#include <algorithm>
#include <string_view>

#include "base/file.h"

namespace scanmill {
namespace {

// The parts of a line such as `texture "tree.png" base`: the texture's name with its quotes, and its role.
struct Layer {
  std::string_view name, role;
};

Layer layerOf(std::string_view line) {
  constexpr std::string_view kBlank = " \t\r";
  line.remove_prefix(std::string_view("texture").size());
  line.remove_prefix(std::min(line.find_first_not_of(kBlank), line.size()));
  const bool quoted = line.starts_with('"');
  std::size_t end = quoted ? line.find('"', 1) : line.find_first_of(kBlank);
  if (quoted && end != std::string_view::npos) ++end;
  if (end == std::string_view::npos) end = line.size();
  std::string_view role = line.substr(end);
  role.remove_prefix(std::min(role.find_first_not_of(kBlank), role.size()));
  role = role.substr(0, role.find_first_of(kBlank));
  return {line.substr(0, end), role};
}

}  // namespace

std::string readAc3d(const std::filesystem::path& file) {
  const std::string text = readFile(file);
  std::string out;
  out.reserve(text.size());
  std::string texture;  // texture of the current object; written after the object's last texture line
  bool base = false;
  const auto flush = [&] {
    if (!texture.empty()) out += "texture " + texture + "\n";
    texture.clear();
    base = false;
  };
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    const std::string_view line = std::string_view(text).substr(at, end - at);
    at = end + 1;
    if (!line.starts_with("texture ")) {
      flush();
      out += line;
      out += '\n';
      continue;
    }
    const Layer layer = layerOf(line);
    if (!layer.name.starts_with('"') || base) continue;  // skips empty textures, and textures after the base
    base = layer.role == "base";
    if (texture.empty() || base) texture = layer.name;
  }
  flush();
  return out;
}

}  // namespace scanmill
