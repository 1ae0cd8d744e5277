// Both renderers draw the same passes.

#include <string>
#include <vector>

#include "base/error.h"
#include "passes/renderer.h"
#include "scenefile/scene_file.h"
#include "tests/support/blender.h"

namespace scanmill {
namespace {

constexpr PassChoice kRendererPasses{Channels::all(), true};
constexpr std::uint32_t kSide = 256;  // px

// Whether all pixels around one, and itself, see the same triangle of the same thing.
bool isInside(const PassPlanes& p, std::size_t i) {
  const std::size_t column = i % kSide;
  const std::size_t row = i / kSide;
  if (column == 0 || row == 0 || column + 1 == kSide || row + 1 == kSide) return false;
  for (const std::size_t y : {row - 1, row, row + 1}) {
    for (const std::size_t x : {column - 1, column, column + 1}) {
      const std::size_t k = y * kSide + x;
      if (std::isinf(p.depth[k]) != std::isinf(p.depth[i]) || p.instance[k] != p.instance[i] ||
          p.semantic[k] != p.semantic[i] || p.primitive[k] != p.primitive[i]) {
        return false;
      }
    }
  }
  return true;
}

TEST(Renderers, DrawTheSamePassesOfTheStreet) {
  SKIP_WITHOUT_BLENDER();
  SceneOptions options;
  options.seed = 1;
  const Scene scene = readScene(std::filesystem::path(SCANMILL_SOURCE_DIR) / "scenes" / "street.yaml", options);
  std::unique_ptr<PassRenderer> vtk;
  try {
    vtk = makeVtkRenderer(scene);
  } catch (const Error& e) {
    GTEST_SKIP() << e.what();
  }
  const auto blender = makeBlenderRenderer(scene);
  std::vector<Camera> cameras;
  for (const int yaw : {0, 120, 240}) {
    cameras.push_back(squareCamera(kSide, kSide, radians(120)));
    cameras.back().name = std::to_string(yaw);
    cameras.back().worldFromCamera = {fromYawPitchRoll(radians(yaw), 0, 0) * vehicleFromOptical(), {3, -1.5, 1.8}};
  }
  cameras[1].cx += 60.25;
  cameras[1].cy -= 33.5;
  const DrawLimits limits{0.1, 200};
  const auto byVtk = readAll(*vtk->draw(cameras, limits, kRendererPasses), kRendererPasses);
  const auto byBlender = readAll(*blender->draw(cameras, limits, kRendererPasses), kRendererPasses);
  ASSERT_EQ(byVtk.size(), byBlender.size());

  std::size_t pixels = 0;
  std::size_t sameLabels = 0;
  std::size_t inside = 0;
  std::size_t differInside = 0;
  std::size_t otherValues = 0;
  std::vector<double> difference;  // of depth, relative, where both see the same triangle
  for (std::size_t k = 0; k < byVtk.size(); ++k) {
    const PassPlanes& a = byVtk[k].planes;
    const PassPlanes& b = byBlender[k].planes;
    for (std::size_t i = 0; i < a.size(); ++i) {
      ++pixels;
      const bool labels = a.instance[i] == b.instance[i] && a.semantic[i] == b.semantic[i] &&
                          std::isinf(a.depth[i]) == std::isinf(b.depth[i]);
      sameLabels += labels ? 1 : 0;
      const bool same = labels && a.primitive[i] == b.primitive[i] && a.material[i] == b.material[i];
      const bool isSafe = isInside(a, i);
      inside += isSafe ? 1 : 0;
      differInside += isSafe && !same ? 1 : 0;
      if (!same || std::isinf(a.depth[i])) continue;
      difference.push_back(std::abs(double{a.depth[i]} - double{b.depth[i]}) / double{a.depth[i]});
      // The same primitive number of another instance of stuff is another triangle.
      if (difference.back() > 1e-3) continue;
      if (length(a.normal[i] - b.normal[i]) > 1e-6f || a.reflectance[i] != b.reflectance[i] ||
          a.roughness[i] != b.roughness[i] || a.metallic[i] != b.metallic[i] ||
          a.retroreflectance[i] != b.retroreflectance[i]) {
        ++otherValues;
      }
    }
  }
  ASSERT_GT(difference.size(), pixels / 3);
  std::sort(difference.begin(), difference.end());
  const double median = difference[difference.size() / 2];
  const double most = difference[difference.size() * 999 / 1000];
  RecordProperty("same_labels", std::to_string(static_cast<double>(sameLabels) / static_cast<double>(pixels)));
  RecordProperty("median_depth_difference", std::to_string(median));
  EXPECT_GT(inside, pixels / 3);
  EXPECT_GE(static_cast<double>(sameLabels), 0.995 * static_cast<double>(pixels));
  EXPECT_LE(static_cast<double>(differInside), 1e-4 * static_cast<double>(inside));
  EXPECT_LE(median, 1e-6);
  EXPECT_LE(most, 1e-5);
  EXPECT_LE(static_cast<double>(otherValues), 1e-3 * static_cast<double>(pixels));
}

}  // namespace
}  // namespace scanmill
