#include "scene/assets/asset_alpha.h"

#include <assimp/mesh.h>
#include <assimp/scene.h>

#include <cmath>
#include <cstdint>

#include "scene/material.h"

namespace scanmill {

namespace {

constexpr int kSteps = 8;  // along an edge of a triangle
constexpr int kPoints = kSteps * (kSteps + 1) / 2;
constexpr std::uint64_t kMaxTriangles = 1 << 14;

constexpr double kLeastLow = 0.01;
constexpr double kMostGraded = 0.3;
constexpr double kMostGone = 0.15;

// A sum over triangles, of area times points.
struct Sum {
  double all = 0;
  AlphaShares parts;
};

void addTriangle(Sum& sum, const aiMesh& mesh, const unsigned* at, unsigned channel, const Texture& texture) {
  const aiVector3D* p = mesh.mVertices;
  const double area = static_cast<double>(((p[at[1]] - p[at[0]]) ^ (p[at[2]] - p[at[0]])).Length());
  if (!std::isfinite(area)) return;
  const aiVector3D* uv = mesh.mTextureCoords[channel];
  int low = 0;
  int graded = 0;
  for (int i = 0; i < kSteps; ++i) {
    for (int k = 0; k < kSteps - i; ++k) {
      const float b = (static_cast<float>(i) + 1.0f / 3) / kSteps;
      const float c = (static_cast<float>(k) + 1.0f / 3) / kSteps;
      const aiVector3D point = uv[at[0]] * (1 - b - c) + uv[at[1]] * b + uv[at[2]] * c;
      const int alpha = texture.texel(point.x, point.y)[3];
      low += alpha < 128 ? 1 : 0;
      graded += alpha >= 26 && alpha < 230 ? 1 : 0;
    }
  }
  sum.all += area * kPoints;
  sum.parts.low += area * low;
  sum.parts.graded += area * graded;
  if (low == kPoints) sum.parts.gone += area * kPoints;
}

template <class Visit>
void forEachMesh(const aiScene& scene, unsigned material, unsigned uvChannel, Visit visit) {
  for (unsigned m = 0; m < scene.mNumMeshes; ++m) {
    const aiMesh& mesh = *scene.mMeshes[m];
    if (mesh.mMaterialIndex != material || mesh.mVertices == nullptr) continue;
    const unsigned channel = mesh.HasTextureCoords(uvChannel) ? uvChannel : 0;
    if (mesh.HasTextureCoords(channel)) visit(mesh, channel);
  }
}

}  // namespace

AlphaShares measureAlpha(const aiScene& scene, unsigned material, unsigned uvChannel, const Texture& texture) {
  if (!texture.hasAlpha) return {};
  std::uint64_t faces = 0;
  forEachMesh(scene, material, uvChannel, [&](const aiMesh& mesh, unsigned) { faces += mesh.mNumFaces; });
  const std::uint64_t step = faces / kMaxTriangles + 1;
  Sum sum;
  std::uint64_t number = 0;
  forEachMesh(scene, material, uvChannel, [&](const aiMesh& mesh, unsigned channel) {
    for (unsigned f = 0; f < mesh.mNumFaces; ++f, ++number) {
      const aiFace& face = mesh.mFaces[f];
      if (face.mNumIndices == 3 && number % step == 0) addTriangle(sum, mesh, face.mIndices, channel, texture);
    }
  });
  if (!(sum.all > 0)) return {};
  return {sum.parts.low / sum.all, sum.parts.graded / sum.all, sum.parts.gone / sum.all};
}

bool isCutOut(const AlphaShares& shares) {
  return shares.low >= kLeastLow && shares.graded <= kMostGraded && shares.gone <= kMostGone;
}

}  // namespace scanmill
