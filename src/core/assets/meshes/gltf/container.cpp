#include "assets/meshes/gltf/container.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <nlohmann/json.hpp>
#include <string_view>
#include <utility>

#include "base/error.h"
#include "base/file.h"

namespace scanmill::gltf {
namespace {

constexpr std::uint32_t kMagic = 0x46546C67;      // "glTF"
constexpr std::uint32_t kJsonChunk = 0x4E4F534A;  // "JSON"
constexpr std::uint32_t kBinChunk = 0x004E4942;   // "BIN"
constexpr std::uint32_t kTileMagic = 0x6D643362;  // "b3dm"
constexpr std::size_t kTileHeader = 28;           // size of a tile's header (bytes)

std::uint32_t readWord(std::string_view bytes, std::size_t at) {
  std::uint32_t word = 0;
  std::memcpy(&word, bytes.data() + at, sizeof word);
  return word;
}

// Returns the glTF in a tile of 3D Tiles 1.0. A tile consists of a header, a feature table (JSON, then binary), a batch
// table (JSON, then binary) and the glTF. Sets `center` if the feature table has RTC_CENTER, as a list or as an offset
// into the table's binary part, and `batchTable`.
std::string glbOfTile(const std::string& tile, std::optional<Vec3d>& center, bool& batchTable) {
  if (tile.size() < kTileHeader) throw Error("is truncated within the header of the tile");
  std::size_t begin = kTileHeader;
  for (const std::size_t at : {12, 16, 20, 24}) begin += readWord(tile, at);
  if (begin > tile.size()) {
    // Until 2017, the header had 20 or 24 bytes; text or a glTF stood where sizes stand now.
    if (std::max(readWord(tile, 20), readWord(tile, 24)) > 0x20000000) {
      throw Error("has the header of a draft of 3D Tiles: convert it, for example by '3d-tiles-tools upgrade'");
    }
    throw Error("is damaged: the tables of the tile are longer than the file");
  }
  constexpr std::size_t kEmptyTable = 8;  // size of "{}" with padding
  batchTable = readWord(tile, 20) > kEmptyTable;
  const std::size_t features = readWord(tile, 12);
  if (features > 0) {
    const auto json = nlohmann::json::parse(tile.substr(kTileHeader, features));
    if (const auto found = json.find("RTC_CENTER"); found != json.end()) {
      std::array<double, 3> c{};
      if (found->is_array()) {
        c = found->get<std::array<double, 3>>();
      } else {
        const auto offset = found->at("byteOffset").get<std::size_t>();
        const std::size_t binary = readWord(tile, 16);
        if (offset > binary || binary - offset < 12)
          throw Error("is damaged: RTC_CENTER lies outside the feature table");
        std::array<float, 3> f{};
        std::memcpy(f.data(), tile.data() + kTileHeader + features + offset, sizeof f);
        std::copy(f.begin(), f.end(), c.begin());
      }
      center = Vec3d{c[0], c[1], c[2]};
    }
  }
  return tile.substr(begin);
}

}  // namespace

// Reads a .gltf, .glb or .b3dm. A GLB consists of a header of 12 bytes and of chunks: (length, kind, bytes).
Container readContainer(const std::filesystem::path& file, const std::filesystem::path& name) {
  const auto fail = [&](const std::string& what) { throw InputError({name.string()}, what); };
  std::string bytes = readFile(file);
  Container container;
  if (bytes.starts_with("\x1F\x8B")) {
    fail("is compressed by gzip: unpack it, with 'gunzip < FILE > UNPACKED', and all other files of the tileset alike");
  }
  if (bytes.size() >= 4 && readWord(bytes, 0) == kTileMagic) {
    try {
      bytes = glbOfTile(bytes, container.center, container.batchTable);
    } catch (const nlohmann::json::exception& e) {
      fail(fmt::format("is damaged: its feature table: {}", reasonOf(e)));
    } catch (const Error& e) {
      fail(e.what());
    }
  }
  if (bytes.size() < 4 || readWord(bytes, 0) != kMagic) {
    container.json = std::move(bytes);
    return container;
  }
  if (bytes.size() < 20) fail("is truncated within the GLB header");
  if (readWord(bytes, 4) != 2) fail("is glTF 1.0, which is obsolete: export it as glTF 2.0");
  const std::size_t total = readWord(bytes, 8);
  if (total > bytes.size()) fail(fmt::format("is truncated: has {} of {} bytes", bytes.size(), total));
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
