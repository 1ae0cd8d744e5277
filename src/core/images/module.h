#pragma once

// What the program and libscanmill_images.so have in common, and all of it. Plain structs and functions that do not
// throw: each side frees what it allocated, and errors travel as text.

#include <cstddef>
#include <cstdint>

extern "C" {

enum ScanmillImageStatus : std::int32_t { kScanmillImageDone, kScanmillImageFailed, kScanmillImageOutOfMemory };

struct ScanmillImageError {
  char text[1024];  // ends with a zero; cut where it is longer
};

struct ScanmillImageInfo {
  std::int32_t width;
  std::int32_t height;
  std::int32_t channels;
  std::int32_t alphaChannel;  // -1 without
  double alphaGamma;          // colours^gamma were multiplied by alpha; 0 where they were not
};

struct ScanmillImageReader;

struct ScanmillImageBytes {
  const char* data;
  std::size_t size;
  void* owner;
};

struct ScanmillImagesModule {
  std::uint32_t version;
  // Opens an image and reads its header: the file `name`, or `size` bytes at `bytes`, which the caller keeps until
  // close(), of the kind that the name ends with.
  ScanmillImageStatus (*open)(const char* name, const char* bytes, std::size_t size, ScanmillImageReader** reader,
                              ScanmillImageInfo* info, ScanmillImageError* error);
  // All pixels, 8 bit a channel, interleaved, the top row first: width * height * channels bytes.
  ScanmillImageStatus (*read)(ScanmillImageReader* reader, std::uint8_t* pixels, ScanmillImageError* error);
  void (*close)(ScanmillImageReader* reader);
  ScanmillImageStatus (*encodePng)(const std::uint8_t* rgb, std::int32_t width, std::int32_t height,
                                   ScanmillImageBytes* png, ScanmillImageError* error);
  void (*release)(ScanmillImageBytes* bytes);
};

// The only symbol of the module.
const ScanmillImagesModule* scanmillImagesModule();
}

namespace scanmill {

constexpr std::uint32_t kImagesModuleVersion = 1;  // another one for every change of the structs above
constexpr const char* kImagesModuleSymbol = "scanmillImagesModule";

}  // namespace scanmill
