#include "assets/worlds/ogre_material.h"

#include <algorithm>
#include <cstdlib>
#include <sstream>
#include <vector>

#include "base/file.h"

namespace scanmill {
namespace {

// Returns the text without its comments.
std::string withoutComments(const std::string& text) {
  std::string plain;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text.compare(i, 2, "//") == 0) i = std::min(text.find('\n', i), text.size());
    if (text.compare(std::min(i, text.size()), 2, "/*") == 0) i = std::min(text.find("*/", i), text.size() - 2) + 2;
    if (i < text.size()) plain += text[i];
  }
  return plain;
}

float fractionOf(const std::string& word) {
  return std::clamp(std::strtof(word.c_str(), nullptr), 0.0f, 1.0f);
}

void readScript(const std::filesystem::path& file, std::map<std::string, OgreMaterial>& materials) {
  std::istringstream lines(withoutComments(readFile(file)));
  OgreMaterial* current = nullptr;
  int depth = 0;
  for (std::string line; std::getline(lines, line);) {
    std::istringstream stream(line);
    std::vector<std::string> words;
    for (std::string word; stream >> word;) words.push_back(word);
    if (words.empty()) continue;
    if (depth == 0 && words[0] == "material" && words.size() > 1) current = &materials[words[1]];
    depth += static_cast<int>(std::count(line.begin(), line.end(), '{') - std::count(line.begin(), line.end(), '}'));
    if (depth <= 0 && words.back() == "}") current = nullptr;
    if (current == nullptr) continue;
    if (words[0] == "texture" && words.size() > 1 && current->texture.empty()) current->texture = words[1];
    if (words[0] == "diffuse" && words.size() > 3 && !current->color) {
      current->color = {fractionOf(words[1]), fractionOf(words[2]), fractionOf(words[3])};
    }
    if (words[0] == "alpha_rejection" && words.size() > 2 && words[1].starts_with("greater")) {
      current->alphaCutoff = std::clamp(std::strtof(words[2].c_str(), nullptr) / 255, 0.0f, 1.0f);
    }
  }
}

}  // namespace

std::map<std::string, OgreMaterial> readOgreMaterials(const std::filesystem::path& place) {
  std::map<std::string, OgreMaterial> materials;
  std::error_code error;
  if (std::filesystem::is_regular_file(place, error)) {
    readScript(place, materials);
    return materials;
  }
  std::vector<std::filesystem::path> scripts;
  for (const auto& entry : std::filesystem::directory_iterator(place, error)) {
    if (entry.path().extension() == ".material" && entry.is_regular_file(error)) scripts.push_back(entry.path());
  }
  std::sort(scripts.begin(), scripts.end());
  for (const std::filesystem::path& script : scripts) readScript(script, materials);
  return materials;
}

}  // namespace scanmill
