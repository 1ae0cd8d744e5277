// The VTK renderer as a device: images of any shape, pixels in any order, threads, wrong use.

#include <cstdlib>

#include "gpu/compute.h"
#include "passes/renderer.h"
#include "tests/core/passes/vtk/drawing.h"
#include "tests/support/gl.h"
#include "tests/support/message_of.h"
#include "tests/support/on_threads.h"
#include "tests/support/sanitizers.h"
#include "tests/support/test_scene.h"

namespace scanmill {
namespace {

using testing::HasSubstr;

TEST(VtkRenderer, DrawsTheSameBytesAgain) {
  const Scene scene = randomScene();
  RENDERER_OR_SKIP(renderer, scene);
  const auto other = makeVtkRenderer(scene);
  const Camera camera = cameraAt({-9, 1, 0.5}, 5, 3, 20, 200, 150, 90);
  const Camera elsewhere = cameraAt({2, 1, 0.5}, 90, 3, 20, 64, 300, 70);
  const PassPlanes first = drawnOne(*renderer, camera);
  drawnOne(*renderer, elsewhere);
  EXPECT_TRUE(same(first, drawnOne(*renderer, camera)));
  EXPECT_TRUE(same(first, drawnOne(*other, camera)));
  const std::vector<PassImage> together = drawn(*renderer, {elsewhere, camera, camera}, {});
  EXPECT_TRUE(same(first, together[1].planes));
  EXPECT_TRUE(same(first, together[2].planes));
}

TEST(VtkRenderer, TakesImagesOfAnyShape) {
  const Scene scene = randomScene();
  RENDERER_OR_SKIP(renderer, scene);
  std::vector<Camera> cameras;
  const std::pair<std::uint32_t, std::uint32_t> sizes[] = {{1, 1},    {257, 3},  {3, 129},  {64, 64},
                                                           {100, 37}, {37, 100}, {130, 90}, {65, 66}};
  for (const auto& [width, height] : sizes) {
    Camera camera = cameraAt({-9, 1, 0.5}, 5, 3, 0, width, height, 60);
    const auto k = static_cast<double>(cameras.size());
    camera.fy *= 1.1;
    camera.cx += 20 * k - 40;  // out of the image for some
    camera.cy -= 10 * k - 30;
    cameras.push_back(camera);
  }
  const std::vector<PassImage> images = drawn(*renderer, cameras, {});
  ASSERT_EQ(images.size(), 8u);
  for (std::size_t k = 3; k < images.size(); ++k) expectLikeReference(scene, cameras[k], {}, images[k].planes);
  for (std::size_t k = 0; k < images.size(); ++k) {
    EXPECT_TRUE(same(images[k].planes, drawnOne(*renderer, cameras[k]))) << k;
  }
}

TEST(VtkRenderer, FetchesAnyPixelsInAnyOrder) {
  const Scene scene = randomScene();
  RENDERER_OR_SKIP(renderer, scene);
  const std::vector<Camera> cameras{cameraAt({-9, 1, 0.5}, 5, 3, 20, 70, 50, 90),
                                    cameraAt({-9, 1, 0.5}, -40, 3, 20, 33, 90, 60)};
  const auto source = renderer->draw(cameras, {}, kIds);
  const std::vector<PassImage> images = readAll(*source, kIds);
  const std::size_t pixels = cameras[0].pixels() + cameras[1].pixels();
  std::vector<std::vector<PixelAddress>> lists(4);
  for (std::uint32_t i = 0; i < 9000; ++i) {
    const auto any = static_cast<PixelAddress>(uniform(i, 0, static_cast<double>(pixels)));
    lists[0].push_back(i % 7 == 0 ? kNoPixel : any);
  }
  for (PixelAddress i = 100; i < 3600; ++i) lists[1].push_back(i);  // a run across two images
  for (PixelAddress i = 123; i < 777; ++i) lists[2].push_back(i);   // a run inside of one
  lists[3] = {kNoPixel, kNoPixel};
  lists.push_back({});
  for (const std::vector<PixelAddress>& addresses : lists) {
    PassPlanes planes;
    PassPlanes expected;
    source->fetch(addresses, kIds, planes);
    ImageSource(images).fetch(addresses, kIds, expected);
    EXPECT_TRUE(same(planes, expected));
    EXPECT_EQ(planes.size(), addresses.size());
  }
  EXPECT_EQ(source->available(), (PassChoice{Channels::all(), true}));
}

TEST(VtkRenderer, NothingIsSeenOfNothing) {
  Scene scene;
  scene.materials.resize(1);
  RENDERER_OR_SKIP(renderer, scene);
  const PassPlanes planes = drawnOne(*renderer, cameraAt({}, 0, 0, 0, 32, 16, 90));
  EXPECT_EQ(planes.size(), 512u);
  EXPECT_EQ(seenPixels(planes), 0u);
  PassPlanes none;
  renderer->draw({}, {}, kIds)->fetch({}, kIds, none);
  EXPECT_EQ(none.size(), 0u);
}

TEST(VtkRenderer, ThreadsTakeTurns) {
  const Scene scene = randomScene();
  RENDERER_OR_SKIP(renderer, scene);
  constexpr int kThreads = 4;
  std::vector<Camera> cameras;
  std::vector<PassPlanes> expected;
  for (int i = 0; i < kThreads; ++i) {
    cameras.push_back(cameraAt({-9, 1, 0.5}, 10 * i - 15, 3, 20, 64 + static_cast<std::uint32_t>(i), 48, 80));
    expected.push_back(drawnOne(*renderer, cameras.back()));
  }
  const int rounds = kSanitized ? 2 : 8;
  std::vector<int> right(kThreads, 0);
  onThreads(kThreads, [&](std::size_t i) {
    for (int round = 0; round < rounds; ++round) {
      right[i] += same(expected[i], drawnOne(*renderer, cameras[i]));
      const auto own = round == 0 ? makeVtkRenderer(scene) : nullptr;
      if (own != nullptr && !same(expected[i], drawnOne(*own, cameras[i]))) right[i] = -100;
    }
  });
  EXPECT_EQ(right, std::vector<int>(kThreads, rounds));
}

// A source may be used and dropped by another thread than the one that drew it.
TEST(VtkRenderer, SourcesChangeThreads) {
  const Scene scene = randomScene();
  RENDERER_OR_SKIP(renderer, scene);
  const Camera camera = cameraAt({-9, 1, 0.5}, 5, 3, 20, 64, 48, 80);
  const PassPlanes expected = drawnOne(*renderer, camera);
  EXPECT_THAT(renderer->device(), HasSubstr("VTK 9."));
  std::unique_ptr<PixelSource> source = renderer->draw({camera}, {}, kIds);
  bool right = false;
  std::jthread([&] {
    right = same(readAll(*source, kIds).front().planes, expected);
    source.reset();
  }).join();
  EXPECT_TRUE(right);
  EXPECT_TRUE(same(expected, drawnOne(*renderer, camera)));
}

TEST(VtkRenderer, RefusesImagesLargerThanTheDeviceDraws) {
  const Scene scene = randomScene();
  RENDERER_OR_SKIP(renderer, scene);
  const Camera camera = cameraAt({}, 0, 0, 0, 1u << 20, 8, 80);
  expectInputError([&] { renderer->draw({camera}, {}, kIds); }, {"'test'", "1048576 x 8"});
}

TEST(VtkRenderer, SaysWhichDevicesThereAre) {
  const Scene scene = randomScene();
  { RENDERER_OR_SKIP(renderer, scene); }
  ::setenv("SCANMILL_GL_DEVICE", "77", 1);
  const std::string message = messageOf<Error>([&] { makeVtkRenderer(scene); });
  ::setenv("SCANMILL_GL_DEVICE", "software", 1);
  const std::string software = messageOf<Error>([&] { makeVtkRenderer(scene); });
  ::unsetenv("SCANMILL_GL_DEVICE");
  EXPECT_THAT(message, HasSubstr("SCANMILL_GL_DEVICE: there is no device '77' (known: "));
  EXPECT_THAT(message, testing::Not(HasSubstr("libgl1-mesa-dri")));  // nothing is amiss but the number
  EXPECT_TRUE(software == "accepted" || software.find("there is no device 'software'") != std::string::npos);
}

// Renderers and compute devices have threads and contexts of their own.
TEST(VtkRenderer, DrawsWhileOthersCompute) {
  const Scene scene = randomScene();
  RENDERER_OR_SKIP(renderer, scene);
  const Camera camera = cameraAt({-9, 1, 0.5}, 5, 3, 20, 64, 48, 80);
  const PassPlanes expected = drawnOne(*renderer, camera);
  const int rounds = kSanitized ? 3 : 20;
  std::vector<int> right(4, 0);
  onThreads(right.size(), [&](std::size_t t) {
    for (int round = 0; round < rounds; ++round) {
      if (t == 0) {
        right[t] += same(expected, drawnOne(*renderer, camera));
        continue;
      }
      const ComputeDevice device({"tests cannot compute", "do it by hand"});
      ComputeProgram program(device, "add", R"(
layout(std140, binding = 0) uniform Parameters { uint added; };
layout(std430, binding = 0) buffer Sums { uint sums[]; };
void invoke(uint i) { sums[i] += added * i; }
)");
      ComputeBuffer buffer(device);
      std::vector<std::uint32_t> sums(100 * t, 5);
      buffer.upload(std::span<const std::uint32_t>(sums));
      const auto added = static_cast<std::uint32_t>(t);
      program.run(sums.size(), {&buffer}, std::as_bytes(std::span(&added, 1)));
      const auto got = copyOf<std::uint32_t>(device, buffer, sums.size());
      for (std::uint32_t i = 0; i < sums.size(); ++i) sums[i] += added * i;
      right[t] += got == sums;
    }
  });
  EXPECT_EQ(right, std::vector<int>(4, rounds));
}

}  // namespace
}  // namespace scanmill
