#include <png.h>

#include <algorithm>
#include <array>
#include <csetjmp>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <stdexcept>
#include <string>
#include <vector>

#include "images/metadata.h"
#include "images/readers.h"

namespace scanmill {

namespace {

class PngReader final : public ImageReader {
 public:
  explicit PngReader(std::string_view bytes) : bytes_(bytes), left_(bytes) {
    png_ = png_create_read_struct(PNG_LIBPNG_VER_STRING, this, fail, ignore);
    info_ = png_ != nullptr ? png_create_info_struct(png_) : nullptr;
    if (info_ == nullptr) throw std::bad_alloc();
    try {
      guarded([this] { readHeader(); });
      noteLook();
    } catch (...) {
      png_destroy_read_struct(&png_, &info_, nullptr);
      throw;
    }
  }
  ~PngReader() override { png_destroy_read_struct(&png_, &info_, nullptr); }
  PngReader(const PngReader&) = delete;
  PngReader& operator=(const PngReader&) = delete;

  ImageHeader header() const override { return header_; }

  void rows(int count, std::uint8_t* pixels) override {
    const std::size_t rowBytes = std::size_t(header_.width) * std::size_t(header_.channels);
    if (interlaced_) {
      readInterlaced(rowBytes);
      std::memcpy(pixels, whole_.data() + std::size_t(next_) * rowBytes, std::size_t(count) * rowBytes);
    } else {
      guarded([=, this] {
        for (int i = 0; i < count; ++i) png_read_row(png_, pixels + std::size_t(i) * rowBytes, nullptr);
      });
    }
    next_ += count;
    if (next_ == header_.height) guarded([this] { png_read_end(png_, nullptr); });
  }

 private:
  // libpng jumps back into this function when it fails: `work` must not contain objects that need to be destroyed.
  template <class Work>
  void guarded(const Work& work) {
    if (setjmp(jump_) != 0) throw std::runtime_error(message_.data());
    work();
  }

  static PngReader& of(png_structp png) { return *static_cast<PngReader*>(png_get_error_ptr(png)); }

  [[noreturn]] static void fail(png_structp png, png_const_charp message) {
    PngReader& self = of(png);
    std::strncpy(self.message_.data(), message, self.message_.size() - 1);
    std::longjmp(self.jump_, 1);
  }

  static void ignore(png_structp, png_const_charp) {}

  static void take(png_structp png, png_bytep to, std::size_t size) {
    PngReader& self = *static_cast<PngReader*>(png_get_io_ptr(png));
    if (size > self.left_.size()) fail(png, "it is truncated");
    std::memcpy(to, self.left_.data(), size);
    self.left_.remove_prefix(size);
  }

  void readHeader() {
    png_set_read_fn(png_, this, take);
    png_set_keep_unknown_chunks(png_, PNG_HANDLE_CHUNK_NEVER, nullptr, -1);  // skips chunks that do not affect pixels
    static constexpr char kStated[] = "gAMA\0iCCP\0sRGB\0eXIf";  // except these, which state how the pixels are to look
    png_set_keep_unknown_chunks(png_, PNG_HANDLE_CHUNK_AS_DEFAULT, reinterpret_cast<png_const_bytep>(kStated), 4);
    png_set_user_limits(png_, 1 << 30, 1 << 30);  // checkSize() checks the size later
    png_read_info(png_, info_);
    png_set_expand(png_);
    png_set_scale_16(png_);
    interlaced_ = png_set_interlace_handling(png_) > 1;
    png_read_update_info(png_, info_);
    const int channels = png_get_channels(png_, info_);
    header_ = {static_cast<int>(png_get_image_width(png_, info_)), static_cast<int>(png_get_image_height(png_, info_)),
               channels, channels == 2 || channels == 4 ? channels - 1 : -1, 0};
  }

  // Notes what the file states of the look, which is not applied.
  void noteLook() {
    png_charp name = nullptr;
    png_bytep bytes = nullptr;
    png_uint_32 size = 0;
    int compression = 0;
    double gamma = 0;
    if (png_get_iCCP(png_, info_, &name, &compression, &bytes, &size) != 0) {
      if (!isSrgb({reinterpret_cast<const char*>(bytes), size})) header_.leftOut.emplace_back(kProfiles);
    } else if (png_get_gAMA(png_, info_, &gamma) != 0 && (gamma < 0.4 || gamma > 0.51)) {
      header_.leftOut.emplace_back(kGammas);  // that of sRGB is 0.45455
    }
    // An animation (APNG) states it before the pixels.
    const std::string_view before = bytes_.substr(0, bytes_.find("IDAT"));
    if (before.find("acTL") != before.npos) header_.leftOut.emplace_back(kFurtherImages);
    if (png_get_eXIf_1(png_, info_, &size, &bytes) != 0 && isTurned({reinterpret_cast<const char*>(bytes), size})) {
      header_.leftOut.emplace_back(kOrientations);
    }
  }

  void readInterlaced(std::size_t rowBytes) {
    if (!whole_.empty()) return;
    whole_.resize(std::size_t(header_.height) * rowBytes);
    std::vector<png_bytep> rows;
    rows.reserve(static_cast<std::size_t>(header_.height));
    for (int i = 0; i < header_.height; ++i) rows.push_back(whole_.data() + std::size_t(i) * rowBytes);
    guarded([&] { png_read_image(png_, rows.data()); });
  }

  std::string_view bytes_;
  std::string_view left_;  // the bytes that libpng has not read yet
  png_structp png_ = nullptr;
  png_infop info_ = nullptr;
  std::jmp_buf jump_{};
  std::array<char, 200> message_{};
  ImageHeader header_;
  bool interlaced_ = false;
  std::vector<std::uint8_t> whole_;  // all rows of an interlaced image
  int next_ = 0;                     // index of the next row
};

}  // namespace

std::unique_ptr<ImageReader> openPng(std::string_view bytes) {
  return std::make_unique<PngReader>(bytes);
}

}  // namespace scanmill
