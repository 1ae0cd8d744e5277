// libscanmill_images.so: OpenImageIO behind the interface of images/images_interface.h.

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>
#include <dlfcn.h>

#include <algorithm>
#include <cmath>
#include <cstdarg>
#include <cstdint>
#include <cstring>
#include <memory>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "images/images_interface.h"
#include "images/srgb.h"

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
    describe();
  }

  ImageHeader header() const override { return header_; }

  void rows(int count, std::uint8_t* pixels) override {
    const OIIO::ImageSpec& spec = input_->spec();
    const OIIO::TypeDesc type = isLinear() ? OIIO::TypeDesc::FLOAT : OIIO::TypeDesc::UINT8;
    const std::size_t rowValues = static_cast<std::size_t>(spec.width) * static_cast<std::size_t>(spec.nchannels);
    const std::size_t values = static_cast<std::size_t>(count) * rowValues;
    light_.resize(isLinear() ? values : 0);
    void* const destination = isLinear() ? static_cast<void*>(light_.data()) : pixels;
    if (spec.tile_width == 0) {
      const int first = spec.y + nextRow_;
      if (!input_->read_scanlines(0, 0, first, first + count, spec.z, 0, spec.nchannels, type, destination)) {
        fail(input_.get());
      }
    } else {
      if (allRows_.empty()) {
        allRows_.resize(static_cast<std::size_t>(spec.height) * rowValues * type.size());
        if (!input_->read_image(0, 0, 0, spec.nchannels, type, allRows_.data())) fail(input_.get());
      }
      std::memcpy(destination, allRows_.data() + static_cast<std::size_t>(nextRow_) * rowValues * type.size(),
                  values * type.size());
    }
    nextRow_ += count;
    if (isLinear()) encode(pixels);
  }

 private:
  // Returns the index of the alpha channel; -1: none. The reader of GIF states an index that is too large by 1.
  int alphaChannel() const { return std::min(input_->spec().alpha_channel, input_->spec().nchannels - 1); }

  // Fills header_. Throws std::runtime_error for an EXR whose pixels do not fill its display window.
  void describe() {
    const OIIO::ImageSpec spec = input_->spec();
    const std::string_view format = input_->format_name();
    const bool isExr = format == "openexr";
    if (isExr && spec.roi() != spec.roi_full()) {
      throw std::runtime_error("its data window is not its display window: save it with one window");
    }
    header_ = {.width = spec.width,
               .height = spec.height,
               .channels = spec.nchannels,
               .alphaChannel = alphaChannel(),
               .alphaGamma = alphaGamma(),
               .linear = isLinear()};
    const int colorChannels = alphaChannel() < 0 ? spec.nchannels : alphaChannel();
    if (isExr && colorChannels < 3 && isOneOf("RGB", spec.channelnames[0])) header_.leftOut.emplace_back(kFewColors);
    if (!isExr && format != "tiff" && format != "gif" && format != "webp") return;
    // Only these formats hold further images. In all but EXR, images that are smaller than the first are its previews.
    if (input_->seek_subimage(1, 0) && (isExr || input_->spec().width >= spec.width)) {
      header_.leftOut.emplace_back(kFurtherImages);
    }
    input_->geterror();  // discards the error of an image that does not exist
    if (!input_->seek_subimage(0, 0)) fail(input_.get());
  }

  bool isMultiplied() const {
    if (alphaChannel() < 0 || input_->spec().get_int_attribute("oiio:UnassociatedAlpha", 0) != 0) return false;
    const std::string_view format = input_->format_name();
    const std::string compression = input_->spec().get_string_attribute("compression");
    return format == "webp" || format == "openexr" || format == "tiff" || compression == "DXT2" ||
           compression == "DXT4";
  }

  // Returns the exponent of ImageHeader::alphaGamma. OpenImageIO multiplies WebP by alpha in linear light, hence 2.2.
  // encode() divides linear colours by alpha, so that they are no longer multiplied.
  double alphaGamma() const {
    if (!isMultiplied() || isLinear()) return 0;
    return std::string_view(input_->format_name()) == "webp" ? 2.2 : 1.0;
  }

  // True if the name of a channel is one of these letters.
  static bool isOneOf(std::string_view letters, const std::string& channel) {
    return channel.size() == 1 && letters.find(channel) != letters.npos;
  }

  // True if the channels hold linear light, as colours in floats do by convention. A single channel of floats is a
  // measure, such as opacity, unless an EXR names it a colour or the luminance (Y).
  bool isLinear() const {
    const OIIO::ImageSpec& spec = input_->spec();
    const bool isColorOfExr =
        std::string_view(input_->format_name()) == "openexr" && isOneOf("RGBY", spec.channelnames[0]);
    return spec.format.is_floating_point() && (spec.nchannels >= 3 || isColorOfExr);
  }

  // Converts the rows in light_ to bytes: colours to sRGB, divided by alpha if they are multiplied by alpha. Alpha
  // remains linear.
  void encode(std::uint8_t* pixels) const {
    const auto channels = static_cast<std::size_t>(input_->spec().nchannels);
    const auto alphaIndex = static_cast<std::size_t>(alphaChannel());  // beyond all channels if there is none
    const bool divides = isMultiplied();
    const auto clamped = [](double value) { return value > 0 ? std::min(value, 1.0) : 0.0; };  // 0 for NaN
    for (std::size_t i = 0; i < light_.size(); i += channels) {
      for (std::size_t c = 0; c < channels; ++c) {
        const double value = double{light_[i + c]};
        const double alpha = divides ? clamped(double{light_[i + alphaIndex]}) : 1.0;
        const double encodedValue = c == alphaIndex ? clamped(value) : srgbOf(clamped(value / alpha));
        pixels[i + c] = static_cast<std::uint8_t>(std::lround(255 * encodedValue));
      }
    }
  }

  OIIO::Filesystem::IOMemReader memory_;
  std::unique_ptr<OIIO::ImageInput> input_;  // uses memory_, and must be destroyed before memory_
  ImageHeader header_;
  std::vector<std::uint8_t> allRows_;  // all rows of a file with tiles; empty before the first row is read
  std::vector<float> light_;           // the latest rows, if colours are linear
  int nextRow_ = 0;
};

class OpenImageIo final : public ImagesModule {
 public:
  // Keeps libtiff from printing. OpenImageIO tries all its readers on a damaged file, and from 2.5 on (Debian 13)
  // libtiff then prints complaints about files of other kinds. dlsym() finds libtiff, which OpenImageIO links and this
  // module does not.
  OpenImageIo() {
    using Handler = void (*)(const char* module, const char* format, va_list arguments);
    for (const char* name : {"TIFFSetErrorHandler", "TIFFSetWarningHandler"}) {
      const auto set = reinterpret_cast<Handler (*)(Handler)>(::dlsym(RTLD_DEFAULT, name));
      if (set != nullptr) set(nullptr);
    }
  }

  std::unique_ptr<ImageReader> open(const std::string& name, std::string_view bytes) const override {
    return std::make_unique<OpenImageIoReader>(name, bytes);
  }
};

}  // namespace

}  // namespace scanmill

SCANMILL_MODULE(ImagesModule, OpenImageIo)
