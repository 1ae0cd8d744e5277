#include <cstdio>

#include "images/metadata.h"
#include "images/readers.h"
// jpeglib.h does not include the headers that it needs.
#include <jerror.h>
#include <jpeglib.h>

#include <array>
#include <csetjmp>
#include <cstddef>
#include <cstdint>
#include <stdexcept>

namespace scanmill {

namespace {

// Maximum number of scans of a progressive JPEG: encoders write about ten, but a small hostile file may contain very
// many, each of which is decoded over the complete image.
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
      guarded([&] { readHeader(bytes); });
    } catch (...) {
      jpeg_destroy_decompress(&jpeg_);
      throw;
    }
  }
  ~JpegReader() override { jpeg_destroy_decompress(&jpeg_); }
  JpegReader(const JpegReader&) = delete;
  JpegReader& operator=(const JpegReader&) = delete;

  bool isOfInks() const { return jpeg_.num_components == 4; }

  ImageHeader header() const override {
    ImageHeader header{static_cast<int>(jpeg_.image_width), static_cast<int>(jpeg_.image_height),
                       jpeg_.out_color_components, -1, 0};
    constexpr std::string_view kExif("Exif\0\0", 6);
    constexpr std::string_view kProfile("ICC_PROFILE\0", 12);
    bool profiled = false, srgb = false;  // a profile may be stored in several pieces
    for (const jpeg_marker_struct* marker = jpeg_.marker_list; marker != nullptr; marker = marker->next) {
      const std::string_view data(reinterpret_cast<const char*>(marker->data), marker->data_length);
      if (data.starts_with(kExif) && isTurned(data.substr(kExif.size()))) header.leftOut.emplace_back(kOrientations);
      profiled = profiled || data.starts_with(kProfile);
      srgb = srgb || (data.starts_with(kProfile) && isSrgb(data));
    }
    if (profiled && !srgb) header.leftOut.emplace_back(kProfiles);
    return header;
  }

  void rows(int count, std::uint8_t* pixels) override {
    const std::size_t rowBytes = std::size_t{jpeg_.image_width} * static_cast<std::size_t>(jpeg_.out_color_components);
    guarded([&] {
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
  // libjpeg jumps back into this function when it fails: `work` must not contain objects that need to be destroyed.
  template <class Work>
  void guarded(const Work& work) {
    if (setjmp(jump_) != 0) throw std::runtime_error(message_.data());
    work();
  }

  [[noreturn]] static void fail(j_common_ptr common) {
    JpegReader& self = *static_cast<JpegReader*>(common->client_data);
    common->err->format_message(common, self.message_.data());
    std::longjmp(self.jump_, 1);
  }

  // libjpeg calls this function with a negative level for a warning, and with other levels for traces of its work.
  static void failWhereDamaged(j_common_ptr common, int level) {
    const int code = common->err->msg_code;
    if (level < 0 && code != JWRN_EXTRANEOUS_DATA && code != JWRN_JFIF_MAJOR && code != JWRN_NOT_SEQUENTIAL) {
      fail(common);
    }
  }

  static void limitScans(j_common_ptr common) {
    if (reinterpret_cast<j_decompress_ptr>(common)->input_scan_number <= kMostScans) return;
    JpegReader& self = *static_cast<JpegReader*>(common->client_data);
    std::snprintf(self.message_.data(), self.message_.size(), "it has more than %d scans", kMostScans);
    std::longjmp(self.jump_, 1);
  }

  void readHeader(std::string_view bytes) {
    jpeg_create_decompress(&jpeg_);
    jpeg_.progress = &progress_;
    jpeg_mem_src(&jpeg_, reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size());
    jpeg_save_markers(&jpeg_, JPEG_APP0 + 1, 0xFFFF);
    jpeg_save_markers(&jpeg_, JPEG_APP0 + 2, 0xFFFF);
    jpeg_read_header(&jpeg_, TRUE);
    jpeg_calc_output_dimensions(&jpeg_);
  }

  jpeg_decompress_struct jpeg_{};
  jpeg_error_mgr errors_{};
  jpeg_progress_mgr progress_{};
  std::jmp_buf jump_{};
  std::array<char, JMSG_LENGTH_MAX> message_{};
  bool started_ = false;
};

}  // namespace

std::unique_ptr<ImageReader> openJpeg(std::string_view bytes) {
  auto reader = std::make_unique<JpegReader>(bytes);
  if (reader->isOfInks()) return nullptr;
  return reader;
}

}  // namespace scanmill
