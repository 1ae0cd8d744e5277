#include "scene/assets/gltf_container.h"

#include <fmt/core.h>

#include <cstdint>
#include <cstring>
#include <string_view>
#include <utility>

#include "base/error.h"
#include "base/file.h"

namespace scanmill {
namespace {

constexpr std::uint32_t kMagic = 0x46546C67;      // "glTF"
constexpr std::uint32_t kJsonChunk = 0x4E4F534A;  // "JSON"
constexpr std::uint32_t kBinChunk = 0x004E4942;   // "BIN"

std::uint32_t readWord(std::string_view bytes, std::size_t at) {
  std::uint32_t word = 0;
  std::memcpy(&word, bytes.data() + at, sizeof word);
  return word;
}

void appendWord(std::string& bytes, std::size_t word) {
  const auto value = static_cast<std::uint32_t>(word);
  bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

}  // namespace

// GLB: header of 12 bytes, then chunks of (length, kind, bytes).
GltfContainer readGltfContainer(const std::filesystem::path& file) {
  const auto fail = [&](const std::string& what) { throw InputError({file.string()}, what); };
  std::string bytes = readFile(file);
  if (bytes.size() < 4 || readWord(bytes, 0) != kMagic) return {std::move(bytes), {}, false};
  if (bytes.size() < 20) fail("is truncated: the GLB header is not whole");
  if (readWord(bytes, 4) != 2) fail("is glTF 1.0, which is obsolete: export it as glTF 2.0");
  const std::size_t total = readWord(bytes, 8);
  if (total > bytes.size()) fail(fmt::format("is truncated: {} of {} bytes are here", bytes.size(), total));
  GltfContainer container;
  container.binary = true;
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

std::string packGltf(GltfContainer container, const std::filesystem::path& file) {
  if (!container.binary) return std::move(container.json);
  container.json.resize((container.json.size() + 3) / 4 * 4, ' ');
  container.bin.resize((container.bin.size() + 3) / 4 * 4, '\0');
  const std::size_t total = 12 + 8 + container.json.size() + (container.bin.empty() ? 0 : 8 + container.bin.size());
  if (total > UINT32_MAX) throw InputError({file.string()}, "is larger than a GLB can be");
  std::string out;
  out.reserve(total);
  for (const std::size_t word :
       {std::size_t{kMagic}, std::size_t{2}, total, container.json.size(), std::size_t{kJsonChunk}}) {
    appendWord(out, word);
  }
  out += container.json;
  if (!container.bin.empty()) {
    appendWord(out, container.bin.size());
    appendWord(out, kBinChunk);
    out += container.bin;
  }
  return out;
}

}  // namespace scanmill
