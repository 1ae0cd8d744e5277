#include <meshoptimizer.h>

#include <algorithm>
#include <utility>

#include "assets/meshes/gltf/json_reader.h"
#include "assets/meshes/references.h"
#include "base/error.h"
#include "base/file.h"
#include "formats/little_endian.h"

namespace scanmill::gltf {
namespace {

constexpr std::uint32_t kMagic = 0x46546C67;      // "glTF"
constexpr std::uint32_t kJsonChunk = 0x4E4F534A;  // "JSON"
constexpr std::uint32_t kBinChunk = 0x004E4942;   // "BIN"
constexpr std::uint32_t kTileMagic = 0x6D643362;  // "b3dm"
constexpr std::size_t kTileHeader = 28;           // size of a tile's header (bytes)
// Offsets in the header of the sizes (bytes) of a tile's tables.
constexpr std::size_t kFeaturesAt = 12, kBinaryFeaturesAt = 16, kBatchesAt = 20, kBinaryBatchesAt = 24;

// Returns the glTF in a tile of 3D Tiles 1.0. A tile consists of a header, a feature table (JSON, then binary), a batch
// table (JSON, then binary) and the glTF. Sets `center` of the container if the feature table has RTC_CENTER, as a list
// or as an offset into the table's binary part, and `batchTable`.
std::string glbOfTile(const std::string& tile, Container& container) {
  if (tile.size() < kTileHeader) throw Error("is truncated within the header of the tile");
  std::size_t begin = kTileHeader;
  for (const std::size_t at : {kFeaturesAt, kBinaryFeaturesAt, kBatchesAt, kBinaryBatchesAt})
    begin += numberAt<std::uint32_t>(tile, at);
  if (begin > tile.size()) throw Error("is damaged: the tables of the tile are longer than the file");
  constexpr std::size_t kEmptyTable = 8;  // size of "{}" with padding
  container.batchTable = numberAt<std::uint32_t>(tile, kBatchesAt) > kEmptyTable;
  const std::size_t features = numberAt<std::uint32_t>(tile, kFeaturesAt);
  if (features > 0) {
    const auto json = nlohmann::json::parse(tile.substr(kTileHeader, features));
    if (const auto found = json.find("RTC_CENTER"); found != json.end()) {
      std::array<double, 3> c{};
      if (found->is_array()) {
        c = found->get<std::array<double, 3>>();
      } else {
        const auto offset = found->at("byteOffset").get<std::size_t>();
        const std::size_t binary = numberAt<std::uint32_t>(tile, kBinaryFeaturesAt);
        if (offset > binary || binary - offset < 12)
          throw Error("is damaged: RTC_CENTER lies outside the feature table");
        const auto f = numberAt<std::array<float, 3>>(tile, kTileHeader + features + offset);
        std::copy(f.begin(), f.end(), c.begin());
      }
      container.center = Vec3d{c[0], c[1], c[2]};
    }
  }
  return tile.substr(begin);
}

constexpr std::uint64_t kMaxCount = std::uint64_t{1} << 31;

class StorageReader : JsonReader {
 public:
  StorageReader(Model& model, const Json& json, bool allowOutside)
      : JsonReader(model, json), allowOutside_(allowOutside) {}

  void read() {
    each("buffers", m_.buffers, [&](const Json& j, const std::string& what) { return buffer(j, what); });
    each("bufferViews", m_.views, [&](const Json& j, const std::string& what) { return view(j, what); });
    each("accessors", m_.accessors, [&](const Json& j, const std::string& what) { return accessor(j, what); });
  }

 private:
  Buffer buffer(const Json& j, const std::string& what) const {
    Buffer b;
    b.length = length(j, "byteLength", 0, what);
    std::uint64_t available = m_.bin.size();
    std::string source = "the GLB's binary chunk";
    if (j.contains("uri")) {
      b.uri = j["uri"].get<std::string>();
      if (b.uri.starts_with("data:")) {
        const std::size_t comma = b.uri.find(',');
        if (comma == std::string::npos || b.uri.find(";base64") > comma) fail(what + " is not base64 data");
        std::size_t end = b.uri.size();
        while (end > comma + 1 && b.uri[end - 1] == '=') --end;
        available = (end - comma - 1) * 3 / 4;
        source = "its data";
      } else {
        b.uri = decodeUri(b.uri);
        const std::filesystem::path path = m_.file.parent_path() / b.uri;
        std::error_code error;
        if (!allowOutside_ && leadsOutside(b.uri) && std::filesystem::exists(path, error)) m_.fail(refusalOf(b.uri));
        if (!std::filesystem::is_regular_file(path, error)) {
          b.problem = fmt::format("names the buffer '{}', which is missing: put it beside the file", b.uri);
          return b;
        }
        available = std::filesystem::file_size(path, error);
        source = "'" + b.uri + "'";
      }
    }
    if (b.length > available) {
      b.problem = fmt::format("{} has {} bytes, but {} has {}: is it truncated?", what, b.length, source, available);
    }
    return b;
  }

  View view(const Json& j, const std::string& what) const {
    View v;
    readPart(j, what, v);
    if (v.stride > 252) fail(what + " has a byteStride over 252");
    for (const char* name : {"EXT_meshopt_compression", "KHR_meshopt_compression"}) {
      if (const Json* extension = extensionOf(j, name)) {
        v.compressed = meshopt(*extension, fmt::format("{}.{}", what, name));
        if (v.compressed->count * v.compressed->stride != v.length) {
          fail(fmt::format("is not valid glTF: {} has a length that differs from its {} elements of {} bytes", what,
                           v.compressed->count, v.compressed->stride));
        }
      }
    }
    return v;
  }

  // Reads which part of a buffer a View or a Meshopt describes.
  void readPart(const Json& j, const std::string& what, auto& part) const {
    part.buffer = index(j.at("buffer"), m_.buffers.size(), what + ".buffer");
    part.offset = length(j, "byteOffset", 0, what);
    part.length = length(j, "byteLength", 0, what);
    part.stride = length(j, "byteStride", 0, what);
    if (part.offset + part.length > m_.buffers[part.buffer].length) fail(what + " reaches beyond its buffer");
  }

  Meshopt meshopt(const Json& j, const std::string& what) const {
    Meshopt m;
    readPart(j, what, m);
    m.count = length(j, "count", 0, what);
    const std::string mode = j.value("mode", std::string());
    const std::string filter = j.value("filter", std::string("NONE"));
    static const std::map<std::string, decltype(Meshopt::decode)> kModes{{"ATTRIBUTES", meshopt_decodeVertexBuffer},
                                                                         {"TRIANGLES", meshopt_decodeIndexBuffer},
                                                                         {"INDICES", meshopt_decodeIndexSequence}};
    static const std::map<std::string, decltype(Meshopt::filter)> kFilters{{"NONE", nullptr},
                                                                           {"OCTAHEDRAL", meshopt_decodeFilterOct},
                                                                           {"QUATERNION", meshopt_decodeFilterQuat},
                                                                           {"EXPONENTIAL", meshopt_decodeFilterExp}};
    if (!kModes.contains(mode) || !kFilters.contains(filter)) {
      m.problem = fmt::format(
          "has {} with the mode '{}' and the filter '{}', which are not supported: export it without compression", what,
          mode, filter);
      return m;
    }
    m.decode = kModes.at(mode);
    m.filter = kFilters.at(filter);
    const bool attributes = mode == "ATTRIBUTES";
    const bool strideFits =
        attributes ? m.stride % 4 == 0 && m.stride >= 4 && m.stride <= 256 : m.stride == 2 || m.stride == 4;
    const bool filterFits = filter == "NONE" || (attributes && (filter == "OCTAHEDRAL" ? m.stride == 4 || m.stride == 8
                                                                : filter == "QUATERNION" ? m.stride == 8
                                                                                         : true));
    if (!strideFits || !filterFits || m.count > kMaxCount || (mode == "TRIANGLES" && m.count % 3 != 0)) {
      fail(fmt::format("is not valid glTF: {} has {} elements of {} bytes in the mode {}", what, m.count, m.stride,
                       mode));
    }
    return m;
  }

  Component component(const Json& object, const std::string& what) const {
    static const std::map<std::uint64_t, Component> kComponents{{5120, {'I', 1}}, {5121, {'U', 1}}, {5122, {'I', 2}},
                                                                {5123, {'U', 2}}, {5125, {'U', 4}}, {5126, {'F', 4}}};
    const auto value = object.find("componentType");
    const bool isNumber = value != object.end() && value->is_number_unsigned();
    const auto known = kComponents.find(isNumber ? value->get<std::uint64_t>() : 0);
    if (known == kComponents.end()) fail(what + " has an unknown type");
    return known->second;
  }

  Accessor accessor(const Json& j, const std::string& what) const {
    static const std::map<std::string, std::size_t> kWidths{{"SCALAR", 1}, {"VEC2", 2}, {"VEC3", 3}, {"VEC4", 4},
                                                            {"MAT2", 4},   {"MAT3", 9}, {"MAT4", 16}};
    Accessor a;
    a.component = component(j, what);
    const auto width = kWidths.find(j.value("type", std::string()));
    if (width == kWidths.end()) fail(what + " has an unknown type");
    a.width = width->second;
    a.count = length(j, "count", 0, what);
    a.offset = length(j, "byteOffset", 0, what);
    a.normalized = j.value("normalized", false);
    if (a.count > kMaxCount) fail(what + " has a count that is too large");
    a.view = maybe(j, "bufferView", m_.views.size(), what);
    const std::uint64_t size = a.component.size * a.width;
    const std::uint64_t stride = a.view ? m_.views[*a.view].stride : 0;
    if (a.view) requireInside(*a.view, a.offset, a.count, size, stride > 0 ? stride : size, what);
    if (const auto sparse = j.find("sparse"); sparse != j.end()) a.sparse = sparseOf(*sparse, a, what + ".sparse");
    return a;
  }

  // Throws unless `count` elements of `size` bytes, which begin `stride` bytes apart, lie in the view.
  void requireInside(Index view, std::uint64_t offset, std::uint64_t count, std::uint64_t size, std::uint64_t stride,
                     const std::string& what) const {
    const View& v = m_.views[view];
    if (stride < size) fail(what + " has elements that overlap");
    if (offset > v.length) fail(what + " begins beyond its bufferView");
    if (count > 0 && offset + (count - 1) * stride + size > v.length) {
      fail(what + " reaches beyond its bufferView: is the file truncated?");
    }
  }

  Accessor::Sparse sparseOf(const Json& j, const Accessor& a, const std::string& what) const {
    Accessor::Sparse s;
    s.count = length(j, "count", 0, what);
    if (s.count > a.count) fail(fmt::format("is not valid glTF: {} has more elements than its accessor", what));
    const Json& indices = j.at("indices");
    const Json& values = j.at("values");
    s.indices = component(indices, what + ".indices");
    if (s.indices.kind != 'U') {
      fail(fmt::format("is not valid glTF: {}.indices are not unsigned whole numbers", what));
    }
    s.indicesView = index(indices.at("bufferView"), m_.views.size(), what + ".indices.bufferView");
    s.indicesOffset = length(indices, "byteOffset", 0, what + ".indices");
    s.valuesView = index(values.at("bufferView"), m_.views.size(), what + ".values.bufferView");
    s.valuesOffset = length(values, "byteOffset", 0, what + ".values");
    const std::uint64_t size = a.component.size * a.width;
    requireInside(s.indicesView, s.indicesOffset, s.count, s.indices.size, s.indices.size, what + ".indices");
    requireInside(s.valuesView, s.valuesOffset, s.count, size, size, what + ".values");
    return s;
  }

  bool allowOutside_;
};

}  // namespace

// Reads a .gltf, .glb or .b3dm. A GLB consists of a header of 12 bytes and of chunks: (length, kind, bytes).
Container readContainer(const std::filesystem::path& file, const std::filesystem::path& name) {
  const auto fail = [&](const std::string& what) { throw InputError({name.string()}, what); };
  std::string bytes = readFile(file);
  Container container;
  if (bytes.starts_with("\x1F\x8B")) {
    fail("is compressed by gzip: unpack it, with 'gunzip < FILE > UNPACKED', and all other files of the tileset alike");
  }
  if (bytes.size() >= 4 && numberAt<std::uint32_t>(bytes, 0) == kTileMagic) {
    try {
      bytes = glbOfTile(bytes, container);
    } catch (const nlohmann::json::exception& e) {
      fail(fmt::format("is damaged: its feature table: {}", reasonOf(e)));
    } catch (const Error& e) {
      fail(e.what());
    }
  }
  if (bytes.size() < 4 || numberAt<std::uint32_t>(bytes, 0) != kMagic) {
    container.json = std::move(bytes);
    return container;
  }
  if (bytes.size() < 20) fail("is truncated within the GLB header");
  if (numberAt<std::uint32_t>(bytes, 4) != 2) fail("is glTF 1.0, which is obsolete: export it as glTF 2.0");
  const std::size_t total = numberAt<std::uint32_t>(bytes, 8);
  if (total > bytes.size()) fail(fmt::format("is truncated: has {} of {} bytes", bytes.size(), total));
  for (std::size_t at = 12; at + 8 <= total;) {
    const std::size_t size = numberAt<std::uint32_t>(bytes, at);
    const std::uint32_t kind = numberAt<std::uint32_t>(bytes, at + 4);
    if (size > total - at - 8) fail("is damaged: a GLB chunk is longer than the file");
    if (kind == kJsonChunk && container.json.empty()) container.json = bytes.substr(at + 8, size);
    if (kind == kBinChunk && container.bin.empty()) container.bin = bytes.substr(at + 8, size);
    at += 8 + size;
  }
  if (container.json.empty()) fail("is damaged: the GLB has no JSON chunk");
  return container;
}

void readStorage(Model& model, const Json& json, bool allowOutside) {
  StorageReader(model, json, allowOutside).read();
}

}  // namespace scanmill::gltf
