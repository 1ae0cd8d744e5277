#include "scene/gltf/container.h"

#include <fmt/core.h>

#include <cstdint>
#include <cstring>
#include <string_view>
#include <utility>

#include "base/error.h"
#include "base/file.h"

namespace scanmill::gltf {
namespace {

constexpr std::uint32_t kMagic = 0x46546C67;      // "glTF"
constexpr std::uint32_t kJsonChunk = 0x4E4F534A;  // "JSON"
constexpr std::uint32_t kBinChunk = 0x004E4942;   // "BIN"

std::uint32_t readWord(std::string_view bytes, std::size_t at) {
  std::uint32_t word = 0;
  std::memcpy(&word, bytes.data() + at, sizeof word);
  return word;
}

}  // namespace

// GLB: header of 12 bytes, then chunks of (length, kind, bytes).
Container readContainer(const std::filesystem::path& file, const std::filesystem::path& name) {
  const auto fail = [&](const std::string& what) { throw InputError({name.string()}, what); };
  std::string bytes = readFile(file);
  if (bytes.size() < 4 || readWord(bytes, 0) != kMagic) return {std::move(bytes), {}};
  if (bytes.size() < 20) fail("is truncated: the GLB header is not whole");
  if (readWord(bytes, 4) != 2) fail("is glTF 1.0, which is obsolete: export it as glTF 2.0");
  const std::size_t total = readWord(bytes, 8);
  if (total > bytes.size()) fail(fmt::format("is truncated: {} of {} bytes are here", bytes.size(), total));
  Container container;
  for (std::size_t at = 12; at + 8 <= total;) {
    const std::size_t size = readWord(bytes, at);
    const std::uint32_t kind = readWord(bytes, at + 4);
    if (size > total - at - 8) fail("is damaged: a GLB chunk is longer than the file");
    if (kind == kJsonChunk && container.json.empty()) container.json = bytes.substr(at + 8, size);
    if (kind == kBinChunk && container.bin.empty()) container.bin = bytes.substr(at + 8, size);
    at += 8 + size;
  }
  if (container.json.empty()) fail("is damaged: the GLB has no JSON chunk");
  return container;
}

}  // namespace scanmill::gltf
