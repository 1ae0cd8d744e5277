#include "assets/meshes/imported_file.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstring>
#include <optional>
#include <type_traits>
#include <utility>

#include "assets/meshes/asset_parts.h"
#include "assets/meshes/assimp/parts.h"
#include "assets/meshes/child_process.h"
#include "base/error.h"
#include "base/memory.h"

namespace scanmill {
namespace {

// Serializes values: writes them to bytes, or reads them from bytes that a process of the same build has written.
class Archive {
 public:
  // An archive that writes.
  Archive() = default;
  // An archive that reads these bytes.
  explicit Archive(std::string_view bytes) : unread_(bytes) {}

  std::string written;

  // Writes the file or, if the archive reads, fills it. Throws Error if the bytes do not hold exactly one file.
  void item(ImportedFile& file) {
    items(file.up, file.upDeclared, file.statedUnit, file.origin, file.dropped.outOfRange, file.materials, file.parts,
          file.missing, file.problems, file.leftOut);
    if (unread_ && !unread_->empty()) fail();
  }

 private:
  [[noreturn]] static void fail() { throw Error("the importer's answer is damaged"); }

  void items(auto&... values) { (item(values), ...); }

  void item(AssetPart& part) {
    items(part.node, part.nodeIndex, part.materialIndex, part.positions, part.uvs, part.triangles);
  }
  void item(ImportedMaterial& m) {
    items(m.name, m.stated, m.roughness, m.metallic, m.opacity, m.color, m.base, m.opacityMap);
  }
  void item(ImportedMap& map) { items(map.name, map.inverted, map.repeats); }
  void item(std::pair<std::string, std::uint64_t>& count) { items(count.first, count.second); }
  void item(LeftOut& leftOut) {
    std::vector<std::pair<std::string, std::uint64_t>> counts(leftOut.counts().begin(), leftOut.counts().end());
    item(counts);
    leftOut = {};
    for (const auto& [what, count] : counts) leftOut.add(what, count);
  }
  void item(std::string& text) {
    size(text);
    raw(text.data(), text.size());
  }
  template <class T>
  void item(std::vector<T>& list) {
    size(list);
    if constexpr (std::is_trivially_copyable_v<T>) {
      raw(list.data(), list.size() * sizeof(T));
    } else {
      for (T& each : list) item(each);
    }
  }
  template <class T>
  requires std::is_trivially_copyable_v<T>
  void item(T& value) { raw(&value, sizeof value); }

  // Writes the size of a list, or reads it and resizes the list. Each item must take at least one byte.
  void size(auto& list) {
    std::size_t count = list.size();
    item(count);
    if (unread_ && count > unread_->size()) fail();
    list.resize(count);
  }

  void raw(void* value, std::size_t bytes) {
    if (!unread_) {
      written.append(static_cast<const char*>(value), bytes);
      return;
    }
    if (bytes > unread_->size()) fail();
    if (bytes > 0) std::memcpy(value, unread_->data(), bytes);
    unread_->remove_prefix(bytes);
  }

  std::optional<std::string_view> unread_;  // the bytes that are not read yet; nullopt: this archive writes
};

// Limits of the child process, chosen far above the needs of real files: memory for an empty file (bytes), further
// memory for each byte of a file, and CPU time (s).
constexpr std::uint64_t kLeastMemory = std::uint64_t{1} << 30;
constexpr std::uint64_t kMemoryPerByte = 64;
constexpr unsigned kMostSeconds = 300;

// Reads a file as readByAssimp() does, in a child process. Throws InputError that names the file.
ImportedFile importByAssimp(const std::filesystem::path& file, const std::string& kind, const AssetOptions& options) {
  const std::uint64_t fileSize = std::filesystem::file_size(file);
  const std::uint64_t memory = std::min(kLeastMemory + kMemoryPerByte * fileSize, memoryLimitBytes());
  try {
    const auto readInChild = [&] {
      ImportedFile imported = readByAssimp(file, kind, options);
      Archive archive;
      archive.item(imported);
      return std::move(archive.written);
    };
    const std::string bytes = inChildProcess(readInChild, memory, kMostSeconds);
    ImportedFile imported;
    Archive(bytes).item(imported);
    return imported;
  } catch (const ChildEnded& e) {
    throw InputError({file.string()}, "cannot be read: {}; {}", e.what(), remedyFor(kind));
  } catch (const Error& e) {
    throw InputError({file.string()}, e.what());
  }
}

}  // namespace

Asset readImported(const std::filesystem::path& file, const std::string& kind, const AssetOptions& options) {
  ImportedFile imported = kind == ".ply"   ? readPlyMesh(file, options)
                          : kind == ".obj" ? readObjMesh(file, options)
                          : kind == ".stl" ? readStlMesh(file, options)
                                           : importByAssimp(file, kind, options);
  if (!imported.missing.empty()) {
    warn("{}: names '{}', which is missing: its materials have the default reflectance", file.string(),
         fmt::join(imported.missing, "', '"));
  }
  if (!imported.problems.empty()) {
    warn("{}: may be incomplete, since the importer reports: {}", file.string(), fmt::join(imported.problems, "; "));
  }
  const std::vector<Look> looks = readMaterials(imported, file, options);
  for (AssetPart& part : imported.parts) {
    const bool hasMaterial = part.materialIndex < looks.size();
    if (hasMaterial) static_cast<Look&>(part) = looks[part.materialIndex];
    checkTexture(part, !hasMaterial || imported.materials[part.materialIndex].base.repeats, imported.leftOut);
  }
  imported.leftOut.warn(file.string());
  return std::move(static_cast<Asset&>(imported));
}

}  // namespace scanmill
