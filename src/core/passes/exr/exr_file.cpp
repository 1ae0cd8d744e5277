#include "passes/exr/exr_file.h"

#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfDoubleAttribute.h>
#include <OpenEXR/ImfFloatAttribute.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfIO.h>
#include <OpenEXR/ImfInputPart.h>
#include <OpenEXR/ImfMatrixAttribute.h>
#include <OpenEXR/ImfMultiPartInputFile.h>
#include <OpenEXR/ImfOutputFile.h>
#include <OpenEXR/ImfPartType.h>
#include <OpenEXR/ImfStdIO.h>
#include <OpenEXR/ImfStringAttribute.h>
#include <OpenEXR/ImfTileDescription.h>
#include <OpenEXR/ImfVecAttribute.h>
#include <OpenEXR/ImfVersion.h>
#include <fmt/core.h>

#include <algorithm>
#include <bit>
#include <cstring>
#include <iterator>
#include <optional>
#include <stdexcept>
#include <tuple>

#include "base/error.h"
#include "base/file.h"
#include "base/parallel.h"
#include "formats/little_endian.h"

namespace scanmill {

namespace {

// Limits of the images that are read, so that no file can make OpenEXR allocate more memory than a LiDAR image needs.
constexpr std::int64_t kMostAcross = 65536;                    // px, largest width and height of an image
constexpr std::uint64_t kMostPixels = std::uint64_t{1} << 28;  // 268 million
constexpr std::uint64_t kMostTilePixels = std::uint64_t{1} << 24;
// Upper bound of OpenEXR's lossless compression ratio: deflate's matches of 2 bits or more encode up to 258 bytes.
constexpr std::uint64_t kMostGain = 1100;
constexpr std::size_t kBandBytes = std::size_t{1} << 20;  // size of a band of rows; 32 rows or a tile may exceed it

// A stream of encoded bytes for OpenEXR. Several streams may read the same bytes.
class MemoryInput : public Imf::IStream {
 public:
  MemoryInput(const char* name, std::string_view bytes) : Imf::IStream(name), bytes_(bytes) {}
  bool read(char data[], int count) override {
    const auto size = static_cast<std::size_t>(count);
    if (position_ > bytes_.size() || bytes_.size() - position_ < size) throw std::runtime_error("the file ends early");
    std::memcpy(data, bytes_.data() + position_, size);
    position_ += size;
    return position_ < bytes_.size();
  }
  std::uint64_t tellg() override { return position_; }
  void seekg(std::uint64_t position) override { position_ = position; }

 private:
  std::string_view bytes_;
  std::uint64_t position_ = 0;
};

[[noreturn]] void refuseDamage(const std::string& name, std::string_view what) {
  throw InputError({name}, "is damaged or truncated ({}): write it again", what);
}

// Checks a file's headers before OpenEXR reads them, because OpenEXR allocates as much memory as an attribute asks for.
class HeaderCheck {
 public:
  HeaderCheck(const std::string& name, std::string_view bytes) : name_(name), unread_(bytes) {}

  // Throws InputError if the file is not EXR or an attribute is longer than the file.
  void run() {
    constexpr std::string_view kMagic("\x76\x2f\x31\x01", 4);
    if (!unread_.starts_with(kMagic)) throw InputError({name_}, "is not an OpenEXR file");
    take(4);
    const std::uint32_t version = readInteger();
    // A file of several parts has a header for each part, and an empty header at the end.
    const bool hasSeveralParts = Imf::isMultiPart(static_cast<int>(version));
    while (skipAttribute()) {
      while (skipAttribute()) continue;
      if (!hasSeveralParts) return;
    }
  }

 private:
  std::string_view take(std::size_t count) {
    if (unread_.size() < count) refuseDamage(name_, "its header is cut off");
    const std::string_view bytes = unread_.substr(0, count);
    unread_.remove_prefix(count);
    return bytes;
  }

  std::uint32_t readInteger() { return numberAt<std::uint32_t>(take(4), 0); }

  std::string_view readText() {
    constexpr std::size_t kLongestName = 255;  // bytes, in files with long names
    const std::size_t end = unread_.substr(0, kLongestName + 1).find('\0');
    if (end == unread_.npos) refuseDamage(name_, "a name in its header does not end");
    const std::string_view text = take(end);
    take(1);
    return text;
  }

  // Skips an attribute: name, type, size and value. Returns false at the end of a header, which is an empty name.
  bool skipAttribute() {
    const std::string_view attributeName = readText();
    if (attributeName.empty()) return false;
    readText();
    const std::uint32_t size = readInteger();
    if (size > unread_.size()) {
      refuseDamage(name_, fmt::format("its attribute '{}' claims {} bytes", attributeName, size));
    }
    take(size);
    return true;
  }

  const std::string& name_;
  std::string_view unread_;
};

template <std::size_t N, class Matrix>
std::array<double, N> rowByRow(const Matrix& matrix) {
  std::array<double, N> rows;
  const auto* first = matrix.getValue();
  std::copy(first, first + N, rows.begin());
  return rows;
}

// Returns the value of an attribute; std::monostate if ExrValue has no alternative for the attribute's type.
ExrValue valueOf(const Imf::Attribute& attribute) {
  if (const auto* text = dynamic_cast<const Imf::StringAttribute*>(&attribute)) return text->value();
  if (const auto* d = dynamic_cast<const Imf::DoubleAttribute*>(&attribute)) return d->value();
  if (const auto* f = dynamic_cast<const Imf::FloatAttribute*>(&attribute)) return double{f->value()};
  if (const auto* v = dynamic_cast<const Imf::V3dAttribute*>(&attribute)) {
    return Vec3d{v->value().x, v->value().y, v->value().z};
  }
  if (const auto* m = dynamic_cast<const Imf::M33dAttribute*>(&attribute)) return rowByRow<9>(m->value());
  if (const auto* m = dynamic_cast<const Imf::M33fAttribute*>(&attribute)) return rowByRow<9>(m->value());
  if (const auto* m = dynamic_cast<const Imf::M44dAttribute*>(&attribute)) return rowByRow<16>(m->value());
  if (const auto* m = dynamic_cast<const Imf::M44fAttribute*>(&attribute)) return rowByRow<16>(m->value());
  return {};
}

void requireLossless(const std::string& name, Imf::Compression compression) {
  constexpr Imf::Compression kLossless[] = {Imf::NO_COMPRESSION, Imf::RLE_COMPRESSION, Imf::ZIPS_COMPRESSION,
                                            Imf::ZIP_COMPRESSION, Imf::PIZ_COMPRESSION};
  if (std::ranges::find(kLossless, compression) != std::end(kLossless)) return;
  throw InputError({name},
                   "is compressed by PXR24, B44 or DWA, which do not keep every bit: write it with ZIP, ZIPS, PIZ, "
                   "RLE or no compression");
}

std::string windowText(const Imath::Box2i& box) {
  return fmt::format("({}, {}) to ({}, {})", box.min.x, box.min.y, box.max.x, box.max.y);
}

// Returns the width and height (px) of a box with any 32-bit corners. Throws InputError for too large or empty boxes.
std::pair<std::uint32_t, std::uint32_t> sizeOf(const std::string& name, const Imath::Box2i& box) {
  const std::int64_t width = std::int64_t{box.max.x} - box.min.x + 1;
  const std::int64_t height = std::int64_t{box.max.y} - box.min.y + 1;
  if (width < 1 || height < 1 || width > kMostAcross || height > kMostAcross ||
      static_cast<std::uint64_t>(width * height) > kMostPixels) {
    throw InputError({name}, "its data window is {} x {} pixels: at most {} x {} and {} million in all are read", width,
                     height, kMostAcross, kMostAcross, kMostPixels / 1'000'000);
  }
  return {static_cast<std::uint32_t>(width), static_cast<std::uint32_t>(height)};
}

// Reads rows [first, end) of the targets, all of which belong to part `part`.
void readRows(Imf::MultiPartInputFile& file, int part, std::span<const ExrTarget> targets, std::size_t first,
              std::size_t end) {
  const Imath::Box2i window = file.header(part).dataWindow();
  const auto width = static_cast<std::size_t>(window.max.x - window.min.x) + 1;
  Imf::FrameBuffer frame;
  for (const ExrTarget& target : targets) {
    const Imf::PixelType type = target.channel->type == ExrType::Uint32 ? Imf::UINT : Imf::FLOAT;
    frame.insert(target.channel->nameInPart,
                 Imf::Slice::Make(type, target.pixels, window, target.stride, target.stride * width));
  }
  Imf::InputPart input(file, part);
  input.setFrameBuffer(frame);
  input.readPixels(window.min.y + static_cast<int>(first), window.min.y + static_cast<int>(end) - 1);
}

// Returns true if copyRows() can read a part: scan lines of uncompressed 4-byte values, on a little-endian CPU.
bool isPlain(const Imf::Header& header) {
  if (header.hasTileDescription() || header.compression() != Imf::NO_COMPRESSION) return false;
  for (auto channel = header.channels().begin(); channel != header.channels().end(); ++channel) {
    if (channel.channel().type == Imf::HALF) return false;
  }
  return std::endian::native == std::endian::little;
}

// Reads the same rows as readRows(), but faster, from a part for which isPlain() is true. OpenEXR decodes pixel by
// pixel, which would take a third of the time of making scans from stored hits.
void copyRows(Imf::MultiPartInputFile& file, int part, std::span<const ExrTarget> targets, std::size_t first,
              std::size_t end) {
  const Imf::Header& header = file.header(part);
  const Imath::Box2i window = header.dataWindow();
  const auto width = static_cast<std::size_t>(window.max.x - window.min.x) + 1;
  std::vector<std::string> names;  // names of the channels, in the order in which a line stores them
  for (auto channel = header.channels().begin(); channel != header.channels().end(); ++channel) {
    names.emplace_back(channel.name());
  }
  Imf::InputPart input(file, part);
  for (std::size_t row = first; row < end; ++row) {
    const char* line = nullptr;
    int size = 0;
    input.rawPixelData(window.min.y + static_cast<int>(row), line, size);
    if (static_cast<std::size_t>(size) != 4 * width * names.size()) throw std::runtime_error("a line is cut short");
    for (const ExrTarget& target : targets) {
      const auto channel = std::ranges::find(names, target.channel->nameInPart) - names.begin();
      const char* const source = line + 4 * width * static_cast<std::size_t>(channel);
      char* const destination = static_cast<char*>(target.pixels) + row * width * target.stride;
      if (target.stride == 4) {
        std::memcpy(destination, source, 4 * width);
        continue;
      }
      for (std::size_t i = 0; i < width; ++i) std::memcpy(destination + i * target.stride, source + 4 * i, 4);
    }
  }
}

// Calls `work` and turns all exceptions of OpenEXR into an InputError that names the file.
template <class Work>
void guarded(const std::string& name, Work&& work) {
  try {
    work();
  } catch (const Error&) {
    throw;
  } catch (const std::exception& error) {
    refuseDamage(name, reasonOf(error));
  }
}

// Throws InputError if a part's image is cropped, or if its window differs from `firstPart`, the window of the file's
// first part (nothing if this is the first part).
void requireWindow(const std::string& name, const Imf::Header& header, const std::optional<Imath::Box2i>& firstPart) {
  const Imath::Box2i& data = header.dataWindow();
  if (data != header.displayWindow()) {
    throw InputError({name},
                     "its data window {} is not its display window {}: render the whole image, "
                     "without crop or overscan",
                     windowText(data), windowText(header.displayWindow()));
  }
  if (firstPart && data != *firstPart) {
    throw InputError({name}, "its parts differ in size, {} and {}: write all passes of a camera with the same size",
                     windowText(*firstPart), windowText(data));
  }
}

// Returns the number of rows of a part's tiles, 1 for scan lines. Throws InputError if the tiles are too large.
std::uint32_t rowsDecodedTogether(const std::string& name, const Imf::Header& header) {
  if (!header.hasTileDescription()) return 1;
  const Imf::TileDescription& tile = header.tileDescription();
  if (std::uint64_t{tile.xSize} * tile.ySize > kMostTilePixels) {
    throw InputError({name}, "its tiles of {} x {} pixels are too large: write scan lines", tile.xSize, tile.ySize);
  }
  return tile.ySize;
}

// Returns the channels of a part of a file. Throws InputError if a channel is subsampled.
std::vector<ExrChannel> channelsOf(const std::string& name, const Imf::MultiPartInputFile& file, int part) {
  const Imf::Header& header = file.header(part);
  const std::string prefix = file.parts() > 1 && header.hasName() ? header.name() + "." : "";
  std::vector<ExrChannel> channels;
  for (auto entry = header.channels().begin(); entry != header.channels().end(); ++entry) {
    const Imf::Channel& channel = entry.channel();
    const ExrType type = channel.type == Imf::UINT   ? ExrType::Uint32
                         : channel.type == Imf::HALF ? ExrType::Float16
                                                     : ExrType::Float32;
    channels.push_back({prefix + entry.name(), type, part, entry.name()});
    if (channel.xSampling == 1 && channel.ySampling == 1) continue;
    throw InputError({name}, "channel '{}': has fewer samples than the image has pixels: write every pixel",
                     channels.back().name);
  }
  return channels;
}

// Adds an attribute of the value's type to a header. Adds nothing for std::monostate.
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

ExrReader::ExrReader(const std::filesystem::path& path) : name_(path.string()), bytes_(readFile(path)) {
  HeaderCheck(name_, bytes_).run();
  guarded(name_, [&] {
    MemoryInput stream(name_.c_str(), bytes_);
    const Imf::MultiPartInputFile file(stream, 0);
    std::optional<Imath::Box2i> window;
    for (int part = 0; part < file.parts(); ++part) {
      const Imf::Header& header = file.header(part);
      if (header.hasType() && Imf::isDeepData(header.type())) continue;
      requireLossless(name_, header.compression());
      std::tie(width_, height_) = sizeOf(name_, header.dataWindow());
      requireWindow(name_, header, window);
      window = header.dataWindow();
      bandRows_ = std::max(bandRows_, rowsDecodedTogether(name_, header));
      std::ranges::move(channelsOf(name_, file, part), std::back_inserter(channels_));
      for (auto attribute = header.begin(); attribute != header.end(); ++attribute) {
        attributes_.emplace(attribute.name(), valueOf(attribute.attribute()));
      }
    }
    if (!window) throw InputError({name_}, "holds deep pixels: write flat ones, one surface per pixel");
    std::uint64_t bytesPerPixel = 0;
    for (const ExrChannel& channel : channels_) bytesPerPixel += channel.type == ExrType::Float16 ? 2 : 4;
    if (bytesPerPixel * pixels() / kMostGain > bytes_.size()) {
      refuseDamage(name_, fmt::format("{} bytes cannot hold {} x {} pixels of {} channels", bytes_.size(), width_,
                                      height_, channels_.size()));
    }
    const std::uint64_t bandPixels = kBandBytes / std::max<std::uint64_t>(bytesPerPixel, 1);
    const auto bands = static_cast<std::uint32_t>(bandPixels / width_ / bandRows_);
    bandRows_ *= std::max(bands, 1u);
  });
}

const ExrChannel* ExrReader::find(std::string_view channelName) const {
  const auto channel = std::ranges::find(channels_, channelName, &ExrChannel::name);
  return channel == channels_.end() ? nullptr : &*channel;
}

const ExrValue* ExrReader::attribute(const std::string& attributeName) const {
  const auto attribute = attributes_.find(attributeName);
  return attribute == attributes_.end() ? nullptr : &attribute->second;
}

void ExrReader::read(std::span<const ExrTarget> targets) const {
  // Each thread decodes different rows, with a reader of its own.
  const std::size_t bands = (height_ - 1) / bandRows_ + 1;
  parallelFor(bands, 1, [&](std::size_t firstBand, std::size_t endBand) {
    guarded(name_, [&] {
      MemoryInput stream(name_.c_str(), bytes_);
      Imf::MultiPartInputFile file(stream, 0);
      const std::size_t first = firstBand * bandRows_;
      const std::size_t end = std::min<std::size_t>(endBand * bandRows_, height_);
      for (int part = 0; part < file.parts(); ++part) {
        std::vector<ExrTarget> targetsOfPart;
        std::ranges::copy_if(targets, std::back_inserter(targetsOfPart),
                             [&](const ExrTarget& target) { return target.channel->part == part; });
        if (targetsOfPart.empty()) continue;
        (isPlain(file.header(part)) ? copyRows : readRows)(file, part, targetsOfPart, first, end);
      }
    });
  });
}

std::string_view exrTypeName(ExrType type) {
  return type == ExrType::Uint32 ? "UINT" : type == ExrType::Float16 ? "HALF" : "FLOAT";
}

void writeExr(const std::filesystem::path& path, std::uint32_t width, std::uint32_t height,
              const ExrAttributes& attributes, std::span<const ExrPlane> planes, ExrCompression compression) {
  if (width == 0 || height == 0) throw Error("{}: an image without pixels cannot be written", path.string());
  AtomicFile file(path);
  Imf::StdOSStream stream;  // in memory: OpenEXR seeks back to fill in offsets of lines, and AtomicFile cannot seek
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
    throw Error("{}: cannot be written as EXR: {}", path.string(), reasonOf(error));
  }
  file.write(stream.str());
  file.commit();
}

}  // namespace scanmill
