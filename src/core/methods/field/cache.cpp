#include "methods/field/cache.h"

#include <fcntl.h>
#include <fmt/core.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <mutex>
#include <string_view>
#include <system_error>
#include <type_traits>
#include <utility>
#include <vector>

#include "base/error.h"
#include "base/file.h"
#include "base/hash.h"
#include "base/parallel.h"
#include "config/version.h"

namespace scanmill {

namespace fs = std::filesystem;

namespace {

constexpr const char* kRemedy = "; give `cache` another folder, or none";

static_assert(std::endian::native == std::endian::little, "the arrays are written as they lie in memory");

// Rises when the file's layout changes, or when buildField() makes other bytes of the same geometry and shape.
constexpr std::uint32_t kFieldVersion = 2;

// A file: this, the five arrays of forArrays() as they lie in memory, and the SHA-256 of slicesHash() in hexadecimal.
//
// What is read from a file with the right hash and key is what buildField() made of this very geometry and shape: its
// indices are trusted to lie within its arrays, and within the triangles of the world.
struct FieldFileHeader {
  std::array<char, 16> magic;
  std::uint64_t version;
  std::array<char, 64> key;
  std::array<std::uint64_t, 5> counts;  // entries of the arrays
};
static_assert(sizeof(FieldFileHeader) == 128 && std::is_trivially_copyable_v<FieldFileHeader>);

constexpr std::array<char, 16> kMagic{'s', 'c', 'a', 'n', 'm', 'i', 'l', 'l', ' ', 'f', 'i', 'e', 'l', 'd', '\n', 0};
constexpr std::size_t kHashSize = 64;
constexpr std::size_t kSlice = std::size_t{1} << 20;  // bytes that are read and hashed together
constexpr std::string_view kFieldSuffix = ".field";
// Temporaries of runs that were killed are deleted when they are so old.
constexpr std::chrono::hours kAbandoned{24};

template <class AnyField, class Use>
void forArrays(AnyField& field, const Use& use) {
  use(field.levels);
  use(field.table);
  use(field.distance);
  use(field.word);
  use(field.lists);
}

template <class T>
void addBytes(Sha256& hash, const T& value) {
  static_assert(std::is_trivially_copyable_v<T> && std::has_unique_object_representations_v<T>);
  hash.add({reinterpret_cast<const char*>(&value), sizeof value});
}

void addBytes(Sha256& hash, double value) {
  addBytes(hash, std::bit_cast<std::uint64_t>(value));
}

void addBytes(Sha256& hash, float value) {
  addBytes(hash, std::bit_cast<std::uint32_t>(value));
}

void addBytes(Sha256& hash, const Vec3d& v) {
  for (const double x : {v.x, v.y, v.z}) addBytes(hash, x);
}

void addText(Sha256& hash, std::string_view text) {
  addBytes(hash, std::uint64_t{text.size()});
  hash.add(text);
}

template <class T>
std::string_view bytesOf(const std::vector<T>& array) {
  return {reinterpret_cast<const char*>(array.data()), array.size() * sizeof(T)};
}

// Of all that a field's bytes follow from.
std::string fieldKey(const std::string& geometry, const FieldShape& shape, const Vec3d& worldOrigin) {
  Sha256 hash;
  addText(hash, kVersion);
  addBytes(hash, kFieldVersion);
  addText(hash, geometry);
  addBytes(hash, worldOrigin);
  addBytes(hash, shape.voxel);
  addBytes(hash, shape.centre);
  addBytes(hash, std::uint64_t{shape.levels.size()});
  for (const LevelBox& box : shape.levels) {
    addBytes(hash, box.firstBrick);
    addBytes(hash, box.bricks);
  }
  addBytes(hash, shape.reach);
  addBytes(hash, std::uint32_t{shape.lists});
  for (const int constant : {kBrickVoxels, kBrickCorners, kCornersPerBrick, kBrickStride}) addBytes(hash, constant);
  for (const std::uint32_t mark : {kNoWord, kFullBrick, kLastOfList, kMaxLevels}) addBytes(hash, mark);
  for (const float voxels : {kDistanceStep, kEmptyBrick, kExact, kNamed, kListed, kListedHalf}) addBytes(hash, voxels);
  return hash.hex();
}

FieldFileHeader headerOf(const DistanceField& field, const std::string& key) {
  FieldFileHeader header{kMagic, kFieldVersion, {}, {}};
  std::copy_n(key.begin(), header.key.size(), header.key.begin());
  std::size_t next = 0;
  forArrays(field, [&](const auto& array) { header.counts[next++] = array.size(); });
  return header;
}

std::string_view bytesOf(const FieldFileHeader& header) {
  return {reinterpret_cast<const char*>(&header), sizeof header};
}

// Of header and arrays: of slices, on all cores, and then of the slices' hashes. load(to, size, place in the arrays'
// bytes) comes before a slice is hashed; empty where one fails.
template <class AnyField, class Load>
std::string slicesHash(const FieldFileHeader& header, AnyField& field, const Load& load) {
  using Byte = std::conditional_t<std::is_const_v<AnyField>, const char, char>;
  struct Slice {
    Byte* first;
    std::size_t size;
    std::uint64_t place;
  };
  std::vector<Slice> slices;
  std::uint64_t place = 0;
  forArrays(field, [&](auto& array) {
    const std::size_t size = bytesOf(array).size();
    auto* bytes = reinterpret_cast<Byte*>(array.data());
    for (std::size_t at = 0; at < size; at += kSlice) {
      slices.push_back({bytes + at, std::min(kSlice, size - at), place + at});
    }
    place += size;
  });
  std::vector<std::string> hashes(slices.size());
  std::atomic<bool> whole = true;
  parallelFor(slices.size(), 1, [&](std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last && whole; ++i) {
      if (load(slices[i].first, slices[i].size, slices[i].place)) {
        hashes[i] = sha256({slices[i].first, slices[i].size});
      } else {
        whole = false;
      }
    }
  });
  if (!whole) return {};
  Sha256 all;
  all.add(bytesOf(header));
  for (const std::string& hash : hashes) all.add(hash);
  return all.hex();
}

class OpenFile {
 public:
  // Non-blocking, so that a pipe nobody writes to is not waited for.
  explicit OpenFile(const fs::path& path) : descriptor_(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK)) {}
  ~OpenFile() {
    if (descriptor_ >= 0) ::close(descriptor_);
  }
  OpenFile(const OpenFile&) = delete;
  OpenFile& operator=(const OpenFile&) = delete;

  // Of a regular file; 0 where there is none.
  std::uint64_t size() const {
    struct stat status {};
    if (descriptor_ < 0 || ::fstat(descriptor_, &status) != 0 || !S_ISREG(status.st_mode)) return 0;
    return static_cast<std::uint64_t>(status.st_size);
  }

  bool read(char* to, std::size_t size, std::uint64_t place) const {
    while (size > 0) {
      const ssize_t n = ::pread(descriptor_, to, size, static_cast<off_t>(place));
      if (n < 0 && errno == EINTR) continue;
      if (n <= 0) return false;
      to += n;
      size -= static_cast<std::size_t>(n);
      place += static_cast<std::uint64_t>(n);
    }
    return true;
  }

 private:
  int descriptor_;
};

// Sizes the arrays as the header says, where that is what the shape wants and what the file of `size` bytes holds.
bool makeRoom(const FieldFileHeader& header, std::uint64_t size, DistanceField& field) {
  std::uint64_t expected = sizeof header + kHashSize;
  std::size_t next = 0;
  bool fits = true;
  forArrays(field, [&](const auto& array) {
    const std::uint64_t count = header.counts[next++];
    fits = fits && count <= size;  // the sum below cannot overflow
    if (fits) expected += count * sizeof array[0];
  });
  const auto& [levels, table, distance, word, lists] = header.counts;
  std::uint64_t bricks = 0;
  for (const LevelBox& box : field.shape.levels) bricks += box.size();
  if (!fits || expected != size || levels != field.shape.levels.size() || table != bricks ||
      distance % kBrickStride != 0 || word != distance || (lists != 0 && !field.shape.lists)) {
    return false;
  }
  next = 0;
  forArrays(field, [&](auto& array) { array.resize(header.counts[next++]); });
  return true;
}

std::shared_ptr<const DistanceField> readField(const fs::path& path, const FieldShape& shape, const std::string& key) {
  const OpenFile file(path);
  const std::uint64_t size = file.size();
  FieldFileHeader header;
  auto field = std::make_shared<DistanceField>();
  field->shape = shape;
  if (size < sizeof header + kHashSize || size > FieldCache::kCacheBytes) return nullptr;
  if (!file.read(reinterpret_cast<char*>(&header), sizeof header, 0)) return nullptr;
  const std::string_view found(header.key.data(), header.key.size());
  if (header.magic != kMagic || header.version != kFieldVersion || found != key) return nullptr;
  if (!makeRoom(header, size, *field)) return nullptr;
  std::string stored(kHashSize, '\0');
  if (!file.read(stored.data(), kHashSize, size - kHashSize)) return nullptr;
  const std::string hash = slicesHash(header, *field, [&](char* to, std::size_t bytes, std::uint64_t place) {
    return file.read(to, bytes, sizeof header + place);
  });
  return hash == stored ? field : nullptr;
}

bool isFieldName(std::string_view name) {
  return name.size() == 64 + kFieldSuffix.size() && name.ends_with(kFieldSuffix) &&
         name.find_first_not_of("0123456789abcdef") == 64;
}

// Deletes the fields longest unused until the others fit, and what killed runs left behind. Others may do so too:
// whatever is gone already does not matter.
void evict(const fs::path& folder, const fs::path& kept) {
  struct Stored {
    fs::file_time_type used;
    fs::path path;
    std::uintmax_t size;
  };
  std::vector<Stored> fields;
  std::uintmax_t total = 0;
  std::error_code ignored;
  for (fs::directory_iterator entry(folder, ignored), end; !ignored && entry != end; entry.increment(ignored)) {
    const std::string name = entry->path().filename().string();
    std::error_code gone;
    const fs::file_time_type used = entry->last_write_time(gone);
    if (gone) continue;
    if (isFieldName(name)) {
      const std::uintmax_t size = entry->file_size(gone);
      if (gone) continue;
      total += size;
      if (entry->path() != kept) fields.push_back({used, entry->path(), size});
    } else if (const std::size_t mark = name.find(".partial-"); mark != std::string::npos &&
                                                                isFieldName(std::string_view(name).substr(0, mark)) &&
                                                                fs::file_time_type::clock::now() - used > kAbandoned) {
      fs::remove(entry->path(), gone);
    }
  }
  std::sort(fields.begin(), fields.end(), [](const Stored& a, const Stored& b) {
    return std::pair(a.used, a.path.native()) < std::pair(b.used, b.path.native());
  });
  for (const Stored& oldest : fields) {
    if (total <= FieldCache::kCacheBytes) return;
    fs::remove(oldest.path, ignored);
    total -= oldest.size;
  }
}

std::string meshHash(const Scene& scene, const Mesh& mesh) {
  Sha256 hash;
  for (const std::string_view bytes : {bytesOf(mesh.positions), bytesOf(mesh.triangles), bytesOf(mesh.surfaceOf)}) {
    addText(hash, bytes);
  }
  addBytes(hash, std::uint64_t{mesh.surfaces.size()});
  for (const Surface& surface : mesh.surfaces) {
    const Material& material = scene.materials[surface.material];
    addBytes(hash, surface.object);
    addBytes(hash, std::uint32_t{material.alphaTested && material.texture != nullptr});
  }
  return hash.hex();
}

}  // namespace

FieldCache::FieldCache(fs::path folder, std::string geometry)
    : folder_(std::move(folder)), geometry_(std::move(geometry)) {}

fs::path FieldCache::file(const FieldShape& shape, const Vec3d& worldOrigin) const {
  return folder_ / (fieldKey(geometry_, shape, worldOrigin) + std::string(kFieldSuffix));
}

std::shared_ptr<const DistanceField> FieldCache::find(const FieldShape& shape, const Vec3d& worldOrigin) const {
  if (folder_.empty()) return nullptr;
  const fs::path path = file(shape, worldOrigin);
  auto field = readField(path, shape, path.stem().string());
  std::error_code ignored;  // of a folder that may not be written, or a file that is gone
  if (field != nullptr) fs::last_write_time(path, fs::file_time_type::clock::now(), ignored);
  return field;
}

void FieldCache::store(const DistanceField& field, const Vec3d& worldOrigin) const {
  if (folder_.empty()) return;
  const fs::path path = file(field.shape, worldOrigin);
  const FieldFileHeader header = headerOf(field, path.stem().string());
  std::uint64_t size = sizeof header + kHashSize;
  forArrays(field, [&](const auto& array) { size += bytesOf(array).size(); });
  if (size > kCacheBytes) return;
  const std::string hash = slicesHash(header, field, [](const char*, std::size_t, std::uint64_t) { return true; });
  // One at a time: threads of one process share the temporary's name. Processes do not; where containers share a folder
  // and a number, the hash tells what became of it.
  static std::mutex mutex;
  const std::scoped_lock lock(mutex);
  std::error_code failure;
  fs::create_directories(folder_, failure);
  if (failure) {
    warn(fmt::format("fields are not kept from run to run: {}: cannot be made: {}{}", folder_.string(),
                     failure.message(), kRemedy));
    return;
  }
  try {
    AtomicFile out(path);
    out.write(bytesOf(header));
    forArrays(field, [&](const auto& array) { out.write(bytesOf(array)); });
    out.write(hash);
    out.commit();
  } catch (const Error& error) {
    warn(fmt::format("fields are not kept from run to run: {}{}", error.what(), kRemedy));
    return;
  }
  evict(folder_, path);
}

std::string geometryHash(const Scene& scene) {
  std::vector<std::string> meshes(scene.meshes.size());
  parallelFor(meshes.size(), 1, [&](std::size_t first, std::size_t last) {
    for (std::size_t m = first; m < last; ++m) meshes[m] = meshHash(scene, scene.meshes[m]);
  });
  Sha256 hash;
  for (const Instance& instance : scene.instances) {
    hash.add(meshes[instance.mesh]);
    const Affine& place = instance.worldFromMesh;
    for (const Vec3d& column : {place.linear.x, place.linear.y, place.linear.z, place.translation}) {
      addBytes(hash, column);
    }
    addBytes(hash, instance.firstInstanceId);
  }
  return hash.hex();
}

fs::path defaultCacheFolder() {
  // A relative $XDG_CACHE_HOME is to be ignored (XDG Base Directory Specification).
  for (const auto& [variable, below] : {std::pair{"XDG_CACHE_HOME", ""}, std::pair{"HOME", ".cache"}}) {
    const char* folder = std::getenv(variable);
    if (folder != nullptr && fs::path(folder).is_absolute()) return fs::path(folder) / below / "scanmill" / "fields";
  }
  return {};
}

}  // namespace scanmill
