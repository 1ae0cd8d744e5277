#include "dataset/voxels.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <utility>

#include "base/error.h"
#include "formats/little_endian.h"
#include "formats/npy.h"

namespace scanmill {

namespace {

constexpr const char* kUInt16 = "<u2";
constexpr const char* kFloat64 = "<f8";
constexpr const char* kBool = "|b1";

// The arrays of an archive, found by their names. Throws InputError if an array is missing or unsuitable.
class VoxelArrays {
 public:
  VoxelArrays(std::string_view bytes, const std::string& what) : what_(what), arrays_(readNpzArrays(bytes, what)) {}

  // Returns the array with this name. `type`, `dimensions`: its required NumPy type, such as "<u2", and dimensions.
  const NpyArray& array(std::string_view name, std::string_view type, std::size_t dimensions) const {
    const auto array = std::ranges::find(arrays_, name, &NpyArray::name);
    if (array == arrays_.end()) fail("has no array `{}`", name);
    if (array->type != type || array->shape.size() != dimensions) {
      fail("{} has the type {} and {} dimensions, but must have {} and {}", name, array->type, array->shape.size(),
           type, dimensions);
    }
    return *array;
  }

  // Returns the elements of a float64 array, which must consist of `count` finite numbers.
  std::vector<double> numbers(std::string_view name, std::size_t dimensions, std::size_t count) const {
    const std::string_view bytes = array(name, kFloat64, dimensions).bytes;
    std::vector<double> values(bytes.size() / sizeof(double));
    if (values.size() != count) fail("{} has {} numbers, but must have {}", name, values.size(), count);
    std::memcpy(values.data(), bytes.data(), bytes.size());
    if (!std::ranges::all_of(values, [](double v) { return std::isfinite(v); })) {
      fail("{} has values that are not finite", name);
    }
    return values;
  }

  // Returns the flags of an array, each 0 or 1. `shape`, `voxels`: shape and size of the array `label`.
  std::vector<std::uint8_t> flags(std::string_view name, const std::vector<std::size_t>& shape,
                                  std::size_t voxels) const {
    const NpyArray& flagArray = array(name, kBool, shape.size());
    if (flagArray.shape != shape || flagArray.bytes.size() != voxels) fail("{} and label have different sizes", name);
    std::vector<std::uint8_t> flags(flagArray.bytes.begin(), flagArray.bytes.end());
    if (std::ranges::any_of(flags, [](std::uint8_t f) { return f > 1; })) {
      fail("{} has values besides 0 and 1", name);
    }
    return flags;
  }

  template <class... Values>
  [[noreturn]] void fail(fmt::format_string<Values...> reason, Values&&... values) const {
    throw InputError({what_}, fmt::format(reason, std::forward<Values>(values)...));
  }

 private:
  std::string what_;
  std::vector<NpyArray> arrays_;
};

}  // namespace

std::string encodeVoxels(const ScanVoxels& voxels) {
  const VoxelGrid& grid = voxels.grid;
  const std::vector<std::size_t> shape{grid.counts[0], grid.counts[1], grid.counts[2]};
  std::vector<std::pair<std::string, std::string>> files;
  const auto add = [&](std::string_view name, const char* type, const std::vector<std::size_t>& arrayShape,
                       std::string_view bytes) {
    files.emplace_back(std::string(name) + ".npy", npyOf(type, arrayShape, bytes));
  };
  const auto addFlags = [&](std::string_view name, const std::vector<std::uint8_t>& flags) {
    add(name, kBool, shape, {reinterpret_cast<const char*>(flags.data()), flags.size()});
  };
  add("label", kUInt16, shape, {reinterpret_cast<const char*>(voxels.label.data()), 2 * voxels.label.size()});
  addFlags("input", voxels.input);
  addFlags("invalid", voxels.invalid);
  addFlags("unseen", voxels.unseen);
  std::string low;
  for (const double value : {grid.low.x, grid.low.y, grid.low.z}) putNumber(value, low);
  add("low", kFloat64, {3}, low);
  std::string size;
  putNumber(grid.size, size);
  add("size", kFloat64, {}, size);
  return zipOf(files);
}

ScanVoxels decodeVoxels(std::string_view bytes, const std::string& what) {
  const VoxelArrays arrays(bytes, what);
  ScanVoxels voxels;
  voxels.grid.size = arrays.numbers("size", 0, 1).front();
  if (!(voxels.grid.size > 0)) arrays.fail("size is not above 0");
  const std::vector<double> low = arrays.numbers("low", 1, 3);
  voxels.grid.low = {low[0], low[1], low[2]};
  const NpyArray& label = arrays.array("label", kUInt16, 3);
  constexpr std::size_t kMostVoxels = std::numeric_limits<std::uint32_t>::max();
  if (std::ranges::any_of(label.shape, [](std::size_t count) { return count == 0 || count > kMostVoxels; }) ||
      label.bytes.size() / sizeof(std::uint16_t) > kMostVoxels) {
    arrays.fail("label has no voxels, or more than 2^32");
  }
  for (std::size_t axis = 0; axis < 3; ++axis) {
    voxels.grid.counts[axis] = static_cast<std::uint32_t>(label.shape[axis]);
  }
  voxels.label.resize(voxels.grid.voxels());
  std::memcpy(voxels.label.data(), label.bytes.data(), label.bytes.size());
  voxels.input = arrays.flags("input", label.shape, voxels.label.size());
  voxels.invalid = arrays.flags("invalid", label.shape, voxels.label.size());
  voxels.unseen = arrays.flags("unseen", label.shape, voxels.label.size());
  return voxels;
}

std::vector<std::uint8_t> occludedVoxels(const ScanVoxels& voxels) {
  const VoxelGrid& grid = voxels.grid;
  const Vec3d sensor = grid.inVoxels({});
  const auto isInside = [](double coordinate, std::uint32_t count) { return coordinate >= 0 && coordinate < count; };
  // Returns true if a voxel that is not empty lies between `center`, a voxel's centre (in voxels), and the sensor. Each
  // step towards the sensor is one voxel along the line's longest axis, and at most one along the other axes.
  const auto isOccluded = [&](const Vec3d& center) {
    const Vec3d toSensor = sensor - center;
    const double steps = std::max({std::fabs(toSensor.x), std::fabs(toSensor.y), std::fabs(toSensor.z)});
    const Vec3d step = toSensor * (1 / steps);
    Vec3d position = center;
    const int stepsBefore = static_cast<int>(std::ceil(steps)) - 1;  // excludes the sensor's voxel
    for (int i = 0; i < stepsBefore; ++i) {
      position += step;
      // The grid is convex, so a line that leaves it does not enter it again.
      if (!isInside(position.x, grid.counts[0]) || !isInside(position.y, grid.counts[1]) ||
          !isInside(position.z, grid.counts[2]))
        return false;
      const std::size_t voxel =
          grid.index(static_cast<std::uint32_t>(position.x), static_cast<std::uint32_t>(position.y),
                     static_cast<std::uint32_t>(position.z));
      if (voxels.label[voxel] != 0 || voxels.input[voxel] != 0) return true;
    }
    return false;
  };
  std::vector<std::uint8_t> occluded(grid.voxels(), 0);
  for (std::uint32_t x = 0; x < grid.counts[0]; ++x) {
    for (std::uint32_t y = 0; y < grid.counts[1]; ++y) {
      for (std::uint32_t z = 0; z < grid.counts[2]; ++z) {
        occluded[grid.index(x, y, z)] = isOccluded({x + 0.5, y + 0.5, z + 0.5}) ? 1 : 0;
      }
    }
  }
  return occluded;
}

std::uint64_t mostVoxelsBytes(const VoxelGrid& grid) {
  constexpr std::uint64_t kBytesPerVoxel = sizeof(std::uint16_t) + 3;  // label and three flags
  constexpr std::uint64_t kHeaderBytes = 4096;                         // more than all headers of the archive
  const std::uint64_t uncompressed = std::uint64_t{grid.voxels()} * kBytesPerVoxel;
  // Deflate stores incompressible bytes unchanged, in blocks. Their headers add far less than a hundredth of the bytes.
  return uncompressed + uncompressed / 100 + kHeaderBytes;
}

}  // namespace scanmill
