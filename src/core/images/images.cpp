#include "images/images.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <memory>
#include <new>
#include <system_error>
#include <utility>

#include "base/error.h"
#include "base/file.h"
#include "images/loader.h"
#include "images/png_chunks.h"

namespace scanmill {

namespace {

constexpr int kMaxSize = 16384;

// The kinds that image bytes are recognised by; anything else is left to the name.
std::string kindOf(std::string_view bytes) {
  const auto starts = [&](std::string_view magic, std::size_t at = 0) {
    return bytes.size() >= at + magic.size() && bytes.substr(at, magic.size()) == magic;
  };
  if (starts("\x89PNG")) return "png";
  if (starts("\xff\xd8\xff")) return "jpg";
  if (starts("RIFF") && starts("WEBP", 8)) return "webp";
  if (starts("BM")) return "bmp";
  if (starts("GIF8")) return "gif";
  if (starts("DDS ")) return "dds";
  if (starts("\x01\xda")) return "sgi";
  if (starts("\x76\x2f\x31\x01")) return "exr";
  if (starts(std::string_view("II*\0", 4)) || starts(std::string_view("MM\0*", 4))) return "tif";
  return {};
}

// The module's words on one line, or `otherwise` where it has none.
std::string reason(const ScanmillImageError& error, const char* otherwise = "not an image that can be decoded") {
  std::string text = error.text;
  while (!text.empty() && (text.back() == '\n' || text.back() == '.')) text.pop_back();
  std::replace(text.begin(), text.end(), '\n', ' ');
  return text.empty() ? otherwise : text;
}

struct Closer {
  void operator()(ScanmillImageReader* reader) const { imagesModule().close(reader); }
};

struct OpenImage {
  std::unique_ptr<ScanmillImageReader, Closer> reader;  // null where it cannot be opened
  ScanmillImageInfo info{};
  ScanmillImageError error{};
};

// The bytes, of the kind that `name` ends with, or without bytes the file of that name.
OpenImage openImage(const std::string& name, std::string_view bytes = {}) {
  OpenImage image;
  ScanmillImageReader* reader = nullptr;
  const auto status = imagesModule().open(name.c_str(), bytes.data(), bytes.size(), &reader, &image.info, &image.error);
  if (status == kScanmillImageOutOfMemory) throw std::bad_alloc();
  image.reader.reset(reader);
  return image;
}

// By what an 8-bit colour that was multiplied by each alpha is multiplied to undo it.
std::array<float, 256> divisionByAlpha(double gamma) {
  std::array<float, 256> gain{};
  for (std::size_t i = 1; i < gain.size(); ++i) {
    gain[i] = static_cast<float>(std::pow(255.0 / static_cast<double>(i), 1.0 / gamma));
  }
  return gain;
}

DecodedImage decode(const OpenImage& image, const std::string& name) {
  const ScanmillImageInfo& info = image.info;
  const auto fail = [&](const std::string& what) { return InputError({name}, what); };
  if (!image.reader) throw fail("the image cannot be read: " + reason(image.error));
  if (info.width < 1 || info.height < 1 || info.channels < 1) throw fail("the image has no pixels");
  if (info.width > kMaxSize || info.height > kMaxSize) {
    throw fail(fmt::format("the image of {} x {} pixels is larger than {} x {}: scale it down", info.width, info.height,
                           kMaxSize, kMaxSize));
  }
  const int channels = info.channels;
  const int alpha = info.alphaChannel;
  const int colors = alpha >= 0 ? alpha : channels;  // alpha comes after the colours
  const std::array<int, 3> from = colors >= 3 ? std::array{0, 1, 2} : std::array{0, 0, 0};

  const std::size_t count = static_cast<std::size_t>(info.width) * static_cast<std::size_t>(info.height);
  std::vector<std::uint8_t> pixels(count * static_cast<std::size_t>(channels));
  ScanmillImageError error{};
  const auto status = imagesModule().read(image.reader.get(), pixels.data(), &error);
  if (status == kScanmillImageOutOfMemory) throw std::bad_alloc();
  if (status != kScanmillImageDone) throw fail("the image cannot be decoded: " + reason(error));

  const bool multiplied = info.alphaGamma > 0;
  const auto gain = divisionByAlpha(multiplied ? info.alphaGamma : 1.0);
  DecodedImage decoded;
  decoded.width = static_cast<std::uint32_t>(info.width);
  decoded.height = static_cast<std::uint32_t>(info.height);
  decoded.rgba.resize(count * 4);
  std::uint8_t least = 255;
  const std::uint8_t* in = pixels.data();
  std::uint8_t* out = decoded.rgba.data();
  for (std::size_t i = 0; i < count; ++i, in += channels, out += 4) {
    out[0] = in[from[0]];
    out[1] = in[from[1]];
    out[2] = in[from[2]];
    out[3] = alpha >= 0 ? in[alpha] : std::uint8_t{255};
    least = std::min(least, out[3]);
    for (int c = 0; multiplied && c < 3; ++c) {
      out[c] = static_cast<std::uint8_t>(std::min(255.0f, static_cast<float>(out[c]) * gain[out[3]] + 0.5f));
    }
  }
  decoded.hasAlpha = least < 255;
  return decoded;
}

}  // namespace

DecodedImage decodeImage(std::string_view bytes, const std::string& name) {
  if (bytes.empty()) throw InputError({name}, "the image is empty");
  const std::string kind = kindOf(bytes);
  const std::string hint = kind.empty() ? name : "embedded." + kind;
  const std::string png = kind == "png" ? plainPng(bytes, name) : std::string();
  return decode(openImage(hint, kind == "png" ? png : bytes), name);
}

DecodedImage readImage(const std::filesystem::path& path) {
  const std::string name = path.string();
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) throw InputError({name}, "there is no such image");
  std::string magic(4, '\0');
  std::ifstream(path, std::ios::binary).read(magic.data(), 4);
  if (kindOf(magic) == "png") return decodeImage(readFile(path), name);
  return decode(openImage(name), name);
}

bool mayHaveAlpha(const std::filesystem::path& path) {
  const OpenImage image = openImage(path.string());
  return !image.reader || image.info.alphaChannel >= 0;
}

std::string encodePng(const std::uint8_t* rgb, int width, int height) {
  const ScanmillImagesModule& module = imagesModule();
  ScanmillImageBytes png{};
  ScanmillImageError error{};
  const auto status = module.encodePng(rgb, width, height, &png, &error);
  if (status == kScanmillImageOutOfMemory) throw std::bad_alloc();
  if (status != kScanmillImageDone)
    throw Error("the PNG could not be encoded: " + reason(error, "OpenImageIO says no more"));
  const auto release = [&](ScanmillImageBytes* bytes) { module.release(bytes); };
  const std::unique_ptr<ScanmillImageBytes, decltype(release)> owner(&png, release);
  return {png.data, png.size};
}

}  // namespace scanmill
