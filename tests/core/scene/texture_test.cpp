#include "scene/texture.h"

#include <OpenImageIO/imageio.h>

#include <vector>

#include "base/file.h"
#include "base/input_budget.h"
#include "images/images.h"
#include "tests/support/message_of.h"
#include "tests/support/temporary_folder.h"

namespace scanmill {
namespace {

using testing::HasSubstr;

// `pixels` as files have them: the top row first. Floats are light from 0 to 1, multiplied by alpha.
template <class Value>
void writeImage(const std::filesystem::path& path, int width, int height, int channels,
                const std::vector<Value>& pixels, int tile = 0) {
  auto output = OIIO::ImageOutput::create(path.string());
  ASSERT_TRUE(output) << OIIO::geterror();
  OIIO::ImageSpec spec(width, height, channels, OIIO::BaseTypeFromC<Value>::value);
  spec.tile_width = spec.tile_height = tile;
  if (sizeof(Value) == 1) spec.attribute("oiio:UnassociatedAlpha", 1);
  spec.attribute("CompressionQuality", 100);
  ASSERT_TRUE(output->open(path.string(), spec)) << output->geterror();
  ASSERT_TRUE(output->write_image(OIIO::BaseTypeFromC<Value>::value, pixels.data())) << output->geterror();
  ASSERT_TRUE(output->close());
}

std::vector<int> texel(const Texture& texture, float u, float v) {
  const std::uint8_t* rgba = texture.texel(u, v);
  return {rgba[0], rgba[1], rgba[2], rgba[3]};
}

using Bytes = std::vector<std::uint8_t>;

const std::vector<int> kRed{255, 0, 0, 255}, kGreen{0, 255, 0, 255}, kBlue{0, 0, 255, 255}, kGrey{128, 128, 128, 255};

// A texture that another scene holds is read once, but belongs to the files of both.
TEST(Texture, IsAFileReadOfEachWhoLoadsIt) {
  const TemporaryFolder folder;
  writeImage(folder.path() / "a.png", 1, 1, 3, Bytes{1, 2, 3});
  const auto held = loadTexture(folder.path() / "a.png");
  const FilesRead read;
  EXPECT_EQ(loadTexture(folder.path() / "a.png"), held);
  EXPECT_EQ(read.hashes().size(), 1u);
}

TEST(Texture, FirstRowIsTheBottomAndCoordinatesRepeat) {
  const TemporaryFolder folder;
  for (const char* name : {"a.png", "a.tga", "a.rgb", "a.bmp", "a.tif"}) {
    writeImage(folder.path() / name, 2, 2, 3, Bytes{255, 0, 0, 0, 255, 0, 0, 0, 255, 128, 128, 128});
    const auto texture = loadTexture(folder.path() / name);
    ASSERT_EQ(texture->width, 2u) << name;
    ASSERT_EQ(texture->height, 2u);
    EXPECT_FALSE(texture->hasAlpha);
    EXPECT_EQ(texel(*texture, 0.25f, 0.75f), kRed) << name;
    EXPECT_EQ(texel(*texture, 0.75f, 0.75f), kGreen) << name;
    EXPECT_EQ(texel(*texture, 0.25f, 0.25f), kBlue) << name;
    EXPECT_EQ(texel(*texture, 0.75f, 0.25f), kGrey) << name;
    for (const float shift : {-3.0f, -1.0f, 1.0f, 7.0f}) {
      EXPECT_EQ(texel(*texture, 0.25f + shift, 0.75f - shift), kRed);
      EXPECT_EQ(texel(*texture, 0.75f - shift, 0.25f + shift), kGrey);
    }
  }
}

TEST(Texture, AnyCoordinateHasATexel) {
  Texture texture{.file = "", .width = 3, .height = 2, .rgba = std::vector<std::uint8_t>(24, 7)};
  for (const float u : {0.0f, 1.0f, -0.0f, -1e-9f, 1e30f, -1e30f, std::nextafter(1.0f, 0.0f), INFINITY, NAN}) {
    for (const float v : {0.0f, 1.0f, -1e-9f, 1e30f, -INFINITY, NAN}) {
      const std::uint8_t* found = texture.texel(u, v);
      EXPECT_GE(found, texture.rgba.data());
      EXPECT_LE(found + 4, texture.rgba.data() + texture.rgba.size());
    }
  }
  texture.rgba[8] = 9;  // the last of the first row
  EXPECT_EQ(texture.texel(-1e-3f, 0)[0], 9);
}

TEST(Texture, AlphaIsKeptAndColourIsNotMultipliedByIt) {
  const TemporaryFolder folder;
  for (const char* name : {"a.png", "a.tga", "a.webp", "a.bmp", "a.sgi", "a.tif"}) {
    std::vector<std::uint8_t> pixels;
    for (int i = 0; i < 32 * 32; ++i) {
      pixels.insert(pixels.end(), {200, 100, 50, static_cast<std::uint8_t>(i % 32 < 16 ? 255 : 204)});
    }
    writeImage(folder.path() / name, 32, 32, 4, pixels);
    const auto texture = loadTexture(folder.path() / name);
    EXPECT_TRUE(texture->hasAlpha) << name;
    const int tolerance = std::string(name) == "a.webp" ? 12 : 0;  // it loses a little
    for (const float u : {0.25f, 0.75f}) {
      const std::vector<int> found = texel(*texture, u, 0.5f);
      EXPECT_NEAR(found[0], 200, tolerance) << name;
      EXPECT_NEAR(found[1], 100, tolerance) << name;
      EXPECT_NEAR(found[2], 50, tolerance) << name;
      EXPECT_EQ(found[3], u < 0.5f ? 255 : 204) << name;
    }
    EXPECT_TRUE(mayHaveAlpha(folder.path() / name));
  }
  writeImage(folder.path() / "opaque.png", 1, 1, 4, Bytes{1, 2, 3, 255});
  EXPECT_FALSE(loadTexture(folder.path() / "opaque.png")->hasAlpha);
  writeImage(folder.path() / "plain.png", 1, 1, 3, Bytes{1, 2, 3});
  EXPECT_FALSE(mayHaveAlpha(folder.path() / "plain.png"));
}

// 0.5 of the light is 188 in sRGB (IEC 61966-2-1).
TEST(Texture, FloatsAreLinearLight) {
  const TemporaryFolder folder;
  for (const char* name : {"a.exr", "a.hdr", "a.tif"}) {
    writeImage(folder.path() / name, 1, 1, 3, std::vector{0.5f, 2.0f, 0.0f});
    EXPECT_EQ(texel(*loadTexture(folder.path() / name), 0, 0), (std::vector{188, 255, 0, 255})) << name;
  }
  writeImage(folder.path() / "opacity.tif", 1, 1, 1, std::vector{0.5f});
  EXPECT_EQ(texel(*loadTexture(folder.path() / "opacity.tif"), 0, 0)[0], 128);
  writeImage(folder.path() / "luminance.exr", 1, 1, 1, std::vector{0.5f});  // its channel is called Y
  EXPECT_EQ(texel(*loadTexture(folder.path() / "luminance.exr"), 0, 0)[0], 188);
  EXPECT_EQ(withOpacity(nullptr, *loadTexture(folder.path() / "luminance.exr"))->rgba[3], 128);
  for (const int tile : {0, 16}) {
    std::vector<float> pixels;
    for (int i = 0; i < 32 * 32; ++i) pixels.insert(pixels.end(), {0.25f, 0.5f, 0, 0.5f});
    const auto path = folder.path() / (tile == 0 ? "rows.exr" : "tiles.exr");
    writeImage(path, 32, 32, 4, pixels, tile);
    EXPECT_EQ(texel(*loadTexture(path), 0.9f, 0.1f), (std::vector{188, 255, 0, 128})) << tile;
  }
}

TEST(Texture, FurtherImagesAndChannelsAreTold) {
  const TemporaryFolder folder;
  const auto several = folder.path() / "several.tif";
  const OIIO::ImageSpec spec(1, 1, 5, OIIO::TypeDesc::UINT8);
  const std::vector<std::uint8_t> pixels{1, 2, 3, 255, 9};
  const auto output = OIIO::ImageOutput::create(several.string());
  for (const auto mode : {OIIO::ImageOutput::Create, OIIO::ImageOutput::AppendSubimage}) {
    ASSERT_TRUE(output->open(several.string(), spec, mode)) << output->geterror();
    ASSERT_TRUE(output->write_image(OIIO::TypeDesc::UINT8, pixels.data())) << output->geterror();
  }
  ASSERT_TRUE(output->close());
  testing::internal::CaptureStderr();
  EXPECT_EQ(texel(*loadTexture(several), 0, 0), (std::vector{1, 2, 3, 255}));
  EXPECT_THAT(
      testing::internal::GetCapturedStderr(),
      HasSubstr(
          "several.tif: left out: 1 channels that are neither colour nor alpha, 1 sets of further images (the first "
          "image counts)"));
}

TEST(Texture, ExrOfTwoWindowsIsRefused) {
  const TemporaryFolder folder;
  const std::string path = (folder.path() / "window.exr").string();
  OIIO::ImageSpec spec(3, 2, 3, OIIO::TypeDesc::FLOAT);
  spec.full_width = 4;
  const auto output = OIIO::ImageOutput::create(path);
  ASSERT_TRUE(output->open(path, spec) && output->write_image(OIIO::TypeDesc::FLOAT, std::vector<float>(18).data()) &&
              output->close());
  EXPECT_THAT(messageOf([&] { loadTexture(path); }),
              HasSubstr("window.exr: the image cannot be read: its data window"));
}

TEST(Texture, ExrWithFurtherPartsOrWithoutAColourIsTold) {
  const TemporaryFolder folder;
  const std::string parts = (folder.path() / "parts.exr").string(), red = (folder.path() / "red.exr").string();
  OIIO::ImageSpec spec(1, 1, 3, OIIO::TypeDesc::FLOAT);
  const std::vector<float> pixels{0.5f, 0.5f, 0.5f};
  const auto output = OIIO::ImageOutput::create(parts);
  ASSERT_TRUE(output->open(parts, 2, std::vector{spec, spec}.data()));
  ASSERT_TRUE(output->write_image(OIIO::TypeDesc::FLOAT, pixels.data()));
  ASSERT_TRUE(output->open(parts, spec, OIIO::ImageOutput::AppendSubimage));
  ASSERT_TRUE(output->write_image(OIIO::TypeDesc::FLOAT, pixels.data()));
  ASSERT_TRUE(output->close());
  spec = OIIO::ImageSpec(1, 1, 1, OIIO::TypeDesc::FLOAT);
  spec.channelnames = {"R"};
  ASSERT_TRUE(output->open(red, spec) && output->write_image(OIIO::TypeDesc::FLOAT, pixels.data()));
  ASSERT_TRUE(output->close());
  testing::internal::CaptureStderr();
  EXPECT_EQ(texel(*loadTexture(parts), 0, 0), texel(*loadTexture(red), 0, 0));
  EXPECT_THAT(testing::internal::GetCapturedStderr(),
              testing::AllOf(HasSubstr("parts.exr: left out: 1 sets of further images (the first image counts)\n"),
                             HasSubstr("red.exr: left out: 1 images without red, green or blue (EXR; ")));
}

TEST(Texture, IsDecodedOnceWhileItIsHeld) {
  const TemporaryFolder folder;
  const auto path = folder.path() / "a.png";
  writeImage(path, 1, 1, 3, Bytes{1, 2, 3});
  const auto first = loadTexture(path);
  EXPECT_EQ(first, loadTexture(folder.path() / "." / "a.png"));
  writeImage(path, 1, 1, 3, Bytes{4, 5, 6});
  std::filesystem::last_write_time(path, std::filesystem::last_write_time(path) + std::chrono::seconds(5));
  EXPECT_EQ(loadTexture(path)->rgba[0], 4);
}

TEST(Texture, LuminanceFollowsTheStandards) {
  const std::uint8_t white[] = {255, 255, 255}, black[] = {0, 0, 0}, grey[] = {128, 128, 128}, green[] = {0, 255, 0};
  EXPECT_NEAR(luminance(white), 1, 1e-6);
  EXPECT_EQ(luminance(black), 0);
  EXPECT_NEAR(luminance(grey), 0.21586, 1e-5);
  EXPECT_NEAR(luminance(green), 0.7152, 1e-6);
  const Texture texture{.file = "", .width = 2, .height = 1, .rgba = {255, 255, 255, 255, 0, 0, 0, 10}};
  EXPECT_NEAR(meanLuminance(texture), 0.5, 1e-6);
  EXPECT_NEAR(meanLuminance(texture, 0.5f), 1, 1e-6);
}

TEST(Texture, OpacityMapBecomesAlpha) {
  const Texture color{.file = "", .width = 1, .height = 1, .rgba = {10, 20, 30, 255}};
  Texture map{.file = "", .width = 2, .height = 1, .rgba = {0, 0, 0, 255, 255, 255, 255, 255}};
  const auto joined = withOpacity(&color, map);
  EXPECT_EQ(joined->width, 2u);
  EXPECT_TRUE(joined->hasAlpha);
  EXPECT_EQ(joined->rgba, (std::vector<std::uint8_t>{10, 20, 30, 0, 10, 20, 30, 255}));
  EXPECT_EQ(withOpacity(nullptr, map, true)->rgba, (std::vector<std::uint8_t>{255, 255, 255, 255, 255, 255, 255, 0}));
  map.rgba = {0, 0, 0, 200, 255, 255, 255, 100};
  map.hasAlpha = true;
  EXPECT_EQ(withOpacity(&color, map)->rgba[3], 200);
}

TEST(Texture, BadFilesAreNamedAndNothingIsPrinted) {
  const TemporaryFolder folder;
  testing::internal::CaptureStdout();
  testing::internal::CaptureStderr();
  std::vector<std::uint8_t> pixels(64 * 64 * 3);
  for (std::size_t i = 0; i < pixels.size(); ++i) pixels[i] = static_cast<std::uint8_t>(i * i);
  int refused = 0;
  for (const char* name : {"a.png", "a.jpg", "a.webp", "a.tga", "a.rgb", "a.bmp", "a.tif"}) {
    const auto path = folder.path() / name;
    writeImage(path, 64, 64, 3, pixels);
    const std::string whole = readFile(path);
    for (std::size_t k = 0; k < 50; ++k) {
      std::string text = whole.substr(0, whole.size() * (k / 2) / 25);
      if (k % 2 == 1) {
        text = whole;
        text[whole.size() * k / 50] = static_cast<char>(~text[whole.size() * k / 50]);
      }
      folder.write(name, text);
      for (const bool memory : {false, true}) {
        try {
          const auto texture = memory ? decodeTexture(readFile(path), path.string()) : loadTexture(path);
          EXPECT_EQ(texture->rgba.size(), std::size_t{texture->width} * texture->height * 4);
        } catch (const InputError& e) {
          EXPECT_THAT(e.what(), HasSubstr(name));
          ++refused;
        }
      }
    }
    folder.write(name, "this is not an image at all, but a text of some length");
    EXPECT_THROW(loadTexture(path), InputError);
  }
  EXPECT_THROW(loadTexture(folder.path() / "absent.png"), InputError);
  EXPECT_THROW(loadTexture(folder.path()), InputError);
  EXPECT_EQ(testing::internal::GetCapturedStdout(), "");
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
  EXPECT_GT(refused, 100);
}

}  // namespace
}  // namespace scanmill
