#include "config/file_kind.h"

#include <algorithm>
#include <fstream>
#include <iterator>

#include "config/text.h"

namespace scanmill {

namespace {

const char* advice(FileKind kind) {
  switch (kind) {
    case FileKind::Pipeline:
      return "this is a pipeline: give it to `scanmill generate` or `scanmill plan`";
    case FileKind::Scene:
      return "this is a scene: name it under `scenes:` of a pipeline";
    case FileKind::Sensor:
      return "this is a sensor: name it as `preset:` under `sensors:` of a pipeline";
    case FileKind::Ontology:
      return "this is an ontology: name it as `ontology:` of a scene, or as `labels:` of a pipeline";
    case FileKind::Materials:
      return "this is a material table: name it as `materials:` of a scene";
    case FileKind::Unknown:
      break;
  }
  return "";
}

}  // namespace

FileKind fileKind(const Value& root) {
  if (root.find("scenes") != nullptr || root.find("sensors") != nullptr) return FileKind::Pipeline;
  if (root.find("objects") != nullptr) return FileKind::Scene;
  for (const char* key : {"elevation_deg", "calibration", "rosette", "raster", "beams", "pattern"}) {
    if (root.find(key) != nullptr) return FileKind::Sensor;
  }
  if (root.find("classes") != nullptr) return FileKind::Ontology;
  const Value* materials = root.find("materials");
  if (materials != nullptr && materials->kind == Value::Kind::Sequence) return FileKind::Materials;
  return FileKind::Unknown;
}

void expectKind(const Value& root, FileKind expected) {
  const FileKind kind = fileKind(root);
  if (kind != FileKind::Unknown && kind != expected) throw InputError({root.where.file}, advice(kind));
}

bool isMap(const std::filesystem::path& file) {
  constexpr const char* kEndings[] = {".osm", ".osh", ".pbf", ".o5m", ".opl"};
  const std::string name = lowerCase(file.filename().string());
  return std::any_of(std::begin(kEndings), std::end(kEndings),
                     [&](const char* ending) { return name.find(ending) != std::string::npos; });
}

std::string firstBytes(const std::filesystem::path& file, std::size_t count) {
  std::string bytes(count, '\0');
  std::ifstream stream(file, std::ios::binary);
  stream.read(bytes.data(), std::ssize(bytes));
  bytes.resize(static_cast<std::size_t>(stream.gcount()));
  return bytes;
}

}  // namespace scanmill
