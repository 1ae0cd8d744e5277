#include "images/images.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <memory>
#include <new>
#include <utility>

#include "base/error.h"
#include "base/file.h"
#include "base/input_budget.h"
#include "base/memory.h"
#include "base/text_scan.h"
#include "config/resources.h"
#include "config/text.h"
#include "images/images_interface.h"
#include "images/srgb.h"

namespace scanmill {

namespace {

constexpr int kMostFileSide = 16384;     // px, width and height of images that are read
constexpr int kMostSide = 4096;          // px, width and height to which larger images are reduced
constexpr std::size_t kMagicBytes = 16;  // first bytes of a file, which identify most kinds of images
constexpr int kRowsAtATime = 64;         // rows that are decoded at a time

// Returns the kind of an image ("png", "jpg", ...) by its first bytes; empty if they do not show the kind.
std::string kindOf(std::string_view bytes) {
  using namespace std::string_view_literals;
  constexpr std::pair<std::string_view, const char*> kMagics[]{
      {"\x89PNG", "png"},  {"\xff\xd8\xff", "jpg"},     {"BM", "bmp"},      {"GIF8", "gif"},   {"DDS ", "dds"},
      {"\x01\xda", "sgi"}, {"\x76\x2f\x31\x01", "exr"}, {"II*\0"sv, "tif"}, {"MM\0*"sv, "tif"}};
  for (const auto& [magic, kind] : kMagics) {
    if (bytes.starts_with(magic)) return kind;
  }
  return bytes.starts_with("RIFF") && bytes.size() > 8 && bytes.substr(8).starts_with("WEBP") ? "webp" : "";
}

// True for the kinds that libpng and libjpeg read. OpenImageIO reads all other kinds.
bool isReadHere(std::string_view kind) {
  return kind == "png" || kind == "jpg";
}

// Returns a reader's error message, on one line.
std::string reason(const std::exception& error) {
  std::string text = reasonOf(error);
  while (!text.empty() && (text.back() == '\n' || text.back() == '.')) text.pop_back();
  std::replace(text.begin(), text.end(), '\n', ' ');
  return text.empty() ? "not an image that can be decoded" : text;
}

// Returns the module of OpenImageIO. If it is missing, throws Error and not InputError, since the image may be sound.
const ImagesModule& moduleFor(const std::string& name, std::string_view kind) {
  try {
    return moduleOf<ImagesModule>();
  } catch (const Error& error) {
    throw Error("{}: convert it to {}: {}", name, kind == "jpg" ? "RGB" : "PNG or JPEG", error.what());
  }
}

// Returns work(). Turns exceptions of the libraries into an InputError "NAME: the image cannot be VERB: REASON"; `verb`
// is a participle such as "decoded".
template <class Work>
auto withReason(const std::string& name, const char* verb, const Work& work) {
  try {
    return work();
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const Error&) {
    throw;
  } catch (const std::exception& e) {
    throw InputError({name}, "the image cannot be {}: {}", verb, reason(e));
  }
}

// Opens the image in `bytes` or, if `bytes` is empty, in the file `kind`. OpenImageIO takes the format of images other
// than PNG and JPEG from the suffix of `kind`. `name`: the image's name in messages.
std::unique_ptr<ImageReader> openImage(const std::string& kind, std::string_view bytes, const std::string& name) {
  return withReason(name, "read", [&] {
    const std::string kindOfBytes = kindOf(bytes);
    if (kindOfBytes == "png") return openPng(bytes);
    auto jpeg = kindOfBytes == "jpg" ? openJpeg(bytes) : nullptr;
    return jpeg != nullptr ? std::move(jpeg) : moduleFor(name, kindOfBytes).open(kind, bytes);
  });
}

// Returns the factors that undo a multiplication of 8-bit colours by alpha, one factor for each alpha (0 to 255);
// `gamma`: see ImageHeader::alphaGamma, above 0.
std::array<float, 256> divisionByAlpha(double gamma) {
  std::array<float, 256> factors{};
  for (std::size_t alpha = 1; alpha < factors.size(); ++alpha) {
    factors[alpha] = static_cast<float>(std::pow(255.0 / static_cast<double>(alpha), 1.0 / gamma));
  }
  return factors;
}

// Maximum number of pixels that a byte of a file can encode: deflate expands a byte to at most 1032 bytes, and a byte
// contains at most 8 pixels. The bound exposes headers with a false size. It holds for kKindsBoundedByBytes.
constexpr double kMostPixelsPerByte = 8 * 1032;
constexpr std::string_view kKindsBoundedByBytes = "png jpg jpeg bmp gif sgi tga dds";

// Throws InputError if an image has no pixels, is too large to decode, or has more pixels than a file of `bytes` bytes
// and this kind can encode. Charges the pixels to the input budget (base/input_budget.h).
void checkSize(const ImageHeader& header, const std::string& kind, std::uint64_t bytes, const std::string& name) {
  const auto fail = [&](const std::string& problem) { throw InputError({name}, problem); };
  if (header.width < 1 || header.height < 1 || header.channels < 1) fail("the image has no pixels");
  const std::string size = fmt::format("{} x {} pixels", header.width, header.height);
  if (header.width > kMostFileSide || header.height > kMostFileSide) {
    fail(fmt::format("the image of {} is larger than {} x {}: scale it down", size, kMostFileSide, kMostFileSide));
  }
  const double pixels = static_cast<double>(header.width) * header.height;
  if (containsWord(kKindsBoundedByBytes, kind) && pixels > kMostPixelsPerByte * static_cast<double>(bytes)) {
    fail(fmt::format("the image is damaged: its {} bytes cannot hold {}", bytes, size));
  }
  // Most readers decode the complete image at once, with up to four bytes per channel.
  const bool isDecodedByRows = kind == "png" || kind == "jpg" || kind == "jpeg";
  const double neededBytes = pixels * header.channels * 4;
  chargePixels(pixels, {name});
  const auto mostBytes = static_cast<double>(memoryLimitBytes());
  if (!isDecodedByRows && neededBytes > mostBytes) {
    fail(
        fmt::format("the image of {} in {} channels may take {:.1f} GB to decode, and this process may take {:.1f} GB: "
                    "scale it down",
                    size, header.channels, neededBytes * 1e-9, mostBytes * 1e-9));
  }
}

// Returns the sRGB byte whose linear value is nearest to `light` (linear, 0 to 1).
std::uint8_t encoded(float light) {
  const std::array<float, 256>& linear = linearOfBytes();
  const auto above = std::lower_bound(linear.begin(), linear.end(), light);
  if (above == linear.begin()) return 0;
  const auto below = std::prev(above);
  const auto nearest = above == linear.end() || light - *below < *above - light ? below : above;
  return static_cast<std::uint8_t>(nearest - linear.begin());
}

// Reduces an image by a whole factor, row by row: each pixel is the mean of a square of factor x factor pixels. Colours
// are averaged in linear light, weighted by alpha.
class Reduction {
 public:
  // `width` is the width of the image to reduce (px).
  Reduction(int width, int factor)
      : width_(width), factor_(factor), sums_(static_cast<std::size_t>((width + factor - 1) / factor)) {}

  // Adds a row of 8-bit RGBA.
  void add(const std::uint8_t* rgba) {
    const std::array<float, 256>& linear = linearOfBytes();
    for (int x = 0; x < width_; ++x, rgba += 4) {
      Sum& sum = sums_[static_cast<std::size_t>(x / factor_)];
      // The weight is above 0 even for alpha 0, so that a square of fully transparent pixels keeps its colour.
      const float weight = static_cast<float>(rgba[3]) + 1e-3f;
      for (std::size_t c = 0; c < 3; ++c) sum.light[c] += weight * linear[rgba[c]];
      sum.weight += weight;
      sum.alpha += rgba[3];
      ++sum.count;
    }
  }
  // Writes one reduced row of (width + factor - 1) / factor pixels: the means of the rows that were added since the
  // last call. At least one row must have been added.
  void take(std::uint8_t* rgba) {
    for (Sum& sum : sums_) {
      for (std::size_t c = 0; c < 3; ++c) *rgba++ = encoded(sum.light[c] / sum.weight);
      *rgba++ = static_cast<std::uint8_t>((sum.alpha + sum.count / 2) / sum.count);
      sum = {};
    }
  }

 private:
  // Sums over the pixels of a square.
  struct Sum {
    std::array<float, 3> light{};  // linear red, green and blue times their weights
    float weight = 0;
    std::uint32_t alpha = 0;
    std::uint32_t count = 0;
  };

  int width_;
  int factor_;
  std::vector<Sum> sums_;  // sums of the squares in a row of squares
};

// Converts rows of a reader to 8-bit RGBA whose colours are not multiplied by alpha.
class RgbaConverter {
 public:
  explicit RgbaConverter(const ImageHeader& header)
      : channels_(header.channels),
        alpha_(header.alphaChannel),
        isMultiplied_(header.alphaGamma > 0),
        factors_(divisionByAlpha(isMultiplied_ ? header.alphaGamma : 1.0)) {
    if (colorChannels() >= 3) colors_ = {0, 1, 2};
  }

  // Returns the number of colour channels. The alpha channel, if there is one, follows them.
  int colorChannels() const { return alpha_ >= 0 ? alpha_ : channels_; }

  // Returns the number of channels that become neither colour nor alpha.
  int unusedChannels() const {
    const int colors = colorChannels() >= 3 ? 3 : std::min(colorChannels(), 1);
    return channels_ - colors - (alpha_ >= 0 ? 1 : 0);
  }

  // Converts `count` pixels of the reader to RGBA.
  void convert(const std::uint8_t* pixels, std::size_t count, std::uint8_t* rgba) {
    // Local copies are faster: the compiler must assume that storing a byte changes members.
    const int channels = channels_, alpha = alpha_;
    const std::array<int, 3> colors = colors_;
    std::uint8_t least = leastAlpha, greatest = greatestAlpha;
    for (std::size_t i = 0; i < count; ++i, pixels += channels, rgba += 4) {
      for (std::size_t c = 0; c < 3; ++c) rgba[c] = pixels[colors[c]];
      rgba[3] = alpha >= 0 ? pixels[alpha] : std::uint8_t{255};
      least = std::min(least, rgba[3]);
      greatest = std::max(greatest, rgba[3]);
      for (int c = 0; isMultiplied_ && c < 3; ++c) {
        rgba[c] = static_cast<std::uint8_t>(std::min(255.0f, static_cast<float>(rgba[c]) * factors_[rgba[3]] + 0.5f));
      }
    }
    leastAlpha = least;
    greatestAlpha = greatest;
  }

  std::uint8_t leastAlpha = 255, greatestAlpha = 0;  // of all pixels that were converted

 private:
  int channels_;
  int alpha_;                           // index of the alpha channel; -1: none
  std::array<int, 3> colors_{0, 0, 0};  // channels of red, green and blue
  bool isMultiplied_;                   // true: the reader's colours are multiplied by alpha
  std::array<float, 256> factors_;      // see divisionByAlpha()
};

// Decodes an image of `fileBytes` bytes. `kindOfBytes`: see kindOf(); if it is empty, the ending of the name tells the
// kind.
DecodedImage decode(ImageReader& image, const std::string& kindOfBytes, std::uint64_t fileBytes,
                    const std::string& name) {
  const std::string ending = lowerExtension(name);
  const std::string kind = !kindOfBytes.empty() || ending.empty() ? kindOfBytes : ending.substr(1);
  const ImageHeader header = image.header();
  checkSize(header, kind, fileBytes, name);
  const int factor = (std::max(header.width, header.height) + kMostSide - 1) / kMostSide;  // factor of the reduction
  const auto width = static_cast<std::size_t>(header.width);
  const std::size_t rowBytes = width * static_cast<std::size_t>(header.channels);
  DecodedImage decoded;
  decoded.width = static_cast<std::uint32_t>((header.width + factor - 1) / factor);
  decoded.height = static_cast<std::uint32_t>((header.height + factor - 1) / factor);
  decoded.linear = header.linear;
  decoded.rgba.resize(std::size_t{decoded.width} * decoded.height * 4);
  std::uint8_t* out = decoded.rgba.data();  // start of the next rows
  RgbaConverter converter(header);
  Reduction reduction(header.width, factor);
  std::vector<std::uint8_t> rows(rowBytes * kRowsAtATime);
  std::vector<std::uint8_t> rgbaRow(width * 4);
  for (int first = 0; first < header.height; first += kRowsAtATime) {
    const int count = std::min(kRowsAtATime, header.height - first);
    withReason(name, "decoded", [&] { image.rows(count, rows.data()); });
    if (factor == 1) {
      converter.convert(rows.data(), width * static_cast<std::size_t>(count), out);
      out += width * 4 * static_cast<std::size_t>(count);
      continue;
    }
    for (int i = 0; i < count; ++i) {
      converter.convert(rows.data() + static_cast<std::size_t>(i) * rowBytes, width, rgbaRow.data());
      reduction.add(rgbaRow.data());
      if ((first + i + 1) % factor == 0 || first + i + 1 == header.height) {
        reduction.take(out);
        out += std::size_t{decoded.width} * 4;
      }
    }
  }
  // BMP and TGA often have an unused fourth channel of zeros: if alpha is 0 everywhere, the image counts as opaque.
  const bool isOpaque = converter.greatestAlpha == 0 && (kind == "bmp" || kind == "tga");
  for (std::size_t i = 3; isOpaque && i < decoded.rgba.size(); i += 4) decoded.rgba[i] = 255;
  decoded.hasAlpha = converter.leastAlpha < 255 && !isOpaque;
  LeftOut leftOut;
  for (const std::string& unreadContent : header.leftOut) leftOut.add(unreadContent);
  leftOut.add(kFurtherChannels, static_cast<std::uint64_t>(converter.unusedChannels()));
  leftOut.warn(name);
  return decoded;
}

}  // namespace

const FormatSupport kImageFormat{
    "Images of materials",
    ".png, .jpg, .jpeg, .webp, .tga, .sgi, .rgb, .bmp, .tif, .exr, .hdr, .gif, .dds and what else OpenImageIO reads",
    "Red, green and blue, grey, palettes, CMYK; 1 to 32 bits, which become 8. Alpha, also of palettes; colours that "
    "are multiplied by it are divided; in BMP and TGA an alpha that is 0 everywhere is none. Floats (EXR, HDR, TIFF) "
    "are linear light from 0 to 1; whole numbers and other single channels are sRGB. The canvas of GIF. The first "
    "image of the file; more than 4096 pixels in a row or column are reduced. Colour profiles, gammas and "
    "orientations (Exif) change nothing, as in glTF and Blender",
    "further images and channels; images of few colours that an alpha hides"};

DecodedImage decodeImage(std::string_view bytes, const std::string& name) {
  if (bytes.empty()) throw InputError({name}, "the image is empty");
  const std::string kind = kindOf(bytes);
  return decode(*openImage(kind.empty() ? name : "embedded." + kind, bytes, name), kind, bytes.size(), name);
}

DecodedImage readImage(const std::filesystem::path& path) {
  const std::string name = path.string();
  if (!isFile(path)) throw InputError({name}, "there is no such image");
  const std::string kind = kindOf(firstBytes(path, kMagicBytes));
  if (isReadHere(kind)) return decodeImage(readFile(path), name);
  chargeFile(path);
  return decode(*openImage(name, {}, name), kind, std::filesystem::file_size(path), name);
}

bool mayHaveAlpha(const std::filesystem::path& path) {
  try {
    const std::string kind = kindOf(firstBytes(path, kMagicBytes));
    if (kind == "jpg") return false;
    const std::string bytes = isReadHere(kind) ? readFile(path) : std::string();
    return openImage(path.string(), bytes, path.string())->header().alphaChannel >= 0;
  } catch (const InputError&) {
    return true;
  }
}

}  // namespace scanmill
