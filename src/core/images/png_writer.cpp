#include <png.h>

#include <array>
#include <csetjmp>
#include <cstdint>
#include <cstring>
#include <new>
#include <string>

#include "base/error.h"
#include "images/images.h"

namespace scanmill {

namespace {

class PngWriter {
 public:
  PngWriter() {
    png_ = png_create_write_struct(PNG_LIBPNG_VER_STRING, this, fail, [](png_structp, png_const_charp) {});
    info_ = png_ != nullptr ? png_create_info_struct(png_) : nullptr;
    if (info_ == nullptr) throw std::bad_alloc();
  }
  ~PngWriter() { png_destroy_write_struct(&png_, &info_); }
  PngWriter(const PngWriter&) = delete;
  PngWriter& operator=(const PngWriter&) = delete;

  std::string encode(const std::uint8_t* rgb, int width, int height) {
    // libpng jumps back to this place when it fails.
    if (setjmp(jump_) != 0) throw Error(std::string("the PNG could not be encoded: ") + message_.data());
    png_set_write_fn(png_, &bytes_, append, nullptr);
    png_set_IHDR(png_, info_, static_cast<png_uint_32>(width), static_cast<png_uint_32>(height), 8, PNG_COLOR_TYPE_RGB,
                 PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    png_set_compression_level(png_, 9);
    png_set_filter(png_, PNG_FILTER_TYPE_DEFAULT, PNG_FILTER_NONE);  // makes images of points, which have no gradients,
                                                                     // 1/4 smaller
    png_write_info(png_, info_);
    for (int i = 0; i < height; ++i)
      png_write_row(png_, rgb + std::size_t{3} * static_cast<std::size_t>(width) * static_cast<std::size_t>(i));
    png_write_end(png_, info_);
    return std::move(bytes_);
  }

 private:
  [[noreturn]] static void fail(png_structp png, png_const_charp message) {
    PngWriter& self = *static_cast<PngWriter*>(png_get_error_ptr(png));
    std::strncpy(self.message_.data(), message, self.message_.size() - 1);
    std::longjmp(self.jump_, 1);
  }

  static void append(png_structp png, png_bytep data, std::size_t size) {
    try {
      static_cast<std::string*>(png_get_io_ptr(png))->append(reinterpret_cast<const char*>(data), size);
    } catch (const std::bad_alloc&) {
      png_error(png, "there is too little memory");
    }
  }

  png_structp png_ = nullptr;
  png_infop info_ = nullptr;
  std::jmp_buf jump_{};
  std::array<char, 200> message_{};
  std::string bytes_;
};

}  // namespace

std::string encodePng(const std::uint8_t* rgb, int width, int height) {
  return PngWriter().encode(rgb, width, height);
}

}  // namespace scanmill
