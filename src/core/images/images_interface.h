#pragma once

// Interfaces of image readers: PNG, JPEG and libscanmill_images.so, the module that links OpenImageIO (base/module.h).

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "base/module.h"

namespace scanmill {

// Texts that readers store in ImageHeader::leftOut.
inline constexpr const char* kFurtherImages = "sets of further images (the first image counts)";
inline constexpr const char* kFewColors = "images without red, green or blue (EXR; their first channel counts as grey)";
inline constexpr const char* kFurtherChannels = "channels that are neither colour nor alpha";

struct ImageHeader {
  int width = 0;   // px
  int height = 0;  // px
  int channels = 0;
  int alphaChannel = -1;  // index of the alpha channel; -1: none
  double alphaGamma = 0;  // above 0: (colour ^ alphaGamma) was multiplied by alpha; 0: colours were not multiplied
  bool linear = false;    // true: the file has linear light, which rows() returns as sRGB
  std::vector<std::string> leftOut = {};  // unread contents that affect the look: some of the texts above
};

// An image that is open for reading.
class ImageReader {
 public:
  virtual ~ImageReader() = default;
  virtual ImageHeader header() const = 0;
  // Reads the next `count` rows; the first call starts at the top row. Fills width * count * channels bytes: 8 bits per
  // channel, interleaved; colours in sRGB. Throws std::runtime_error with the library's message.
  virtual void rows(int count, std::uint8_t* pixels) = 0;
};

// The readers of PNG and JPEG. The caller must keep the bytes of an image as long as its reader.
//
// Opens a PNG and reads its header. Throws std::runtime_error with libpng's message if the file is damaged. Colours are
// returned as stored: profiles and gamma are not applied, as glTF demands.
std::unique_ptr<ImageReader> openPng(std::string_view bytes);

// Opens a JPEG and reads its header. Returns null for an image of four inks (CMYK), which OpenImageIO must convert.
// Throws std::runtime_error with libjpeg's message if the file is damaged, or if libjpeg warns of anything that may
// change the pixels.
std::unique_ptr<ImageReader> openJpeg(std::string_view bytes);

class ImagesModule {
 public:
  static constexpr ModuleFile kFile{"libscanmill_images.so",
                                    "images that are neither PNG nor JPEG in RGB cannot be read",
                                    "install OpenImageIO (on Debian the package libopenimageio-dev)"};
  virtual ~ImagesModule() = default;
  // Opens the image in `bytes`, or the file `name` if `bytes` is empty, and reads its header. The ending of `name`
  // names the kind of the bytes. The caller must keep the bytes as long as the reader. Throws std::runtime_error with
  // OpenImageIO's message.
  virtual std::unique_ptr<ImageReader> open(const std::string& name, std::string_view bytes) const = 0;
};

}  // namespace scanmill
