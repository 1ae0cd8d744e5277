#include "passes/pass_image.h"

#include "tests/support/message_of.h"

namespace scanmill {
namespace {

constexpr PassChoice kAllPasses{Channels::all(), true};

// Every value of pixel i of image k follows from 1000 * k + i.
PassImage numbered(std::uint32_t image, std::uint32_t width, std::uint32_t height, PassChoice choice = kAllPasses) {
  PassImage made{squareCamera(width, height, 1.0), {}};
  made.camera.name = "camera" + std::to_string(image);
  made.planes.reset(made.camera.pixels(), choice);
  for (std::uint32_t i = 0; i < made.camera.pixels(); ++i) {
    const std::uint32_t n = 1000 * image + i;
    const auto f = static_cast<float>(n);
    const auto fill = [&](auto& plane, auto value) {
      using Value = typename std::remove_reference_t<decltype(plane)>::value_type;
      if (!plane.empty()) plane[i] = static_cast<Value>(value);
    };
    fill(made.planes.depth, f + 1);
    if (!made.planes.normal.empty()) made.planes.normal[i] = {f, f + 0.25f, f + 0.5f};
    fill(made.planes.instance, n + 2);
    fill(made.planes.semantic, n + 3);
    fill(made.planes.material, n + 4);
    fill(made.planes.primitive, n + 5);
    fill(made.planes.reflectance, f + 6);
    fill(made.planes.roughness, f + 7);
    fill(made.planes.metallic, f + 8);
    fill(made.planes.retroreflectance, f + 9);
  }
  return made;
}

TEST(PassPlanes, HoldWhatWasAskedForAndSaySo) {
  for (const Channel channel : {Channel::Normal, Channel::Instance, Channel::Semantic, Channel::Material,
                                Channel::Primitive, Channel::Reflectance}) {
    for (const bool surfaceParameters : {false, true}) {
      PassPlanes planes;
      planes.reset(7, kAllPasses);
      planes.reset(5, {Channel::Range | channel, surfaceParameters});
      EXPECT_EQ(planes.size(), 5u);
      EXPECT_EQ(planes.choice(), (PassChoice{Channel::Range | channel, surfaceParameters}));
    }
  }
}

TEST(ImageSource, GivesEachPixelFromItsImage) {
  const std::vector<PassImage> images{numbered(0, 8, 4), numbered(1, 3, 3), numbered(2, 16, 2)};
  ImageSource source(images);
  ASSERT_EQ(source.cameras().size(), 3u);
  EXPECT_EQ(source.available().surfaceParameters, true);
  const std::vector<PixelAddress> addresses{0, 31, 32, 40, 41, 72, kNoPixel, 5, 5};
  const std::vector<std::uint32_t> expected{0, 31, 1000, 1008, 2000, 2031, 0, 5, 5};
  PassPlanes planes;
  source.fetch(addresses, kAllPasses, planes);
  ASSERT_EQ(planes.size(), addresses.size());
  for (std::size_t i = 0; i < addresses.size(); ++i) {
    if (addresses[i] == kNoPixel) {
      EXPECT_EQ(planes.depth[i], kNoDepth);
      EXPECT_EQ(planes.normal[i], Vec3f{});
      EXPECT_EQ(planes.instance[i], 0u);
      EXPECT_EQ(planes.roughness[i], 0.0f);
      continue;
    }
    const auto f = static_cast<float>(expected[i]);
    EXPECT_EQ(planes.depth[i], f + 1);
    EXPECT_EQ(planes.normal[i], (Vec3f{f, f + 0.25f, f + 0.5f}));
    EXPECT_EQ(planes.instance[i], expected[i] + 2);
    EXPECT_EQ(planes.semantic[i], expected[i] + 3);
    EXPECT_EQ(planes.material[i], expected[i] + 4);
    EXPECT_EQ(planes.primitive[i], expected[i] + 5);
    EXPECT_EQ(planes.reflectance[i], f + 6);
    EXPECT_EQ(planes.roughness[i], f + 7);
    EXPECT_EQ(planes.metallic[i], f + 8);
    EXPECT_EQ(planes.retroreflectance[i], f + 9);
  }
}

TEST(ImageSource, ManyPixelsComeInTheirOrder) {
  const std::vector<PassImage> images{numbered(0, 100, 10), numbered(1, 100, 10)};
  ImageSource source(images);
  std::vector<PixelAddress> addresses(100'000);
  for (std::size_t i = 0; i < addresses.size(); ++i) addresses[i] = static_cast<PixelAddress>(i * 7919 % 2000);
  PassPlanes planes;
  source.fetch(addresses, {Channel::Instance, false}, planes);
  EXPECT_TRUE(planes.normal.empty());
  for (std::size_t i = 0; i < addresses.size(); ++i) ASSERT_EQ(planes.instance[i], addresses[i] + 2) << i;
}

TEST(ImageSource, AllPixelsReadBackAreTheImages) {
  const std::vector<PassImage> images{numbered(0, 8, 4), numbered(1, 3, 3)};
  ImageSource source(images);
  const std::vector<PassImage> back = readAll(source, kAllPasses);
  ASSERT_EQ(back.size(), images.size());
  for (std::size_t k = 0; k < images.size(); ++k) {
    EXPECT_EQ(back[k].camera.name, images[k].camera.name);
    EXPECT_EQ(back[k].planes.depth, images[k].planes.depth);
    EXPECT_EQ(back[k].planes.normal, images[k].planes.normal);
    EXPECT_EQ(back[k].planes.primitive, images[k].planes.primitive);
    EXPECT_EQ(back[k].planes.retroreflectance, images[k].planes.retroreflectance);
  }
}

TEST(ImageSource, OffersWhatAllImagesHave) {
  const std::vector<PassImage> images{numbered(0, 4, 4, {Channel::Normal | Channel::Instance, true}),
                                      numbered(1, 4, 4, {Channel::Instance | Channel::Semantic, false})};
  ImageSource source(images);
  EXPECT_EQ(source.available(), (PassChoice{Channel::Range | Channel::Instance, false}));
  PassPlanes planes;
  expectInputError(
      [&] {
        source.fetch({}, {Channel::Normal, false}, planes);
      },
      {"camera1", "normal", "sampling: nearest"});
  expectInputError([&] { source.fetch({}, {Channel::Material, false}, planes); }, {"camera0", "material"});
  expectInputError([&] { source.fetch({}, {Channel::Semantic, false}, planes); }, {"camera0", "semantic"});
  expectInputError([&] { source.fetch({}, {Channel::Range, true}, planes); }, {"camera1", "roughness"});
  ImageSource second(std::span<const PassImage>(images).subspan(1));
  expectInputError(
      [&] {
        second.fetch({}, {Channel::Material, false}, planes);
      },
      {"camera1", "'material'", "roughness, metallic and retroreflectance in its place"});
}

TEST(ImageSource, ASourceWithoutImagesSeesNothing) {
  ImageSource source({});
  PassPlanes planes;
  source.fetch(std::vector<PixelAddress>{kNoPixel}, {Channel::Normal, false}, planes);
  EXPECT_EQ(planes.depth[0], kNoDepth);
}

}  // namespace
}  // namespace scanmill
