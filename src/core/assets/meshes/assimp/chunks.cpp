#include "assets/meshes/assimp/chunks.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <cstring>

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

}  // namespace

std::string read3ds(const std::filesystem::path& file, LeftOut& leftOut) {
  constexpr std::uint16_t kMain = 0x4D4D, kEditor = 0x3D3D, kMasterScale = 0x0100;
  constexpr std::uint16_t kObject = 0x4000, kHidden = 0x4010, kMesh = 0x4100;
  constexpr std::uint16_t kUnknown = 0x4F4F;  // a type that no reader knows
  std::string bytes = readFile(file);
  std::uint16_t id = 0;
  for (std::size_t at = 0, length = 0; (length = chunkOf3ds(bytes, at, bytes.size(), id)) > 0; at += length) {
    if (id == kMain || id == kEditor) length = 6;  // goes on with the first chunk inside
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
    if (!hidden || mesh == 0) continue;
    leftOut.add("hidden nodes");
    std::memcpy(bytes.data() + mesh, &kUnknown, sizeof kUnknown);
  }
  return bytes;
}

std::string readLwo(const std::filesystem::path& file, LeftOut& leftOut) {
  std::string bytes = readFile(file);
  if (bytes.size() < 12 || bytes.compare(8, 4, "LWO2") != 0) return bytes;
  bool hidden = false, counted = false;
  for (std::size_t at = 12; bytes.size() - at >= 8;) {
    std::uint32_t length = 0;
    for (std::size_t i = 4; i < 8; ++i) length = length << 8 | static_cast<unsigned char>(bytes[at + i]);
    if (length > bytes.size() - at - 8) break;
    const std::string type = bytes.substr(at, 4);
    if (type == "LAYR") {
      hidden = length >= 4 && (bytes[at + 11] & 1) != 0;  // the lowest bit of its flags
      counted = false;
    } else if (hidden && (type == "POLS" || type == "PTAG" || type == "VMAD")) {
      if (!counted) leftOut.add("hidden nodes");
      counted = true;
      bytes.replace(at, 4, "HIDE");  // a type that no reader knows
    }
    at += std::min<std::size_t>(8 + std::size_t{length} + length % 2, bytes.size() - at);
  }
  return bytes;
}

}  // namespace scanmill
