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
#include "images/images_interface.h"
#include "images/png_chunks.h"

namespace scanmill {

namespace {

constexpr int kMaxSize = 16384;

// Recognises the kind of an image by its first bytes; empty where its name has to tell.
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

// What the module says went wrong, on one line, or `otherwise` where it says nothing.
std::string reason(const std::exception& error, const char* otherwise = "not an image that can be decoded") {
  std::string text = error.what();
  while (!text.empty() && (text.back() == '\n' || text.back() == '.')) text.pop_back();
  std::replace(text.begin(), text.end(), '\n', ' ');
  return text.empty() ? otherwise : text;
}

// Opens the bytes, of the kind that `kind` ends with, or without bytes the file of that name. `name` stands for the
// image in messages.
std::unique_ptr<ImageReader> openImage(const std::string& kind, std::string_view bytes, const std::string& name) {
  const auto& module = moduleOf<ImagesModule>();
  try {
    return module.open(kind, bytes);
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception& e) {
    throw InputError({name}, "the image cannot be read: " + reason(e));
  }
}

void readPixels(ImageReader& image, std::uint8_t* pixels, const std::string& name) {
  try {
    image.read(pixels);
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception& e) {
    throw InputError({name}, "the image cannot be decoded: " + reason(e));
  }
}

// The factors that undo the multiplication of an 8-bit colour by each alpha.
std::array<float, 256> divisionByAlpha(double gamma) {
  std::array<float, 256> gain{};
  for (std::size_t i = 1; i < gain.size(); ++i) {
    gain[i] = static_cast<float>(std::pow(255.0 / static_cast<double>(i), 1.0 / gamma));
  }
  return gain;
}

DecodedImage decode(ImageReader& image, const std::string& name) {
  const ImageHeader info = image.header();
  const auto fail = [&](const std::string& what) { return InputError({name}, what); };
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
  readPixels(image, pixels.data(), name);

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
  return decode(*openImage(hint, kind == "png" ? png : bytes, name), name);
}

DecodedImage readImage(const std::filesystem::path& path) {
  const std::string name = path.string();
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) throw InputError({name}, "there is no such image");
  std::string magic(4, '\0');
  std::ifstream(path, std::ios::binary).read(magic.data(), 4);
  if (kindOf(magic) == "png") return decodeImage(readFile(path), name);
  return decode(*openImage(name, {}, name), name);
}

bool mayHaveAlpha(const std::filesystem::path& path) {
  try {
    return openImage(path.string(), {}, path.string())->header().alphaChannel >= 0;
  } catch (const InputError&) {
    return true;
  }
}

std::string encodePng(const std::uint8_t* rgb, int width, int height) {
  const auto& module = moduleOf<ImagesModule>();
  try {
    return module.encodePng(rgb, width, height);
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception& e) {
    throw Error("the PNG could not be encoded: " + reason(e, "OpenImageIO says no more"));
  }
}

}  // namespace scanmill
