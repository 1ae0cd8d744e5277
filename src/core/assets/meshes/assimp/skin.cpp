#include <assimp/mesh.h>

#include <algorithm>
#include <cmath>

#include "assets/meshes/assimp/parts.h"

namespace scanmill {

namespace {

// Largest distance, as a fraction of a mesh's size, by which joints may take a mesh from where its node does without
// counting as another pose: offset matrices are in single precision.
constexpr double kSamePose = 1e-4;

bool samePlace(const Affine& a, const Affine& b, double size) {
  double moved = length(a.translation - b.translation);
  double reach = 0;
  for (const Vec3d& axis : {Vec3d{size, 0, 0}, Vec3d{0, size, 0}, Vec3d{0, 0, size}}) {
    moved += length(a.linear * axis - b.linear * axis);
    reach = std::max(reach, length(b.linear * axis));
  }
  return moved <= kSamePose * reach;
}

}  // namespace

std::optional<SkinnedMesh> skinned(const aiMesh& mesh, const Affine& assetFromNode,
                                   const std::function<std::optional<Affine>(const aiBone&)>& assetFromMesh,
                                   LeftOut& leftOut) {
  const auto vertex = [&](unsigned i) { return Vec3d{mesh.mVertices[i].x, mesh.mVertices[i].y, mesh.mVertices[i].z}; };
  double size = 0;
  for (unsigned i = 0; mesh.mNumBones > 0 && i < mesh.mNumVertices; ++i) size = std::max(size, length(vertex(i)));
  SkinnedMesh out;
  std::vector<std::optional<Affine>> joints;
  bool moves = false;
  for (unsigned b = 0; b < mesh.mNumBones; ++b) {
    const std::optional<Affine> joint = assetFromMesh(*mesh.mBones[b]);
    if (!joint) leftOut.add("joints of skins that no node has");
    joints.push_back(joint);
    if (!joint || samePlace(*joint, assetFromNode, size)) continue;
    moves = true;
    out.mirrored = determinant(joint->linear) < 0;
  }
  if (!moves) return std::nullopt;
  out.vertices.resize(mesh.mNumVertices);
  std::vector<double> sums(mesh.mNumVertices, 0);
  for (unsigned b = 0; b < mesh.mNumBones; ++b) {
    for (unsigned w = 0; joints[b] && w < mesh.mBones[b]->mNumWeights; ++w) {
      const unsigned i = mesh.mBones[b]->mWeights[w].mVertexId;
      const double weight = static_cast<double>(mesh.mBones[b]->mWeights[w].mWeight);
      if (i >= mesh.mNumVertices || !(weight > 0)) continue;
      out.vertices[i] = out.vertices[i] + (*joints[b] * vertex(i)) * weight;
      sums[i] += weight;
    }
  }
  for (unsigned i = 0; i < mesh.mNumVertices; ++i) {
    out.vertices[i] = sums[i] > 0 ? out.vertices[i] * (1 / sums[i]) : assetFromNode * vertex(i);
  }
  return out;
}

}  // namespace scanmill
