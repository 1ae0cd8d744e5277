#include "images/images.h"

#include <png.h>

#include <atomic>
#include <cstdio>
#include <cstdlib>
// jpeglib.h includes nothing that it needs.
#include <jpeglib.h>

#include <thread>

#include "base/error.h"
#include "base/file.h"
#include "images/images_interface.h"
#include "tests/support/message_of.h"
#include "tests/support/on_threads.h"
#include "tests/support/temporary_folder.h"

namespace scanmill {
namespace {

using testing::HasSubstr;

std::vector<std::uint8_t> noise(int width, int height) {
  std::vector<std::uint8_t> rgb(static_cast<std::size_t>(width) * static_cast<std::size_t>(height) * 3);
  std::uint32_t state = 1;
  for (std::uint8_t& value : rgb) value = static_cast<std::uint8_t>((state = state * 1664525 + 1013904223) >> 24);
  return rgb;
}

std::vector<std::uint8_t> withoutAlpha(const DecodedImage& image) {
  std::vector<std::uint8_t> rgb;
  for (std::size_t i = 0; i < image.rgba.size(); i += 4) rgb.insert(rgb.end(), &image.rgba[i], &image.rgba[i + 3]);
  return rgb;
}

// TGA: 18 bytes of header, then rows of blue, green, red and alpha, the top one first.
std::string tga(int width, int height, const std::string& pixels, int bits, int alphaBits) {
  std::string header(18, '\0');
  header[2] = 2;
  header[12] = static_cast<char>(width % 256);
  header[13] = static_cast<char>(width / 256);
  header[14] = static_cast<char>(height % 256);
  header[15] = static_cast<char>(height / 256);
  header[16] = static_cast<char>(bits);
  header[17] = static_cast<char>(0x20 | alphaBits);
  return header + pixels;
}

struct JpegKind {
  J_COLOR_SPACE colors = JCS_RGB;
  int channels = 3;
  int quality = 90;
  bool progressive = false;
  std::vector<jpeg_scan_info> scans{};  // in place of the usual ones
};

std::string jpeg(const std::vector<std::uint8_t>& pixels, int width, int height, const JpegKind& kind) {
  jpeg_compress_struct out{};
  jpeg_error_mgr errors{};
  out.err = jpeg_std_error(&errors);
  jpeg_create_compress(&out);
  unsigned char* data = nullptr;
  unsigned long size = 0;  // NOLINT(google-runtime-int): libjpeg's
  jpeg_mem_dest(&out, &data, &size);
  out.image_width = static_cast<JDIMENSION>(width);
  out.image_height = static_cast<JDIMENSION>(height);
  out.input_components = kind.channels;
  out.in_color_space = kind.colors;
  jpeg_set_defaults(&out);
  jpeg_set_quality(&out, kind.quality, TRUE);
  if (kind.progressive) jpeg_simple_progression(&out);
  if (!kind.scans.empty()) {
    out.scan_info = kind.scans.data();
    out.num_scans = static_cast<int>(kind.scans.size());
  }
  jpeg_start_compress(&out, TRUE);
  for (int i = 0; i < height; ++i) {
    JSAMPROW row = const_cast<JSAMPROW>(pixels.data()) + std::ptrdiff_t{i} * width * kind.channels;
    jpeg_write_scanlines(&out, &row, 1);
  }
  jpeg_finish_compress(&out);
  std::string bytes(reinterpret_cast<const char*>(data), size);
  jpeg_destroy_compress(&out);
  std::free(data);
  return bytes;
}

bool isOpenImageIoLoaded() {
  return readFile("/proc/self/maps").find("libOpenImageIO") != std::string::npos;
}

TEST(Images, WhatIsEncodedIsDecoded) {
  const TemporaryFolder folder;
  for (const auto& [width, height] : {std::pair{1, 1}, {1, 7}, {640, 1}, {33, 17}, {256, 256}}) {
    const std::vector<std::uint8_t> rgb = noise(width, height);
    const std::string png = encodePng(rgb.data(), width, height);
    EXPECT_EQ(png, encodePng(rgb.data(), width, height));
    for (const DecodedImage& image : {decodeImage(png, "a"), readImage(folder.write("a.png", png))}) {
      EXPECT_EQ(image.width, static_cast<std::uint32_t>(width));
      EXPECT_EQ(image.height, static_cast<std::uint32_t>(height));
      EXPECT_FALSE(image.hasAlpha);
      EXPECT_EQ(withoutAlpha(image), rgb);
    }
    EXPECT_FALSE(mayHaveAlpha(folder.path() / "a.png"));
  }
}

TEST(Images, NothingIsEncodedWithoutPixels) {
  const std::vector<std::uint8_t> rgb(3);
  EXPECT_THROW(encodePng(rgb.data(), 0, 1), Error);
  EXPECT_THROW(encodePng(rgb.data(), 1, -1), Error);
}

TEST(Images, RowsChannelsAndAlphaAreWhereTheyBelong) {
  const TemporaryFolder folder;
  const auto path = folder.write("a.tga", tga(1, 2, "\1\2\3\x80\4\5\6\xff", 32, 8));
  const DecodedImage image = readImage(path);
  EXPECT_TRUE(image.hasAlpha);
  EXPECT_EQ(image.rgba, (std::vector<std::uint8_t>{3, 2, 1, 0x80, 6, 5, 4, 0xff}));
  EXPECT_EQ(decodeImage(readFile(path), "a.tga").rgba, image.rgba);
  EXPECT_TRUE(mayHaveAlpha(path));
  EXPECT_FALSE(mayHaveAlpha(folder.write("b.tga", tga(1, 1, "\1\2\3", 24, 0))));
  EXPECT_TRUE(mayHaveAlpha(folder.write("c.tga", "no image")));
  EXPECT_TRUE(mayHaveAlpha(folder.path() / "absent.tga"));
}

TEST(Images, DamageIsRefusedAndNamedAndNothingIsPrinted) {
  testing::internal::CaptureStdout();
  testing::internal::CaptureStderr();
  const std::vector<std::uint8_t> rgb = noise(16, 16);
  const std::string png = encodePng(rgb.data(), 16, 16);
  for (std::size_t i = 0; i < png.size(); ++i) {
    EXPECT_THAT(messageOf([&] { decodeImage(std::string_view(png).substr(0, i), "a.png"); }), HasSubstr("a.png: "))
        << i << " of " << png.size() << " bytes";
    std::string text = png;
    text[i] = static_cast<char>(~text[i]);
    try {
      EXPECT_EQ(withoutAlpha(decodeImage(text, "a.png")), rgb) << i;
    } catch (const InputError& e) {
      EXPECT_THAT(e.what(), HasSubstr("a.png: "));
    }
  }
  EXPECT_THROW(decodeImage({}, "a.png"), InputError);
  EXPECT_THROW(decodeImage("text", ""), InputError);
  EXPECT_THROW(readImage("/absent/a.png"), InputError);
  EXPECT_EQ(testing::internal::GetCapturedStdout(), "");
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

TEST(Images, SizesAreLimitedByTheHeader) {
  EXPECT_EQ(decodeImage(tga(16384, 1, std::string(16384 * 3, 'x'), 24, 0), "a.tga").width, 4096u);
  EXPECT_THAT(messageOf([] { decodeImage(tga(16385, 1, std::string(16385 * 3, 'x'), 24, 0), "a.tga"); }),
              HasSubstr("a.tga: the image of 16385 x 1 pixels is larger than 16384 x 16384"));
}

// 12 runs of 128 pixels each, which say that they are 16384 x 16384.
TEST(Images, FewBytesDoNotHoldManyPixels) {
  std::string bomb = tga(16384, 16384, "", 24, 0);
  bomb[2] = 10;  // runs
  for (int i = 0; i < 12; ++i) bomb += "\xff\1\2\3";
  const TemporaryFolder folder;
  const auto file = folder.write("a.tga", bomb);
  for (const std::string& message :
       {messageOf([&] { decodeImage(bomb, "a.tga"); }), messageOf([&] { readImage(file); })}) {
    EXPECT_THAT(message, HasSubstr("a.tga: the image is damaged: its 66 bytes cannot hold 16384 x 16384 pixels"));
  }
  std::string png = encodePng(noise(4, 4).data(), 4, 4);
  png.replace(16, 8, std::string("\0\0\x40\0\0\0\x40\0", 8));  // and its checksum
  png.replace(29, 4, std::string("\x26\xaa\x87\xd3", 4));
  EXPECT_THAT(messageOf([&] { decodeImage(png, "b.png"); }), HasSubstr("bytes cannot hold 16384 x 16384 pixels"));
}

// By their mean light, and by alpha.
TEST(Images, LargeOnesAreReducedToWhatIsNeeded) {
  constexpr int kWidth = 10000;  // by 3
  constexpr int kHeight = 7;
  std::vector<std::uint8_t> rgb(std::size_t{kWidth} * kHeight * 3, 0);
  for (std::size_t i = 0; i < rgb.size(); i += 3) {
    if (i / 3 % kWidth % 3 == 0) rgb[i] = 255;
    rgb[i + 1] = 200;
  }
  const DecodedImage image = decodeImage(encodePng(rgb.data(), kWidth, kHeight), "a.png");
  EXPECT_EQ(image.width, 3334u);
  EXPECT_EQ(image.height, 3u);
  EXPECT_FALSE(image.hasAlpha);
  for (std::size_t i = 0; i + 4 < std::size_t{3333} * 4; i += 4) {
    ASSERT_EQ(image.rgba[i], 156) << i;  // a third of the light: 1.055 * (1/3)^(1/2.4) - 0.055 = 0.6124
    ASSERT_EQ(image.rgba[i + 1], 200) << i;
    ASSERT_EQ(image.rgba[i + 3], 255) << i;
  }
  EXPECT_EQ(image.rgba[std::size_t{3333} * 4], 255);  // the last column, alone

  // Blue that is clear does not colour the red that is not.
  std::string pixels;
  for (int i = 0; i < 4098 * 2; ++i)
    pixels += i % 2 == 0 ? std::string("\xff\0\0\0", 4) : std::string("\0\0\xff\xff", 4);
  const DecodedImage leaf = decodeImage(tga(4098, 2, pixels, 32, 8), "a.tga");
  ASSERT_EQ(leaf.width, 2049u);
  EXPECT_EQ(leaf.height, 1u);
  EXPECT_TRUE(leaf.hasAlpha);
  EXPECT_EQ(std::vector<std::uint8_t>(leaf.rgba.begin(), leaf.rgba.begin() + 4),
            (std::vector<std::uint8_t>{255, 0, 0, 128}));
}

struct PngKind {
  int type = PNG_COLOR_TYPE_RGB;
  int depth = 8;
  bool interlaced = false;
};

std::string png(const PngKind& kind, const std::vector<std::uint8_t>& rows, int width, int height) {
  std::string bytes;
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
  png_infop info = png_create_info_struct(png);
  png_set_write_fn(
      png, &bytes,
      [](png_structp p, png_bytep data, std::size_t size) {
        static_cast<std::string*>(png_get_io_ptr(p))->append(reinterpret_cast<char*>(data), size);
      },
      nullptr);
  png_set_IHDR(png, info, static_cast<png_uint_32>(width), static_cast<png_uint_32>(height), kind.depth, kind.type,
               kind.interlaced ? PNG_INTERLACE_ADAM7 : PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT,
               PNG_FILTER_TYPE_DEFAULT);
  png_set_gAMA(png, info, 0.5);
  std::vector<png_bytep> starts;
  for (int i = 0; i < height; ++i) {
    starts.push_back(const_cast<png_bytep>(rows.data()) +
                     rows.size() / static_cast<std::size_t>(height) * static_cast<std::size_t>(i));
  }
  png_set_rows(png, info, starts.data());
  png_write_png(png, info, PNG_TRANSFORM_IDENTITY, nullptr);
  png_destroy_write_struct(&png, &info);
  return bytes;
}

// Adam7, 16 bit, with gamma and texts: the pixels count.
TEST(Images, PngOfEveryKindIsRead) {
  const std::vector<std::uint8_t> rgb = noise(33, 17);
  for (const bool interlaced : {false, true}) {
    EXPECT_EQ(withoutAlpha(decodeImage(png({.interlaced = interlaced}, rgb, 33, 17), "a")), rgb);
    std::vector<std::uint8_t> deep;
    for (const std::uint8_t value : rgb) deep.insert(deep.end(), {value, value});
    EXPECT_EQ(withoutAlpha(decodeImage(png({.depth = 16, .interlaced = interlaced}, deep, 33, 17), "a")), rgb);
  }
  const DecodedImage gray = decodeImage(png({PNG_COLOR_TYPE_GRAY, 1}, {0b10100000, 0b01000000}, 3, 2), "a");
  EXPECT_EQ(withoutAlpha(gray), (std::vector<std::uint8_t>{255, 255, 255, 0, 0, 0, 255, 255, 255,  //
                                                           0, 0, 0, 255, 255, 255, 0, 0, 0}));
  const DecodedImage clear = decodeImage(png({PNG_COLOR_TYPE_GRAY_ALPHA}, {10, 0, 20, 255}, 2, 1), "a");
  EXPECT_EQ(clear.rgba, (std::vector<std::uint8_t>{10, 10, 10, 0, 20, 20, 20, 255}));
  EXPECT_TRUE(clear.hasAlpha);
}

// Returns what is warned of while an image is decoded.
std::string told(const std::string& bytes, const std::string& name) {
  testing::internal::CaptureStderr();
  decodeImage(bytes, name);
  return testing::internal::GetCapturedStderr();
}

TEST(Images, AnimatedPngHasItsFirstImageAndIsTold) {
  const std::vector<std::uint8_t> rgb = noise(4, 4);
  std::string bytes = png({}, rgb, 4, 4);
  bytes.insert(33, std::string("\0\0\0\10acTL\0\0\0\2\0\0\0\0\xf3\x8d\x93\x70", 20));  // two frames
  EXPECT_THAT(told(bytes, "moves.png"), HasSubstr("moves.png: left out: 1 sets of further images"));
  EXPECT_EQ(withoutAlpha(decodeImage(bytes, "moves.png")), rgb);
}

// A frame of 1 x 1 pixels at column and row 1 of a canvas of 3 x 2.
TEST(Images, GifHasItsCanvas) {
  const std::string gif("GIF89a\3\0\2\0\x80\0\0\xff\0\0\0\xff\0\x2c\1\0\1\0\1\0\1\0\0\2\2\x44\1\0\x3b", 35);
  const DecodedImage image = readImage(TemporaryFolder().write("a.gif", gif));
  ASSERT_EQ(image.rgba.size(), 24u);
  EXPECT_EQ(image.width, 3u);
  for (std::size_t i = 0; i < 6; ++i) EXPECT_EQ(image.rgba[4 * i + 3], i == 4 ? 255 : 0) << i;
}

// A palette of red and green, and the number of the colour that is clear.
TEST(Images, GifIsClearWhereItSaysSo) {
  const std::string gif(
      "GIF89a\1\0\1\0\x80\0\0\xff\0\0\0\xff\0\x21\xf9\4\1\0\0\0\0\x2c\0\0\0\0\1\0\1\0\0\2\2\x44\1\0\x3b", 43);
  EXPECT_TRUE(readImage(TemporaryFolder().write("a.gif", gif)).hasAlpha);
}

// The fourth byte of a pixel of BMP is reserved, and TGA may state that it has no meaning.
TEST(Images, AlphaThatIsZeroEverywhereIsNoneInBmpAndTga) {
  const auto two = [](const std::string& head, int alpha) {
    return head + std::string("\1\2\3", 3) + '\0' + std::string("\4\5\6", 3) + static_cast<char>(alpha);
  };
  std::string tga(18, '\0');
  tga[2] = 2;
  tga[12] = 2;
  tga[14] = 1;
  tga[16] = 32;
  std::string bmp = "BM" + std::string(52, '\0');
  for (const auto& [at, value] :
       {std::pair<std::size_t, char>{2, 62}, {10, 54}, {14, 40}, {18, 2}, {22, 1}, {26, 1}, {28, 32}}) {
    bmp[at] = value;
  }
  for (const auto& [name, head] : {std::pair("a.tga", tga), {"a.bmp", bmp}}) {
    const DecodedImage opaque = decodeImage(two(head, 0), name);
    EXPECT_FALSE(opaque.hasAlpha) << name;
    EXPECT_EQ(opaque.rgba, (std::vector<std::uint8_t>{3, 2, 1, 255, 6, 5, 4, 255})) << name;
    const DecodedImage clear = decodeImage(two(head, 200), name);
    EXPECT_TRUE(clear.hasAlpha) << name;
    EXPECT_EQ(clear.rgba[3], 0) << name;
  }
}

// OpenImageIO reads the same files by the same libjpeg.
TEST(Images, JpegHasThePixelsThatOpenImageIoReads) {
  const std::vector<std::uint8_t> rgb = noise(61, 43);
  for (const JpegKind& kind : {JpegKind{}, JpegKind{.quality = 30}, JpegKind{.progressive = true},
                               JpegKind{.colors = JCS_GRAYSCALE, .channels = 1}}) {
    const std::string bytes = jpeg(rgb, 61, 43, kind);
    const auto reader = moduleOf<ImagesModule>().open("a.jpg", bytes);
    std::vector<std::uint8_t> theirs(std::size_t{61} * 43 * static_cast<std::size_t>(reader->header().channels));
    reader->rows(43, theirs.data());
    std::vector<std::uint8_t> ours = withoutAlpha(decodeImage(bytes, "a.jpg"));
    if (reader->header().channels == 1) {
      for (std::size_t i = 0; i < theirs.size(); ++i) ours[i] = ours[3 * i];
      ours.resize(theirs.size());
    }
    EXPECT_EQ(ours, theirs) << kind.quality << kind.progressive;
  }
}

TEST(Images, JpegOfFourInksIsRead) {
  const std::vector<std::uint8_t> inks(std::size_t{8} * 8 * 4, 255);  // Adobe's: 255 is none of the ink
  const DecodedImage image = decodeImage(jpeg(inks, 8, 8, {.colors = JCS_CMYK, .channels = 4}), "a.jpg");
  EXPECT_FALSE(image.hasAlpha);
  EXPECT_EQ(withoutAlpha(image), std::vector<std::uint8_t>(std::size_t{8} * 8 * 3, 255));
}

TEST(Images, DamagedJpegIsRefusedAndNamedAndNothingIsPrinted) {
  testing::internal::CaptureStdout();
  testing::internal::CaptureStderr();
  const TemporaryFolder folder;
  for (const bool progressive : {false, true}) {
    const std::string bytes = jpeg(noise(16, 16), 16, 16, {.progressive = progressive});
    for (std::size_t i = 1; i + 2 < bytes.size(); ++i) {  // the last two bytes say that it ends
      EXPECT_THAT(messageOf([&] { decodeImage(std::string_view(bytes).substr(0, i), "a.jpg"); }), HasSubstr("a.jpg: "))
          << i;
      std::string text = bytes;
      text[i] = static_cast<char>(~text[i]);
      try {
        decodeImage(text, "a.jpg");
      } catch (const InputError& e) {
        EXPECT_THAT(e.what(), HasSubstr("a.jpg: "));
      }
    }
    EXPECT_THROW(readImage(folder.write("a.jpg", bytes.substr(0, 300))), InputError);
    // Bytes between two segments change no pixel.
    const std::string more = bytes.substr(0, 2) + "\1\2\3" + bytes.substr(2);
    EXPECT_EQ(decodeImage(more, "a.jpg").rgba, decodeImage(bytes, "a.jpg").rgba);
  }
  EXPECT_EQ(testing::internal::GetCapturedStdout(), "");
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

// A scan for each coefficient and colour, and again for each of its last `bits` bits: all of it as the standard allows.
TEST(Images, JpegOfHundredsOfScansIsReadAndOfMoreRefused) {
  const auto scansOf = [](int bits) {
    std::vector<jpeg_scan_info> scans{{3, {0, 1, 2}, 0, 0, 0, 0}};
    for (int left = bits; left >= 0; --left) {
      for (int color = 0; color < 3; ++color) {
        for (int k = 1; k < 64; ++k) scans.push_back({1, {color}, k, k, left == bits ? 0 : left + 1, left});
      }
    }
    return scans;
  };
  const std::vector<std::uint8_t> rgb = noise(16, 16);
  ASSERT_EQ(scansOf(0).size(), 190u);
  EXPECT_EQ(decodeImage(jpeg(rgb, 16, 16, {.scans = scansOf(0)}), "a.jpg").rgba,
            decodeImage(jpeg(rgb, 16, 16, {}), "a.jpg").rgba);
  ASSERT_EQ(scansOf(2).size(), 568u);
  EXPECT_THAT(messageOf([&] { decodeImage(jpeg(rgb, 16, 16, {.scans = scansOf(2)}), "a.jpg"); }),
              HasSubstr("a.jpg: the image cannot be decoded: it has more than 500 scans"));
}

// In a process of its own, in which nothing was loaded yet: `threads` read their first images at the same moment. PNG
// and JPEG do not need OpenImageIO.
[[noreturn]] void firstUse(int threads) {
  std::atomic<int> waiting{threads};
  std::atomic<int> readWithout{0};
  std::atomic<int> right{0};
  onThreads(static_cast<std::size_t>(threads), [&](std::size_t thread) {
    const int width = 20 + static_cast<int>(thread);
    const std::vector<std::uint8_t> rgb = noise(width, 30);
    --waiting;
    while (waiting > 0) std::this_thread::yield();
    const bool same = withoutAlpha(decodeImage(encodePng(rgb.data(), width, 30), "a.png")) == rgb &&
                      decodeImage(jpeg(rgb, width, 30, {}), "a.jpg").width == static_cast<unsigned>(width);
    if (same && !isOpenImageIoLoaded()) ++right;
    ++readWithout;
    while (readWithout < threads) std::this_thread::yield();
    if (decodeImage(tga(1, 1, "\1\2\3", 24, 0), "a.tga").rgba[0] == 3) ++right;
  });
  std::exit(isOpenImageIoLoaded() && right == 2 * threads ? 0 : 1);
}

TEST(ImagesModule, IsLoadedAtTheFirstUseByAnyNumberOfThreads) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");  // which starts this program anew
  for (const int threads : {1, 2, 8}) EXPECT_EXIT(firstUse(threads), testing::ExitedWithCode(0), "");
}

}  // namespace
}  // namespace scanmill
