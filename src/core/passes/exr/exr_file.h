#pragma once

// Images of named 32-bit planes with attributes, in OpenEXR files. OpenEXR's own types are used only in exr_file.cpp.

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "base/vec.h"
#include "passes/pass_image.h"

namespace scanmill {

using ExrMatrix3 = std::array<double, 9>;  // row by row
using ExrMatrix4 = std::array<double, 16>;
// The value of an attribute; std::monostate if the program does not read the attribute's type. Numbers and matrices of
// float32 and of double are both read as double.
using ExrValue = std::variant<std::monostate, std::string, double, Vec3d, ExrMatrix3, ExrMatrix4>;
using ExrAttributes = std::map<std::string, ExrValue>;

enum class ExrType { Uint32, Float16, Float32 };
std::string_view exrTypeName(ExrType type);  // OpenEXR's names: "UINT", "HALF", "FLOAT"

enum class ExrCompression { None, Zip };

// A plane to write: Uint32 or Float32 values in memory, row by row from the top. `stride`: bytes from pixel to pixel.
struct ExrPlane {
  std::string channel;
  ExrType type = ExrType::Float32;
  const void* pixels = nullptr;
  std::size_t stride = 4;
};

// Writes a file of scan lines, lossless, on the calling thread. The same image always gives the same bytes. The file
// gets its final name only when it is complete. Throws Error.
void writeExr(const std::filesystem::path& path, std::uint32_t width, std::uint32_t height,
              const ExrAttributes& attributes, std::span<const ExrPlane> planes, ExrCompression compression);

// A channel of a file. In a file of several parts, `name` starts with the name of the channel's part.
struct ExrChannel {
  std::string name;
  ExrType type = ExrType::Float32;
  int part = 0;
  std::string nameInPart;
};

// The memory into which a channel's pixels are read: uint32 values for a Uint32 channel, otherwise float values.
struct ExrTarget {
  const ExrChannel* channel = nullptr;
  void* pixels = nullptr;
  std::size_t stride = 4;  // bytes from pixel to pixel
};

// An encoded file in memory. The file may have scan lines or tiles, and one part or several of the same size. Deep
// parts are ignored. All members throw InputError, with the file's name.
class ExrReader {
 public:
  // Throws for files that are not EXR, files that are too short for their images, damaged headers, images that are too
  // large, subsampled channels, and lossy compression. Also throws if the data window is not the display window (crop).
  explicit ExrReader(const std::filesystem::path& path);

  const std::string& name() const { return name_; }  // name of the file, for messages
  std::uint32_t width() const { return width_; }
  std::uint32_t height() const { return height_; }
  std::size_t pixels() const { return std::size_t{width_} * height_; }
  const std::vector<ExrChannel>& channels() const { return channels_; }  // ordered by part, then by name
  // Returns the channel with this name; null if the file has no such channel.
  const ExrChannel* find(std::string_view channelName) const;
  // Returns the attribute from the first part that has it; null if no part has it.
  const ExrValue* attribute(const std::string& attributeName) const;

  // Decodes channels into their targets, on all cores.
  void read(std::span<const ExrTarget> targets) const;

 private:
  std::string name_;
  std::string bytes_;
  std::uint32_t width_ = 0;
  std::uint32_t height_ = 0;
  std::uint32_t bandRows_ = 32;  // number of rows that are decoded together
  std::vector<ExrChannel> channels_;
  ExrAttributes attributes_;
};

// Returns a camera as attributes of a file: see pass_exr.h for their names.
ExrAttributes cameraAttributes(const Camera& camera);

// Returns the camera of a file's image. Throws InputError that names the file and the attribute.
Camera readCamera(const ExrReader& file);

}  // namespace scanmill
