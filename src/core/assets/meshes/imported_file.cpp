#include "assets/meshes/imported_file.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <concepts>
#include <cstring>
#include <type_traits>
#include <utility>

#include "assets/meshes/asset_parts.h"
#include "assets/meshes/assimp/parts.h"
#include "assets/meshes/child_process.h"
#include "base/error.h"
#include "base/memory.h"

namespace scanmill {
namespace {

template <class T, class S>
concept MaybeConst = std::same_as<std::remove_const_t<T>, S>;

template <class Visitor>
void visit(Visitor& visitor, MaybeConst<ImportedMap> auto& map) {
  visitor.each(map.name, map.inverted, map.repeats);
}

template <class Visitor>
void visit(Visitor& visitor, MaybeConst<ImportedMaterial> auto& material) {
  visitor.each(material.name, material.stated, material.roughness, material.metallic, material.opacity, material.color,
               material.base, material.opacityMap);
}

template <class Visitor>
void visit(Visitor& visitor, MaybeConst<AssetPart> auto& part) {
  visitor.each(part.node, part.nodeIndex, part.materialIndex, part.positions, part.uvs, part.triangles);
}

template <class Visitor>
void visit(Visitor& visitor, MaybeConst<ImportedFile> auto& file) {
  visitor.each(file.up, file.upDeclared, file.statedUnit, file.origin, file.dropped.outOfRange, file.materials,
               file.parts, file.missing, file.problems, file.leftOut);
}

class Writer {
 public:
  std::string bytes;

  void each(const auto&... values) { (write(values), ...); }

 private:
  void raw(const void* from, std::size_t size) { bytes.append(static_cast<const char*>(from), size); }

  template <class T>
  void write(const T& value) {
    if constexpr (std::is_trivially_copyable_v<T>) {
      raw(&value, sizeof value);
    } else {
      visit(*this, value);
    }
  }
  void write(const std::string& text) {
    write(text.size());
    raw(text.data(), text.size());
  }
  void write(const LeftOut& leftOut) {
    write(leftOut.counts().size());
    for (const auto& [what, count] : leftOut.counts()) each(what, count);
  }
  template <class T>
  void write(const std::vector<T>& list) {
    write(list.size());
    if constexpr (std::is_trivially_copyable_v<T>) {
      raw(list.data(), list.size() * sizeof(T));
    } else {
      for (const T& item : list) write(item);
    }
  }
};

class Reader {
 public:
  explicit Reader(std::string_view bytes) : left_(bytes) {}

  void each(auto&... values) { (read(values), ...); }
  bool atEnd() const { return left_.empty(); }
  [[noreturn]] static void fail() { throw Error("the importer's answer is damaged"); }

 private:
  void raw(void* to, std::size_t size) {
    if (size > left_.size()) fail();
    if (size > 0) std::memcpy(to, left_.data(), size);
    left_.remove_prefix(size);
  }

  // Reads the length of a list, each of whose items takes at least `bytes` bytes. Fails if the input is too short for
  // them.
  std::size_t count(std::size_t bytes) {
    std::size_t items = 0;
    raw(&items, sizeof items);
    if (items > left_.size() / bytes) fail();
    return items;
  }

  template <class T>
  void read(T& value) {
    if constexpr (std::is_trivially_copyable_v<T>) {
      raw(&value, sizeof value);
    } else {
      visit(*this, value);
    }
  }
  void read(std::string& text) {
    text.resize(count(1));
    raw(text.data(), text.size());
  }
  void read(LeftOut& leftOut) {
    for (std::size_t left = count(1); left > 0; --left) {
      std::pair<std::string, std::uint64_t> entry;
      each(entry.first, entry.second);
      leftOut.add(entry.first, entry.second);
    }
  }
  template <class T>
  void read(std::vector<T>& list) {
    if constexpr (std::is_trivially_copyable_v<T>) {
      list.resize(count(sizeof(T)));
      raw(list.data(), list.size() * sizeof(T));
    } else {
      list.resize(count(1));
      for (T& item : list) read(item);
    }
  }

  std::string_view left_;
};

// Memory limit of the child process (bytes) for an empty file. Each byte of the file adds 64 bytes to the limit.
constexpr std::uint64_t kMemory = std::uint64_t{1} << 30;
constexpr unsigned kSeconds = 300;

ImportedFile importByAssimp(const std::filesystem::path& file, const std::string& kind, const AssetOptions& options) {
  const std::uint64_t memory = std::min(kMemory + 64 * std::filesystem::file_size(file), memoryLimitBytes());
  try {
    return importedFrom(inChildProcess([&] { return bytesOf(readByAssimp(file, kind, options)); }, memory, kSeconds));
  } catch (const ChildEnded& e) {
    throw InputError({file.string()}, fmt::format("cannot be read: {}; {}", e.what(), remedyFor(kind)));
  } catch (const Error& e) {
    throw InputError({file.string()}, e.what());
  }
}

}  // namespace

std::string bytesOf(const ImportedFile& file) {
  Writer writer;
  std::size_t large = 1 << 16;
  for (const AssetPart& part : file.parts) {
    large += part.positions.size() * sizeof(Vec3f) + part.uvs.size() * sizeof(Vec2f) +
             part.triangles.size() * sizeof(Triangle);
  }
  writer.bytes.reserve(large);
  visit(writer, file);
  return std::move(writer.bytes);
}

ImportedFile importedFrom(std::string_view bytes) {
  Reader reader(bytes);
  ImportedFile file;
  visit(reader, file);
  if (!reader.atEnd()) Reader::fail();
  return file;
}

Asset readImported(const std::filesystem::path& file, const std::string& kind, const AssetOptions& options) {
  ImportedFile imported = kind == ".ply"   ? readPlyMesh(file, options)
                          : kind == ".obj" ? readObjMesh(file, options)
                          : kind == ".stl" ? readStlMesh(file, options)
                                           : importByAssimp(file, kind, options);
  if (!imported.missing.empty()) {
    warn(
        fmt::format("{}: names '{}', which is missing: its materials have the default "
                    "reflectance",
                    file.string(), fmt::join(imported.missing, "', '")));
  }
  if (!imported.problems.empty()) {
    warn(fmt::format("{}: may be incomplete, since the importer reports: {}", file.string(),
                     fmt::join(imported.problems, "; ")));
  }
  const std::vector<Look> looks = readMaterials(imported, file, options, imported.leftOut);
  for (AssetPart& part : imported.parts) {
    const bool known = part.materialIndex < looks.size();
    if (known) static_cast<Look&>(part) = looks[part.materialIndex];
    checkTexture(part, !known || imported.materials[part.materialIndex].base.repeats, imported.leftOut);
  }
  imported.leftOut.tell(file.string());
  return std::move(static_cast<Asset&>(imported));
}

}  // namespace scanmill
