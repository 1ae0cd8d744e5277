#pragma once

// The interface of libscanmill_images.so, the module that links OpenImageIO (base/module.h).

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "base/module.h"

namespace scanmill {

struct ImageHeader {
  int width = 0;   // px
  int height = 0;  // px
  int channels = 0;
  int alphaChannel = -1;    // index of the alpha channel; -1: none
  double alphaGamma = 0;    // above 0: (colour ^ alphaGamma) was multiplied by alpha; 0: colours were not multiplied
  bool linear = false;      // true: the file has linear light, which rows() returns as sRGB
  double storedPixels = 0;  // number of pixels that the file stores, if it may differ from width * height
  std::vector<std::string> leftOut = {};  // what would change the look (images/metadata.h)
};

// An image that is open for reading.
class ImageReader {
 public:
  virtual ~ImageReader() = default;
  virtual ImageHeader header() const = 0;
  // Reads the next `count` rows; the first call starts at the top row. Fills width * count * channels bytes: 8 bits per
  // channel, interleaved; colours in sRGB.
  // Throws std::runtime_error with the library's message.
  virtual void rows(int count, std::uint8_t* pixels) = 0;
};

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
