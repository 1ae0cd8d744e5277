#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfDoubleAttribute.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfIO.h>
#include <OpenEXR/ImfMatrixAttribute.h>
#include <OpenEXR/ImfOutputFile.h>
#include <OpenEXR/ImfStringAttribute.h>
#include <OpenEXR/ImfVecAttribute.h>
#include <fmt/core.h>

#include <cstring>

#include "base/error.h"
#include "base/file.h"
#include "passes/exr/exr_file.h"

namespace scanmill {

namespace {

// Buffers the file in memory, because OpenEXR seeks back to fill in the offsets of the lines, and AtomicFile cannot
// seek.
class MemoryOutput : public Imf::OStream {
 public:
  explicit MemoryOutput(const char* name) : Imf::OStream(name) {}
  void write(const char data[], int count) override {
    const auto size = static_cast<std::size_t>(count);
    if (bytes_.size() < position_ + size) bytes_.resize(position_ + size);
    std::memcpy(bytes_.data() + position_, data, size);
    position_ += size;
  }
  std::uint64_t tellp() override { return position_; }
  void seekp(std::uint64_t position) override { position_ = position; }
  const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_;
  std::size_t position_ = 0;
};

// Adds an attribute of the value's type to a header; none for std::monostate.
void addAttribute(Imf::Header& header, const std::string& name, const ExrValue& value) {
  if (const auto* text = std::get_if<std::string>(&value)) {
    header.insert(name, Imf::StringAttribute(*text));
  } else if (const auto* number = std::get_if<double>(&value)) {
    header.insert(name, Imf::DoubleAttribute(*number));
  } else if (const auto* v = std::get_if<Vec3d>(&value)) {
    header.insert(name, Imf::V3dAttribute({v->x, v->y, v->z}));
  } else if (const auto* m3 = std::get_if<ExrMatrix3>(&value)) {
    Imath::M33d matrix;
    std::memcpy(matrix.x, m3->data(), sizeof matrix.x);
    header.insert(name, Imf::M33dAttribute(matrix));
  } else if (const auto* m4 = std::get_if<ExrMatrix4>(&value)) {
    Imath::M44d matrix;
    std::memcpy(matrix.x, m4->data(), sizeof matrix.x);
    header.insert(name, Imf::M44dAttribute(matrix));
  }
}

// zlib's fastest level. 2048 x 2048 pixels of depth, normal and two ids (101 MB uncompressed) take 0.24 s and 5.3 MB;
// level 4 takes 0.38 s and 4.2 MB, level 6 takes 0.65 s and 4.1 MB.
constexpr int kZipLevel = 1;

}  // namespace

std::string_view exrTypeName(ExrType type) {
  return type == ExrType::Uint32 ? "UINT" : type == ExrType::Float16 ? "HALF" : "FLOAT";
}

void writeExr(const std::filesystem::path& path, std::uint32_t width, std::uint32_t height,
              const ExrAttributes& attributes, std::span<const ExrPlane> planes, ExrCompression compression) {
  if (width == 0 || height == 0)
    throw Error(fmt::format("{}: an image without pixels cannot be written", path.string()));
  AtomicFile file(path);
  MemoryOutput stream(path.c_str());
  try {
    Imf::Header header(static_cast<int>(width), static_cast<int>(height));
    header.compression() = compression == ExrCompression::Zip ? Imf::ZIP_COMPRESSION : Imf::NO_COMPRESSION;
    header.zipCompressionLevel() = kZipLevel;
    Imf::FrameBuffer frame;
    for (const ExrPlane& plane : planes) {
      const Imf::PixelType type = plane.type == ExrType::Uint32 ? Imf::UINT : Imf::FLOAT;
      header.channels().insert(plane.channel, Imf::Channel(type));
      // OpenEXR uses the same non-const pointer type for reading and for writing.
      auto* pixels = static_cast<char*>(const_cast<void*>(plane.pixels));
      frame.insert(plane.channel, Imf::Slice(type, pixels, plane.stride, plane.stride * width));
    }
    for (const auto& [name, value] : attributes) addAttribute(header, name, value);
    Imf::OutputFile out(stream, header, 0);
    out.setFrameBuffer(frame);
    out.writePixels(static_cast<int>(height));
  } catch (const std::exception& error) {
    throw Error(fmt::format("{}: cannot be written as EXR: {}", path.string(), reasonOf(error)));
  }
  file.write(stream.bytes());
  file.commit();
}

}  // namespace scanmill
