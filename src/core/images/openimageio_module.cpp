// libscanmill_images.so: OpenImageIO behind the functions of images/module.h. It is not part of the program, which
// loads it when it meets the first image.

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <exception>
#include <memory>
#include <new>
#include <string>
#include <string_view>
#include <vector>

#include "images/module.h"

struct ScanmillImageReader {
  ScanmillImageReader(const char* bytes, std::size_t size) : memory(bytes, size) {}

  OIIO::Filesystem::IOMemReader memory;
  std::unique_ptr<OIIO::ImageInput> input;  // reads the memory, so goes first
};

namespace {

void put(ScanmillImageError& error, std::string_view text) {
  const std::size_t size = std::min(text.size(), sizeof error.text - 1);
  std::copy_n(text.data(), size, error.text);
  error.text[size] = '\0';
}

// OpenImageIO prints a message that nobody fetched when its thread or object ends, so both are fetched.
template <class ReaderOrWriter>
std::string reason(const ReaderOrWriter* object) {
  const std::string text = object != nullptr ? object->geterror() : std::string();
  const std::string global = OIIO::geterror();
  return text.empty() ? global : text;
}

struct Outcome {
  bool done = true;
  std::string error{};
};

// Runs `work`, which gives an Outcome, and lets no exception out.
template <class Work>
ScanmillImageStatus guarded(ScanmillImageError& error, const Work& work) noexcept {
  try {
    const Outcome outcome = work();
    put(error, outcome.error);
    return outcome.done ? kScanmillImageDone : kScanmillImageFailed;
  } catch (const std::bad_alloc&) {
    put(error, "out of memory");
    return kScanmillImageOutOfMemory;
  } catch (const std::exception& e) {
    put(error, e.what());
  } catch (...) {
    put(error, "");
  }
  return kScanmillImageFailed;
}

ScanmillImageInfo describe(const OIIO::ImageInput& input) {
  const OIIO::ImageSpec& spec = input.spec();
  const bool alpha = spec.alpha_channel >= 0 && spec.alpha_channel < spec.nchannels;
  // Some readers multiply colours by alpha whatever they are asked for; they leave this attribute out. The one of WebP
  // multiplies in linear light.
  const bool multiplied = alpha && spec.get_int_attribute("oiio:UnassociatedAlpha", 0) == 0;
  const double gamma = std::string_view(input.format_name()) == "webp" ? 2.2 : 1.0;
  return {spec.width, spec.height, spec.nchannels, alpha ? spec.alpha_channel : -1, multiplied ? gamma : 0.0};
}

ScanmillImageStatus openImage(const char* name, const char* bytes, std::size_t size, ScanmillImageReader** reader,
                              ScanmillImageInfo* info, ScanmillImageError* error) {
  return guarded(*error, [&]() -> Outcome {
    auto opened = std::make_unique<ScanmillImageReader>(bytes, size);
    OIIO::Filesystem::IOProxy* memory = bytes != nullptr ? &opened->memory : nullptr;
    OIIO::ImageSpec config;
    config.attribute("oiio:UnassociatedAlpha", 1);  // colours are wanted as painted, not multiplied by alpha
    if (memory != nullptr) config.attribute("oiio:ioproxy", OIIO::TypeDesc::PTR, &memory);
    opened->input = OIIO::ImageInput::open(name, &config, memory);
    if (!opened->input) return {false, reason<OIIO::ImageInput>(nullptr)};
    *info = describe(*opened->input);
    *reader = opened.release();
    return {};
  });
}

ScanmillImageStatus readPixels(ScanmillImageReader* reader, std::uint8_t* pixels, ScanmillImageError* error) {
  return guarded(*error, [&]() -> Outcome {
    OIIO::ImageInput& input = *reader->input;
    const int channels = input.spec().nchannels;
    if (input.read_image(0, 0, 0, channels, OIIO::TypeDesc::UINT8, pixels)) return {};
    return {false, reason(&input)};
  });
}

void closeImage(ScanmillImageReader* reader) {
  delete reader;
}

ScanmillImageStatus encodePng(const std::uint8_t* rgb, std::int32_t width, std::int32_t height, ScanmillImageBytes* png,
                              ScanmillImageError* error) {
  return guarded(*error, [&]() -> Outcome {
    auto bytes = std::make_unique<std::vector<unsigned char>>();
    OIIO::Filesystem::IOVecOutput memory(*bytes);  // outlives the writer
    const std::unique_ptr<OIIO::ImageOutput> out = OIIO::ImageOutput::create("png");
    if (!out) return {false, reason<OIIO::ImageOutput>(nullptr)};
    OIIO::ImageSpec spec(width, height, 3, OIIO::TypeDesc::UINT8);
    spec.attribute("png:compressionLevel", 9);
    spec.attribute("png:filter", 8);  // none: splats have no gradients, and become a quarter smaller without
    spec.attribute("DateTime", "1970:01:01 00:00:00");  // else the writer takes the clock
    if (!out->set_ioproxy(&memory) || !out->open("picture.png", spec) ||
        !out->write_image(OIIO::TypeDesc::UINT8, rgb) || !out->close()) {
      return {false, reason(out.get())};
    }
    *png = {reinterpret_cast<const char*>(bytes->data()), bytes->size(), bytes.get()};
    static_cast<void>(bytes.release());  // releaseBytes() deletes it
    return {};
  });
}

void releaseBytes(ScanmillImageBytes* bytes) {
  delete static_cast<std::vector<unsigned char>*>(bytes->owner);
  *bytes = {};
}

constexpr ScanmillImagesModule kModule{
    scanmill::kImagesModuleVersion, openImage, readPixels, closeImage, encodePng, releaseBytes};

}  // namespace

extern "C" __attribute__((visibility("default"))) const ScanmillImagesModule* scanmillImagesModule() {
  return &kModule;
}
