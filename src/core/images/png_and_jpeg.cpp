// PNG by libpng and JPEG by libjpeg.

#include <cstdio>
// jpeglib.h does not include the headers that it needs.
#include <jerror.h>
#include <jpeglib.h>
#include <png.h>

#include <array>
#include <csetjmp>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <memory>
#include <new>
#include <stdexcept>
#include <string>
#include <vector>

#include "base/error.h"
#include "images/images.h"
#include "images/images_interface.h"

namespace scanmill {

namespace {

// Converts errors of both libraries to exceptions. The libraries report an error by a jump (longjmp).
class JumpGuard {
 public:
  // Calls `work`, which must not contain objects that need to be destroyed, since the libraries jump out of it. Throws
  // std::runtime_error with the library's message.
  template <class Work>
  void run(const Work& work) {
    if (setjmp(jump_) != 0) throw std::runtime_error(message_.data());
    work();
  }

  [[noreturn]] void fail(const char* message) {
    std::strncpy(message_.data(), message, message_.size() - 1);
    std::longjmp(jump_, 1);
  }

 private:
  std::jmp_buf jump_{};
  std::array<char, JMSG_LENGTH_MAX> message_{};
};

class PngReader final : public ImageReader {
 public:
  explicit PngReader(std::string_view bytes) : unread_(bytes) {
    const auto fail = [](png_structp png, png_const_charp message) {
      static_cast<JumpGuard*>(png_get_error_ptr(png))->fail(message);
    };
    const auto ignoreWarning = [](png_structp, png_const_charp) {};
    png_ = png_create_read_struct(PNG_LIBPNG_VER_STRING, &guard_, fail, ignoreWarning);
    info_ = png_ != nullptr ? png_create_info_struct(png_) : nullptr;
    if (info_ == nullptr) throw std::bad_alloc();
    try {
      guard_.run([this] { readHeader(); });
      // An animation (APNG) has a chunk acTL before the chunks of pixels (IDAT).
      const std::string_view chunksBefore = bytes.substr(0, bytes.find("IDAT"));
      if (chunksBefore.find("acTL") != chunksBefore.npos) header_.leftOut.emplace_back(kFurtherImages);
    } catch (...) {
      png_destroy_read_struct(&png_, &info_, nullptr);
      throw;
    }
  }
  ~PngReader() override { png_destroy_read_struct(&png_, &info_, nullptr); }
  PngReader& operator=(PngReader&&) = delete;  // neither copied nor moved

  ImageHeader header() const override { return header_; }

  void rows(int count, std::uint8_t* pixels) override {
    const std::size_t rowBytes = std::size_t(header_.width) * std::size_t(header_.channels);
    if (interlaced_) {
      readInterlaced(rowBytes);
      std::memcpy(pixels, allRows_.data() + std::size_t(nextRow_) * rowBytes, std::size_t(count) * rowBytes);
    } else {
      guard_.run([=, this] {
        for (int i = 0; i < count; ++i) png_read_row(png_, pixels + std::size_t(i) * rowBytes, nullptr);
      });
    }
    nextRow_ += count;
    if (nextRow_ == header_.height) guard_.run([this] { png_read_end(png_, nullptr); });
  }

 private:
  // Gives libpng the next `size` bytes of unread_.
  static void copyBytes(png_structp png, png_bytep to, std::size_t size) {
    auto& unread = *static_cast<std::string_view*>(png_get_io_ptr(png));
    if (size > unread.size()) png_error(png, "it is truncated");
    std::memcpy(to, unread.data(), size);
    unread.remove_prefix(size);
  }

  // Fills header_ and interlaced_, and lets libpng convert all kinds of pixels to 8 bits per channel.
  void readHeader() {
    png_set_read_fn(png_, &unread_, copyBytes);
    png_set_keep_unknown_chunks(png_, PNG_HANDLE_CHUNK_NEVER, nullptr, -1);  // skips chunks that do not affect pixels
    constexpr png_uint_32 kNoLimit = 1 << 30;                                // checkSize() checks the size later
    png_set_user_limits(png_, kNoLimit, kNoLimit);
    png_read_info(png_, info_);
    png_set_expand(png_);
    png_set_scale_16(png_);
    interlaced_ = png_set_interlace_handling(png_) > 1;
    png_read_update_info(png_, info_);
    const int channels = png_get_channels(png_, info_);
    header_ = {.width = static_cast<int>(png_get_image_width(png_, info_)),
               .height = static_cast<int>(png_get_image_height(png_, info_)),
               .channels = channels,
               .alphaChannel = channels == 2 || channels == 4 ? channels - 1 : -1};
  }

  // Decodes all rows of an interlaced image into allRows_, unless an earlier call has done so.
  void readInterlaced(std::size_t rowBytes) {
    if (!allRows_.empty()) return;
    allRows_.resize(std::size_t(header_.height) * rowBytes);
    std::vector<png_bytep> rows;
    rows.reserve(static_cast<std::size_t>(header_.height));
    for (int i = 0; i < header_.height; ++i) rows.push_back(allRows_.data() + std::size_t(i) * rowBytes);
    guard_.run([&] { png_read_image(png_, rows.data()); });
  }

  std::string_view unread_;  // the bytes that libpng has not read yet
  png_structp png_ = nullptr;
  png_infop info_ = nullptr;
  JumpGuard guard_;
  ImageHeader header_;
  bool interlaced_ = false;
  std::vector<std::uint8_t> allRows_;  // all rows of an interlaced image
  int nextRow_ = 0;
};

// Maximum number of scans of a progressive JPEG, also in the message of limitScans(). Encoders write about ten, but a
// small hostile file may contain very many, each of which is decoded over the complete image.
constexpr int kMostScans = 500;

class JpegReader final : public ImageReader {
 public:
  explicit JpegReader(std::string_view bytes) {
    jpeg_.err = jpeg_std_error(&errors_);
    jpeg_.client_data = this;
    errors_.error_exit = fail;
    errors_.emit_message = failWhereDamaged;
    errors_.output_message = [](j_common_ptr) {};  // drops messages, which libjpeg would print
    progress_.progress_monitor = limitScans;
    try {
      guard_.run([&] { readHeader(bytes); });
    } catch (...) {
      jpeg_destroy_decompress(&jpeg_);
      throw;
    }
  }
  ~JpegReader() override { jpeg_destroy_decompress(&jpeg_); }
  JpegReader& operator=(JpegReader&&) = delete;  // neither copied nor moved

  bool isOfInks() const { return jpeg_.num_components == 4; }

  ImageHeader header() const override {
    return {.width = static_cast<int>(jpeg_.image_width),
            .height = static_cast<int>(jpeg_.image_height),
            .channels = jpeg_.out_color_components};
  }

  void rows(int count, std::uint8_t* pixels) override {
    const std::size_t rowBytes = std::size_t{jpeg_.image_width} * static_cast<std::size_t>(jpeg_.out_color_components);
    guard_.run([&] {
      if (!started_) jpeg_start_decompress(&jpeg_);
      started_ = true;
      for (int i = 0; i < count; ++i) {
        JSAMPROW row = pixels + static_cast<std::size_t>(i) * rowBytes;
        jpeg_read_scanlines(&jpeg_, &row, 1);
      }
      if (jpeg_.output_scanline == jpeg_.output_height) jpeg_finish_decompress(&jpeg_);
    });
  }

 private:
  static JumpGuard& guardOf(j_common_ptr common) { return static_cast<JpegReader*>(common->client_data)->guard_; }

  [[noreturn]] static void fail(j_common_ptr common) {
    std::array<char, JMSG_LENGTH_MAX> message{};
    common->err->format_message(common, message.data());
    guardOf(common).fail(message.data());
  }

  // Throws if libjpeg warns of damage. libjpeg calls this function with a negative level for warnings, else for traces.
  static void failWhereDamaged(j_common_ptr common, int level) {
    const int code = common->err->msg_code;
    if (level < 0 && code != JWRN_EXTRANEOUS_DATA && code != JWRN_JFIF_MAJOR && code != JWRN_NOT_SEQUENTIAL) {
      fail(common);
    }
  }

  static void limitScans(j_common_ptr common) {
    if (reinterpret_cast<j_decompress_ptr>(common)->input_scan_number <= kMostScans) return;
    guardOf(common).fail("it has more than 500 scans");
  }

  void readHeader(std::string_view bytes) {
    jpeg_create_decompress(&jpeg_);
    jpeg_.progress = &progress_;
    jpeg_mem_src(&jpeg_, reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size());
    jpeg_read_header(&jpeg_, TRUE);
    jpeg_calc_output_dimensions(&jpeg_);
  }

  jpeg_decompress_struct jpeg_{};
  jpeg_error_mgr errors_{};
  jpeg_progress_mgr progress_{};
  JumpGuard guard_;
  bool started_ = false;
};

}  // namespace

std::unique_ptr<ImageReader> openPng(std::string_view bytes) {
  return std::make_unique<PngReader>(bytes);
}

std::unique_ptr<ImageReader> openJpeg(std::string_view bytes) {
  auto reader = std::make_unique<JpegReader>(bytes);
  if (reader->isOfInks()) return nullptr;
  return reader;
}

std::string encodePng(const std::uint8_t* rgb, int width, int height) {
  if (width < 1 || height < 1) throw Error("the PNG could not be encoded: it has no pixels");
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  image.width = static_cast<png_uint_32>(width);
  image.height = static_cast<png_uint_32>(height);
  image.format = PNG_FORMAT_RGB;
  // This flag turns filters off and selects zlib's level 3. Images of points have no gradients, so filters mostly make
  // them larger. Level 9, which this interface does not offer, makes them 1/8 to 1/2 smaller in 6 to 10 times the time.
  image.flags = PNG_IMAGE_FLAG_FAST;
  std::string bytes(PNG_IMAGE_PNG_SIZE_MAX(image), '\0');
  png_alloc_size_t size = bytes.size();
  if (png_image_write_to_memory(&image, bytes.data(), &size, 0, rgb, 0, nullptr) == 0) {
    throw Error(std::string("the PNG could not be encoded: ") + image.message);
  }
  bytes.resize(size);
  return bytes;
}

}  // namespace scanmill
