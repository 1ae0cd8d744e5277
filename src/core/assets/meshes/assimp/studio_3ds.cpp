#include "assets/meshes/assimp/studio_3ds.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <set>
#include <string_view>
#include <utility>
#include <vector>

#include "base/file.h"

namespace scanmill {

namespace {

// Returns the length of a .3ds chunk with its header of 6 bytes, whose type `id` receives; 0 if there is no chunk at
// `at` that ends before `end`.
std::size_t chunkOf3ds(const std::string& bytes, std::size_t at, std::size_t end, std::uint16_t& id) {
  std::uint32_t length = 0;
  if (at > end || end - at < 6) return 0;
  std::memcpy(&id, bytes.data() + at, sizeof id);
  std::memcpy(&length, bytes.data() + at + sizeof id, sizeof length);
  return length < 6 || length > end - at ? 0 : length;
}

std::string chunk3ds(std::uint16_t id, std::string_view data) {
  const auto length = static_cast<std::uint32_t>(6 + data.size());
  std::string chunk(6, '\0');
  std::memcpy(chunk.data(), &id, sizeof id);
  std::memcpy(chunk.data() + sizeof id, &length, sizeof length);
  return chunk.append(data);
}

}  // namespace

std::string read3ds(const std::filesystem::path& file, LeftOut& leftOut) {
  constexpr std::uint16_t kMain = 0x4D4D, kEditor = 0x3D3D, kMasterScale = 0x0100;
  constexpr std::uint16_t kObject = 0x4000, kHidden = 0x4010, kMesh = 0x4100, kMatrix = 0x4160;
  constexpr std::uint16_t kKeyframer = 0xB000, kNode = 0xB002, kHeader = 0xB010;
  constexpr std::uint16_t kUnknown = 0x4F4F;  // a type that no reader knows
  std::string bytes = readFile(file);
  std::uint16_t id = 0;
  std::vector<std::pair<std::string, std::size_t>> meshes;  // names of objects, and where their chunks kMesh are
  std::set<std::string> placed;                             // names of the keyframer's nodes
  const std::size_t total = chunkOf3ds(bytes, 0, bytes.size(), id);
  for (std::size_t at = 0, length = 0; (length = chunkOf3ds(bytes, at, bytes.size(), id)) > 0; at += length) {
    // Goes on with the first chunk inside.
    if (id == kMain || id == kEditor || id == kKeyframer || id == kNode) length = 6;
    if (id == kHeader) placed.insert(bytes.c_str() + at + 6);
    if (float scale = 1; id == kMasterScale && length == 6 + sizeof scale) {
      std::memcpy(&scale, bytes.data() + at + 6, sizeof scale);
      if (scale != 1 && scale != 0) {
        leftOut.add(fmt::format("master scales of {} (lengths are divided by it: check the size)", scale));
      }
    }
    if (id != kObject) continue;
    bool hidden = false;
    std::size_t mesh = 0;
    const std::size_t end = at + length;
    std::size_t inside = bytes.find('\0', at + 6);  // behind the object's name
    for (std::size_t part = 0; inside < end && (part = chunkOf3ds(bytes, inside + 1, end, id)) > 0; inside += part) {
      hidden = hidden || id == kHidden;
      if (id == kMesh) mesh = inside + 1;
    }
    if (!hidden && mesh > 0) meshes.emplace_back(bytes.c_str() + at + 6, mesh);
    if (!hidden || mesh == 0) continue;
    leftOut.add("hidden nodes");
    std::memcpy(bytes.data() + mesh, &kUnknown, sizeof kUnknown);
  }
  std::string nodes;
  std::set<std::string> added;
  for (const auto& [name, mesh] : meshes) {
    if (placed.contains(name)) continue;
    if (added.insert(name).second) {
      constexpr std::string_view kFlagsAndNoParent("\0\0\0\0\0\xFF\xFF", 7);  // behind the end of the name
      nodes += chunk3ds(kNode, chunk3ds(kHeader, name + std::string(kFlagsAndNoParent)));
    }
    // Vertices are in the file's frame: without the object's matrix the importer leaves them there.
    const std::size_t end = mesh + chunkOf3ds(bytes, mesh, bytes.size(), id);
    for (std::size_t at = mesh + 6, length = 0; (length = chunkOf3ds(bytes, at, end, id)) > 0; at += length) {
      if (id == kMatrix) std::memcpy(bytes.data() + at, &kUnknown, sizeof kUnknown);
    }
  }
  if (nodes.empty()) return bytes;
  bytes.insert(total, chunk3ds(kKeyframer, nodes));
  const auto longer = static_cast<std::uint32_t>(total + 6 + nodes.size());
  std::memcpy(bytes.data() + sizeof id, &longer, sizeof longer);
  return bytes;
}

}  // namespace scanmill
