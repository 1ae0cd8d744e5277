#include "images/images.h"

#include <dlfcn.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <png.h>

#include <atomic>
#include <cstdint>
#include <cstdlib>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "base/error.h"
#include "base/file.h"
#include "images/images_interface.h"
#include "tests/support/message_of.h"
#include "tests/support/shared_data.h"
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
    try {
      decodeImage(std::string_view(png).substr(0, i), "a.png");
      ADD_FAILURE() << i << " of " << png.size() << " bytes";
    } catch (const InputError& e) {
      EXPECT_THAT(e.what(), HasSubstr("a.png: "));
    }
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
  try {
    decodeImage(tga(16385, 1, std::string(16385 * 3, 'x'), 24, 0), "a.tga");
    FAIL();
  } catch (const InputError& e) {
    EXPECT_THAT(e.what(), HasSubstr("a.tga: the image of 16385 x 1 pixels is larger than 16384 x 16384"));
  }
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

// Adam7, 16 bit, with colour profiles and texts: the pixels count.
TEST(Images, PngOfEveryKindIsRead) {
  const auto encoded = [](int type, int depth, bool interlaced, const std::vector<std::uint8_t>& rows, int width,
                          int height) {
    std::string bytes;
    png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
    png_infop info = png_create_info_struct(png);
    png_set_write_fn(
        png, &bytes,
        [](png_structp p, png_bytep data, std::size_t size) {
          static_cast<std::string*>(png_get_io_ptr(p))->append(reinterpret_cast<char*>(data), size);
        },
        nullptr);
    png_set_IHDR(png, info, static_cast<png_uint_32>(width), static_cast<png_uint_32>(height), depth, type,
                 interlaced ? PNG_INTERLACE_ADAM7 : PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT,
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
  };
  const std::vector<std::uint8_t> rgb = noise(33, 17);
  for (const bool interlaced : {false, true}) {
    EXPECT_EQ(withoutAlpha(decodeImage(encoded(PNG_COLOR_TYPE_RGB, 8, interlaced, rgb, 33, 17), "a")), rgb);
    std::vector<std::uint8_t> deep;
    for (const std::uint8_t value : rgb) deep.insert(deep.end(), {value, value});
    EXPECT_EQ(withoutAlpha(decodeImage(encoded(PNG_COLOR_TYPE_RGB, 16, interlaced, deep, 33, 17), "a")), rgb);
  }
  const DecodedImage gray = decodeImage(encoded(PNG_COLOR_TYPE_GRAY, 1, false, {0b10100000, 0b01000000}, 3, 2), "a");
  EXPECT_EQ(withoutAlpha(gray), (std::vector<std::uint8_t>{255, 255, 255, 0, 0, 0, 255, 255, 255,  //
                                                           0, 0, 0, 255, 255, 255, 0, 0, 0}));
  const DecodedImage clear = decodeImage(encoded(PNG_COLOR_TYPE_GRAY_ALPHA, 8, false, {10, 0, 20, 255}, 2, 1), "a");
  EXPECT_EQ(clear.rgba, (std::vector<std::uint8_t>{10, 10, 10, 0, 20, 20, 20, 255}));
  EXPECT_TRUE(clear.hasAlpha);
}

TEST(Images, TheTownsTexturesAreDecoded) {
  SKIP_WITHOUT_SHARED_DATA("scenes/truck_town");
  int count = 0;
  for (const auto& file : std::filesystem::directory_iterator(sharedData() / "scenes/truck_town/model/textures")) {
    if (file.path().extension() != ".webp" || ++count > 8) continue;
    const DecodedImage image = readImage(file.path());
    EXPECT_EQ(image.rgba.size(), std::size_t{image.width} * image.height * 4) << file.path();
    EXPECT_EQ(decodeImage(readFile(file.path()), "a.webp").rgba, image.rgba) << file.path();
  }
  EXPECT_GT(count, 0);
}

// In a process of its own, in which nothing was loaded yet: `threads` meet their first image at the same moment.
[[noreturn]] void firstUse(int threads) {
  const bool before = isOpenImageIoLoaded();
  std::atomic<int> waiting{threads};
  std::atomic<int> right{0};
  {
    std::vector<std::jthread> pool;
    for (int i = 0; i < threads; ++i) {
      pool.emplace_back([&, i] {
        const std::vector<std::uint8_t> rgb = noise(20 + i, 30);
        --waiting;
        while (waiting > 0) std::this_thread::yield();
        if (withoutAlpha(decodeImage(encodePng(rgb.data(), 20 + i, 30), "a.png")) == rgb) ++right;
      });
    }
  }
  std::exit(!before && isOpenImageIoLoaded() && right == threads ? 0 : 1);
}

TEST(ImagesModule, IsLoadedAtTheFirstUseByAnyNumberOfThreads) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");  // which starts this program anew
  for (const int threads : {1, 2, 8}) EXPECT_EXIT(firstUse(threads), testing::ExitedWithCode(0), "");
}

std::string loadFailure(const std::vector<std::string>& folders) {
  try {
    loadModule<ImagesModule>(folders);
  } catch (const InputError& e) {
    ADD_FAILURE() << "is no error of the input: " << e.what();
  } catch (const Error& e) {
    return e.what();
  }
  ADD_FAILURE() << "was loaded";
  return {};
}

TEST(ImagesModule, SaysWhatIsMissing) {
  const TemporaryFolder folder;
  const std::string missing = loadFailure({folder.path(), "/absent"});
  EXPECT_THAT(missing, HasSubstr("looked for " + folder.path().string() + "/libscanmill_images.so, /absent/lib"));
  EXPECT_THAT(missing, HasSubstr("cmake --install"));
  const std::string garbage = loadFailure({"/absent", folder.write("libscanmill_images.so", "text").parent_path()});
  EXPECT_THAT(garbage, HasSubstr(folder.path().string() + "/libscanmill_images.so cannot be loaded: "));
  EXPECT_THAT(garbage, HasSubstr("libopenimageio-dev"));
  std::filesystem::remove(folder.path() / "libscanmill_images.so");
  Dl_info other{};
  ASSERT_NE(dladdr(reinterpret_cast<void*>(&std::exit), &other), 0);
  std::filesystem::create_symlink(other.dli_fname, folder.path() / "libscanmill_images.so");
  EXPECT_THAT(loadFailure({folder.path()}), HasSubstr("another version"));
}

}  // namespace
}  // namespace scanmill
