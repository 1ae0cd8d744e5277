#include <meshoptimizer.h>

#include <utility>

#include "assets/meshes/gltf/json_reader.h"
#include "assets/meshes/references.h"
#include "base/error.h"
#include "base/file.h"
#include "formats/little_endian.h"

namespace scanmill::gltf {
namespace {

constexpr std::uint32_t kMagic = 0x46546C67;              // "glTF"
constexpr std::uint32_t kJsonChunk = 0x4E4F534A;          // "JSON"
constexpr std::uint32_t kBinChunk = 0x004E4942;           // "BIN"
constexpr std::size_t kGlbHeader = 12, kChunkHeader = 8;  // sizes (bytes)
constexpr std::uint32_t kTileMagic = 0x6D643362;          // "b3dm"
constexpr std::size_t kTileHeader = 28;                   // size of a tile's header (bytes)
constexpr std::uint64_t kMostStride = 252;                // largest stride in a view (bytes; glTF 2.0, 5.11.4)
// Offsets (bytes) in a tile's header of the fields that state the sizes of the tile's tables.
constexpr std::size_t kFeaturesAt = 12, kBinaryFeaturesAt = 16, kBatchesAt = 20, kBinaryBatchesAt = 24;

// Returns the glTF in a tile of 3D Tiles 1.0. A tile consists of a header, a feature table (JSON, then binary), a batch
// table (JSON, then binary) and the glTF. Sets Model::center if the feature table has RTC_CENTER (a list, or an offset
// into the table's binary part). Throws Error if the tile is damaged.
std::string glbOfTile(const std::string& tile, Model& model) {
  if (tile.size() < kTileHeader) throw Error("is truncated within the header of the tile");
  std::size_t begin = kTileHeader;
  for (const std::size_t at : {kFeaturesAt, kBinaryFeaturesAt, kBatchesAt, kBinaryBatchesAt})
    begin += numberAt<std::uint32_t>(tile, at);
  if (begin > tile.size()) throw Error("is damaged: the tables of the tile are longer than the file");
  constexpr std::size_t kEmptyTable = 8;  // size of "{}" with padding
  if (numberAt<std::uint32_t>(tile, kBatchesAt) > kEmptyTable) model.leftOut.add("batch tables (.b3dm)");
  const std::size_t jsonSize = numberAt<std::uint32_t>(tile, kFeaturesAt);
  const Json features = jsonSize > 0 ? Json::parse(tile.substr(kTileHeader, jsonSize)) : Json::object();
  const auto center = features.find("RTC_CENTER");
  if (center == features.end()) return tile.substr(begin);
  if (center->is_array()) {
    const auto [x, y, z] = center->get<std::array<double, 3>>();
    model.center = Vec3d{x, y, z};
  } else {
    const auto offset = center->at("byteOffset").get<std::size_t>();
    const std::size_t binarySize = numberAt<std::uint32_t>(tile, kBinaryFeaturesAt);
    if (offset > binarySize || binarySize - offset < sizeof(Vec3f)) {
      throw Error("is damaged: RTC_CENTER lies outside the feature table");
    }
    model.center = Vec3d(numberAt<Vec3f>(tile, kTileHeader + jsonSize + offset));
  }
  return tile.substr(begin);
}

constexpr std::uint64_t kMaxCount = std::uint64_t{1} << 31;

// Reads the buffer, offset, length and stride of a View or a Meshopt. Throws InputError for a range beyond the buffer.
void readRange(const JsonObject& object, auto& range) {
  range.buffer = object.index("buffer", object.model.buffers.size());
  range.offset = object.length("byteOffset");
  range.length = object.length("byteLength");
  range.stride = object.length("byteStride");
  if (range.offset + range.length > object.model.buffers[range.buffer].length) object.fail("reaches beyond its buffer");
}

// Reads EXT_meshopt_compression of a view. Sets Meshopt::problem for a mode or filter that is not supported.
Meshopt readMeshopt(const JsonObject& object) {
  Meshopt meshopt;
  readRange(object, meshopt);
  meshopt.count = object.length("count");
  const std::string mode = object.json.value("mode", std::string());
  const std::string filter = object.json.value("filter", std::string("NONE"));
  static const std::map<std::string, decltype(Meshopt::decode)> kModes{{"ATTRIBUTES", meshopt_decodeVertexBuffer},
                                                                       {"TRIANGLES", meshopt_decodeIndexBuffer},
                                                                       {"INDICES", meshopt_decodeIndexSequence}};
  static const std::map<std::string, decltype(Meshopt::filter)> kFilters{{"NONE", nullptr},
                                                                         {"OCTAHEDRAL", meshopt_decodeFilterOct},
                                                                         {"QUATERNION", meshopt_decodeFilterQuat},
                                                                         {"EXPONENTIAL", meshopt_decodeFilterExp}};
  if (!kModes.contains(mode) || !kFilters.contains(filter)) {
    meshopt.problem = fmt::format(
        "has {} with the mode '{}' and the filter '{}', which are not supported: export it without compression",
        object.path, mode, filter);
    return meshopt;
  }
  meshopt.decode = kModes.at(mode);
  meshopt.filter = kFilters.at(filter);
  // EXT_meshopt_compression demands these strides; meshoptimizer does not check them.
  const std::uint64_t stride = meshopt.stride;
  const bool hasAttributes = mode == "ATTRIBUTES";
  const bool strideFits = hasAttributes ? stride % 4 == 0 && stride >= 4 && stride <= 256 : stride == 2 || stride == 4;
  const bool filterStrideFits = filter == "OCTAHEDRAL"   ? stride == 4 || stride == 8
                                : filter == "QUATERNION" ? stride == 8
                                                         : true;
  const bool filterFits = filter == "NONE" || (hasAttributes && filterStrideFits);
  if (!strideFits || !filterFits || meshopt.count > kMaxCount || (mode == "TRIANGLES" && meshopt.count % 3 != 0)) {
    object.failInvalid("has {} elements of {} bytes in the mode {}", meshopt.count, stride, mode);
  }
  return meshopt;
}

Component readComponent(const JsonObject& object) {
  static const std::map<std::uint64_t, Component> kComponents{{5120, {'I', 1}}, {5121, {'U', 1}}, {5122, {'I', 2}},
                                                              {5123, {'U', 2}}, {5125, {'U', 4}}, {5126, {'F', 4}}};
  const auto value = object.json.find("componentType");
  const bool isNumber = value != object.json.end() && value->is_number_unsigned();
  const auto component = kComponents.find(isNumber ? value->get<std::uint64_t>() : 0);
  if (component == kComponents.end()) object.fail("has an unknown type");
  return component->second;
}

// Throws unless `count` elements of `size` bytes, which begin `stride` bytes apart, lie in the view.
void requireInside(const JsonObject& object, Index view, std::uint64_t offset, std::uint64_t count, std::uint64_t size,
                   std::uint64_t stride) {
  const std::uint64_t length = object.model.views[view].length;
  if (stride < size) object.fail("has elements that overlap");
  if (offset > length) object.fail("begins beyond its bufferView");
  if (count > 0 && offset + (count - 1) * stride + size > length) {
    object.fail("reaches beyond its bufferView: is the file truncated?");
  }
}

// Returns where the file stores the indices and the new values of the elements that a sparse accessor replaces.
Accessor::Sparse readSparse(const JsonObject& object, const Accessor& accessor) {
  const JsonObject indices{object.model, object.json.at("indices"), object.pathOf("indices")};
  const JsonObject values{object.model, object.json.at("values"), object.pathOf("values")};
  const Accessor::Sparse sparse{.count = object.length("count"),
                                .indicesView = indices.index("bufferView", object.model.views.size()),
                                .valuesView = values.index("bufferView", object.model.views.size()),
                                .indicesOffset = indices.length("byteOffset"),
                                .valuesOffset = values.length("byteOffset"),
                                .indices = readComponent(indices)};
  if (sparse.count > accessor.count) object.failInvalid("has more elements than its accessor");
  if (sparse.indices.kind != 'U') {
    object.model.fail("is not valid glTF: {} are not unsigned whole numbers", indices.path);
  }
  const std::uint64_t size = accessor.component.size * accessor.width;
  requireInside(indices, sparse.indicesView, sparse.indicesOffset, sparse.count, sparse.indices.size,
                sparse.indices.size);
  requireInside(values, sparse.valuesView, sparse.valuesOffset, sparse.count, size, size);
  return sparse;
}

// Reads a buffer, and sets its `problem` if bytes are missing. `allowOutside`: see AssetOptions.
Buffer readBuffer(const JsonObject& object, bool allowOutside) {
  Buffer buffer{.uri = object.json.value("uri", std::string()), .length = object.length("byteLength")};
  std::uint64_t available = object.model.bin.size();
  std::string source = "the GLB's binary chunk";
  if (buffer.uri.starts_with("data:")) {
    const std::size_t comma = buffer.uri.find(',');
    if (comma == std::string::npos || buffer.uri.find(";base64") > comma) object.fail("is not base64 data");
    std::size_t end = buffer.uri.size();
    while (end > comma + 1 && buffer.uri[end - 1] == '=') --end;
    available = (end - comma - 1) * 3 / 4;
    source = "its data";
  } else if (object.json.contains("uri")) {
    buffer.uri = decodeUri(buffer.uri);
    const std::filesystem::path path = object.model.file.parent_path() / buffer.uri;
    if (!allowOutside && leadsOutside(buffer.uri) && pathExists(path)) {
      object.model.fail("{}", refusalOf(buffer.uri));
    }
    if (!isFile(path)) {
      buffer.problem = fmt::format("names the buffer '{}', which is missing: put it beside the file", buffer.uri);
      return buffer;
    }
    available = std::filesystem::file_size(path);
    source = "'" + buffer.uri + "'";
  }
  if (buffer.length > available) {
    buffer.problem =
        fmt::format("{} has {} bytes, but {} has {}: is it truncated?", object.path, buffer.length, source, available);
  }
  return buffer;
}

View readView(const JsonObject& object) {
  View view;
  readRange(object, view);
  if (view.stride > kMostStride) object.fail("has a byteStride over 252");
  for (const char* name : {"EXT_meshopt_compression", "KHR_meshopt_compression"}) {
    const auto extension = object.extension(name);
    if (!extension) continue;
    const Meshopt meshopt = readMeshopt({object.model, extension->json, object.pathOf(name)});
    if (meshopt.count * meshopt.stride != view.length) {
      object.failInvalid("has a length that differs from its {} elements of {} bytes", meshopt.count, meshopt.stride);
    }
    view.compressed = meshopt;
  }
  return view;
}

Accessor readAccessor(const JsonObject& object) {
  static const std::map<std::string, std::size_t> kWidths{{"SCALAR", 1}, {"VEC2", 2}, {"VEC3", 3}, {"VEC4", 4},
                                                          {"MAT2", 4},   {"MAT3", 9}, {"MAT4", 16}};
  Accessor accessor;
  accessor.component = readComponent(object);
  const auto width = kWidths.find(object.json.value("type", std::string()));
  if (width == kWidths.end()) object.fail("has an unknown type");
  accessor.width = width->second;
  accessor.count = object.length("count");
  accessor.offset = object.length("byteOffset");
  accessor.normalized = object.json.value("normalized", false);
  if (accessor.count > kMaxCount) object.fail("has a count that is too large");
  accessor.view = object.maybeIndex("bufferView", object.model.views.size());
  if (accessor.view) {
    const std::uint64_t size = accessor.component.size * accessor.width,
                        stride = object.model.views[*accessor.view].stride;
    requireInside(object, *accessor.view, accessor.offset, accessor.count, size, stride > 0 ? stride : size);
  }
  if (object.json.contains("sparse")) {
    accessor.sparse = readSparse({object.model, object.json["sparse"], object.pathOf("sparse")}, accessor);
  }
  return accessor;
}

}  // namespace

// A GLB consists of a header (magic, version, total size) and of chunks (size, kind, bytes); all numbers are uint32.
std::string readContainer(const std::filesystem::path& file, Model& model) {
  std::string bytes = readFile(file);
  if (bytes.starts_with("\x1F\x8B")) {
    model.fail(
        "is compressed by gzip: unpack it, with 'gunzip < FILE > UNPACKED', and all other files of the tileset alike");
  }
  if (bytes.size() >= 4 && numberAt<std::uint32_t>(bytes, 0) == kTileMagic) {
    try {
      bytes = glbOfTile(bytes, model);
    } catch (const nlohmann::json::exception& e) {
      model.fail("is damaged: its feature table: {}", reasonOf(e));
    } catch (const Error& e) {
      model.fail("{}", e.what());
    }
  }
  if (bytes.size() < 4 || numberAt<std::uint32_t>(bytes, 0) != kMagic) return bytes;
  if (bytes.size() < kGlbHeader + kChunkHeader) model.fail("is truncated within the GLB header");
  if (numberAt<std::uint32_t>(bytes, 4) != 2) model.fail("is glTF 1.0, which is obsolete: export it as glTF 2.0");
  const std::size_t total = numberAt<std::uint32_t>(bytes, 8);
  if (total > bytes.size()) model.fail("is truncated: has {} of {} bytes", bytes.size(), total);
  std::string json;
  for (std::size_t at = kGlbHeader; at + kChunkHeader <= total;) {
    const std::size_t size = numberAt<std::uint32_t>(bytes, at);
    const std::uint32_t kind = numberAt<std::uint32_t>(bytes, at + 4);
    at += kChunkHeader;
    if (size > total - at) model.fail("is damaged: a GLB chunk is longer than the file");
    if (kind == kJsonChunk && json.empty()) json = bytes.substr(at, size);
    if (kind == kBinChunk && model.bin.empty()) model.bin = bytes.substr(at, size);
    at += size;
  }
  if (json.empty()) model.fail("is damaged: the GLB has no JSON chunk");
  return json;
}

void readStorage(Model& model, const JsonObject& file, bool allowOutside) {
  readEach(file, "buffers", model.buffers, [&](const JsonObject& object) { return readBuffer(object, allowOutside); });
  readEach(file, "bufferViews", model.views, readView);
  readEach(file, "accessors", model.accessors, readAccessor);
}

}  // namespace scanmill::gltf
