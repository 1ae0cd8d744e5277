#include "assets/meshes/asset_alpha.h"

#include <cmath>
#include <cstdint>

#include "scene/texture.h"

namespace scanmill {

namespace {

constexpr int kSteps = 8;  // rows of sample points in a triangle; row i has kSteps - i points
constexpr int kPoints = kSteps * (kSteps + 1) / 2;
constexpr std::uint64_t kMaxTriangles = 1 << 14;

constexpr double kLeastLow = 0.01;
constexpr double kMostGraded = 0.3;
constexpr double kMostGone = 0.15;

// Sums over triangles. A triangle adds its area times the number of its sample points to `all`; to a member of `parts`
// it adds its area times the number of its sample points that meet the member's condition.
struct Sum {
  double all = 0;
  AlphaShares parts;
};

void addTriangle(Sum& sum, const ImportedPart& part, const Triangle& at, const Texture& texture) {
  const auto& p = part.positions;
  const double area = length(cross(Vec3d(p[at[1]] - p[at[0]]), Vec3d(p[at[2]] - p[at[0]])));
  if (!std::isfinite(area)) return;
  const auto& uv = part.uvs;
  int low = 0;
  int graded = 0;
  for (int i = 0; i < kSteps; ++i) {
    for (int k = 0; k < kSteps - i; ++k) {
      const float b = (static_cast<float>(i) + 1.0f / 3) / kSteps;
      const float c = (static_cast<float>(k) + 1.0f / 3) / kSteps;
      const float a = 1 - b - c;
      const int alpha = texture.texel(uv[at[0]].x * a + uv[at[1]].x * b + uv[at[2]].x * c,
                                      uv[at[0]].y * a + uv[at[1]].y * b + uv[at[2]].y * c)[3];
      low += alpha < 128 ? 1 : 0;
      graded += alpha >= 26 && alpha < 230 ? 1 : 0;
    }
  }
  sum.all += area * kPoints;
  sum.parts.low += area * low;
  sum.parts.graded += area * graded;
  if (low == kPoints) sum.parts.gone += area * kPoints;
}

}  // namespace

AlphaShares measureAlpha(const ImportedFile& imported, std::uint32_t material, const Texture& texture) {
  if (!texture.hasAlpha) return {};
  const auto shows = [&](const ImportedPart& part) { return part.material == material && !part.uvs.empty(); };
  std::uint64_t triangles = 0;
  for (const ImportedPart& part : imported.parts) triangles += shows(part) ? part.triangles.size() : 0;
  const std::uint64_t step = triangles / kMaxTriangles + 1;
  Sum sum;
  std::uint64_t number = 0;
  for (const ImportedPart& part : imported.parts) {
    if (!shows(part)) continue;
    for (const Triangle& triangle : part.triangles) {
      if (number++ % step == 0) addTriangle(sum, part, triangle, texture);
    }
  }
  if (!(sum.all > 0)) return {};
  return {sum.parts.low / sum.all, sum.parts.graded / sum.all, sum.parts.gone / sum.all};
}

bool isCutOut(const AlphaShares& shares) {
  return shares.low >= kLeastLow && shares.graded <= kMostGraded && shares.gone <= kMostGone;
}

}  // namespace scanmill
