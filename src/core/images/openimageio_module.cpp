// libscanmill_images.so: OpenImageIO behind the interface of images/images_interface.h.

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>
#include <dlfcn.h>

#include <cstdarg>
#include <cstdint>
#include <cstring>
#include <memory>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "images/images_interface.h"

namespace scanmill {

namespace {

// Throws std::runtime_error with the error message of the reader or, if it has none, of this thread. Both messages are
// fetched, since OpenImageIO prints messages that were never fetched.
[[noreturn]] void fail(const OIIO::ImageInput* reader) {
  const std::string text = reader != nullptr ? reader->geterror() : std::string();
  const std::string global = OIIO::geterror();
  throw std::runtime_error(text.empty() ? global : text);
}

class OpenImageIoReader final : public ImageReader {
 public:
  OpenImageIoReader(const std::string& name, std::string_view bytes) : memory_(bytes.data(), bytes.size()) {
    OIIO::Filesystem::IOProxy* memory = bytes.empty() ? nullptr : &memory_;
    OIIO::ImageSpec config;
    config.attribute("oiio:UnassociatedAlpha", 1);  // colours are not multiplied by alpha
    if (memory != nullptr) config.attribute("oiio:ioproxy", OIIO::TypeDesc::PTR, &memory);
    input_ = OIIO::ImageInput::open(name, &config, memory);
    if (!input_) fail(nullptr);
  }

  ImageHeader header() const override {
    const OIIO::ImageSpec& spec = input_->spec();
    const bool alpha = spec.alpha_channel >= 0 && spec.alpha_channel < spec.nchannels;
    // Readers that multiply colours by alpha, although the configuration forbids it, do not set oiio:UnassociatedAlpha.
    // The reader of WebP multiplies in linear light.
    const bool multiplied = alpha && spec.get_int_attribute("oiio:UnassociatedAlpha", 0) == 0;
    const double gamma = std::string_view(input_->format_name()) == "webp" ? 2.2 : 1.0;
    return {spec.width, spec.height, spec.nchannels, alpha ? spec.alpha_channel : -1, multiplied ? gamma : 0.0};
  }

  void rows(int count, std::uint8_t* pixels) override {
    const OIIO::ImageSpec& spec = input_->spec();
    const std::size_t rowBytes = static_cast<std::size_t>(spec.width) * static_cast<std::size_t>(spec.nchannels);
    const std::size_t bytes = static_cast<std::size_t>(count) * rowBytes;
    if (spec.tile_width == 0) {
      const int first = spec.y + next_;
      if (!input_->read_scanlines(0, 0, first, first + count, spec.z, 0, spec.nchannels, OIIO::TypeDesc::UINT8,
                                  pixels)) {
        fail(input_.get());
      }
    } else {
      if (whole_.empty()) {
        whole_.resize(static_cast<std::size_t>(spec.height) * rowBytes);
        if (!input_->read_image(0, 0, 0, spec.nchannels, OIIO::TypeDesc::UINT8, whole_.data())) fail(input_.get());
      }
      std::memcpy(pixels, whole_.data() + static_cast<std::size_t>(next_) * rowBytes, bytes);
    }
    next_ += count;
  }

 private:
  OIIO::Filesystem::IOMemReader memory_;
  std::unique_ptr<OIIO::ImageInput> input_;  // uses memory_, and must be destroyed before memory_
  std::vector<std::uint8_t> whole_;          // all rows of an image that is stored in tiles
  int next_ = 0;                             // index of the next row
};

// Keeps libtiff from printing. OpenImageIO tries all its readers on a damaged file, and from 2.5 on (Debian 13) libtiff
// then prints complaints about files of other kinds. dlsym() finds libtiff, which OpenImageIO links and this module
// does not.
void silenceLibtiff() {
  using Handler = void (*)(const char* module, const char* format, va_list arguments);
  for (const char* name : {"TIFFSetErrorHandler", "TIFFSetWarningHandler"}) {
    const auto set = reinterpret_cast<Handler (*)(Handler)>(::dlsym(RTLD_DEFAULT, name));
    if (set != nullptr) set(nullptr);
  }
}

class OpenImageIo final : public ImagesModule {
 public:
  OpenImageIo() { silenceLibtiff(); }

  std::unique_ptr<ImageReader> open(const std::string& name, std::string_view bytes) const override {
    return std::make_unique<OpenImageIoReader>(name, bytes);
  }
};

}  // namespace

}  // namespace scanmill

SCANMILL_MODULE(ImagesModule, OpenImageIo)
