#pragma once

// The interface of libscanmill_images.so, in which OpenImageIO is (base/module.h).

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

#include "base/module.h"

namespace scanmill {

struct ImageHeader {
  int width = 0;   // px
  int height = 0;  // px
  int channels = 0;
  int alphaChannel = -1;  // -1 where there is none
  double alphaGamma = 0;  // colours^gamma were multiplied by alpha; 0 where they were not
};

// An image that is open for reading.
class ImageReader {
 public:
  virtual ~ImageReader() = default;
  virtual ImageHeader header() const = 0;
  // Reads the next `count` rows, from the top one on: 8 bit a channel, interleaved, width * count * channels bytes.
  // Throws std::runtime_error in the library's words.
  virtual void rows(int count, std::uint8_t* pixels) = 0;
};

class ImagesModule {
 public:
  static constexpr ModuleFile kFile{"libscanmill_images.so", "images other than PNG and JPEG cannot be read",
                                    "install OpenImageIO (on Debian the package libopenimageio-dev)"};
  virtual ~ImagesModule() = default;
  // Opens an image and reads its header: `bytes`, which the caller keeps as long as the reader, of the kind that the
  // name ends with, or where there are none the file of that name. Throws std::runtime_error in OpenImageIO's words.
  virtual std::unique_ptr<ImageReader> open(const std::string& name, std::string_view bytes) const = 0;
};

}  // namespace scanmill
