#include "viewer/frames/image_list.h"

#include <fmt/core.h>

#include <algorithm>
#include <charconv>
#include <cstring>

#include "base/error.h"

namespace scanmill {

namespace fs = std::filesystem;

namespace {

std::size_t findImage(const ImageList& list, const std::string& wanted) {
  if (wanted.empty()) return 0;
  const auto holds = [&](const std::string& name) { return name.find(wanted) != std::string::npos; };
  if (const auto named = std::ranges::find(list.names, wanted); named != list.names.end()) {
    return static_cast<std::size_t>(named - list.names.begin());
  }
  std::size_t index = 0;
  const char* const end = wanted.data() + wanted.size();
  const auto read = std::from_chars(wanted.data(), end, index);
  if (read.ec == std::errc() && read.ptr == end && index < list.names.size()) return index;
  const auto found = std::ranges::find_if(list.names, holds);
  if (found != list.names.end()) return static_cast<std::size_t>(found - list.names.begin());
  throw InputError(fmt::format("{}: has {} images, and the name of none holds '{}'; the first is '{}', the last '{}'",
                               list.title, list.names.size(), wanted, list.names.front(), list.names.back()));
}

}  // namespace

std::vector<std::string> ImageList::materials(std::size_t file) const {
  std::vector<std::string> known;
  if (!recording) return known;
  // Each scene and seed has a table of materials. If a file's name starts with the names of two scenes ("town" and
  // "town-s1-old"), the longer name is right.
  const RecordedSequence* best = nullptr;
  std::size_t longest = 0;
  for (const RecordedSequence& s : recording->sequences) {
    const std::string start = fmt::format("{}-s{}-", s.scene, s.seed);
    if (!names[file].starts_with(start) || start.size() <= longest) continue;
    best = &s;
    longest = start.size();
  }
  if (best == nullptr || best->materials >= recording->materials.size()) return known;
  for (const Material& m : recording->materials[best->materials]) known.push_back(m.name);
  return known;
}

ImageList openImages(const fs::path& path, const std::string& wanted, std::optional<Ontology> ontology) {
  const bool folder = fs::is_directory(path);
  const fs::path holds = folder ? path : path.has_parent_path() ? path.parent_path() : fs::path(".");
  ImageList list;
  const fs::path normal = path.lexically_normal();
  list.title = (normal.has_filename() ? normal : normal.parent_path()).filename().string();
  if (const auto kind = recordingIn(holds)) list.recording = readRecording(holds, *kind);
  list.ontology = std::move(ontology);
  if (!list.ontology && list.recording && !list.recording->ontology.classes.empty()) {
    list.ontology = list.recording->ontology;
  }
  if (!folder) {
    list.files = {path};
    list.names = {path.stem().string()};
    return list;
  }
  for (const fs::directory_entry& entry : fs::directory_iterator(path)) {
    if (entry.path().extension() == ".exr") list.files.push_back(entry.path());
  }
  if (list.files.empty()) throw InputError({path.string()}, "holds no EXR image: is the recording whole?");
  // Sort by name such that "a.9.exr" comes before "a.10.exr".
  std::ranges::sort(list.files, [](const fs::path& a, const fs::path& b) {
    return ::strverscmp(a.stem().c_str(), b.stem().c_str()) < 0;
  });
  for (const fs::path& file : list.files) list.names.push_back(file.stem().string());
  list.first = findImage(list, wanted);
  return list;
}

}  // namespace scanmill
