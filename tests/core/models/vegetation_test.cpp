#include <vector>

#include "models/models.h"
#include "tests/support/labels.h"
#include "tests/support/test_scene.h"

namespace scanmill::models {
namespace {

struct Grown {
  double leafArea = 0;  // m^2
  double lopsided = 0;  // of the leaves' middle, from the stem (m)
  double farthest = 0;  // corner from the stem, along x or y (m)
  double crownRadius = 0;
  std::size_t leaves = 0;
  double inner = 0;  // fraction of the leaves in the ellipsoid of half the crown's size
};

Grown grow(std::uint64_t seed, int form, double detail, double ragged) {
  SceneBuilder builder = labelledBuilder();
  const TreeModel tree = makeTree(builder, seed, form, detail, 1, ragged);
  builder.place(tree.model.mesh, {}, "tree");
  const Scene scene = builder.finish();
  const Mesh& mesh = scene.meshes[tree.model.mesh];
  Grown grown;
  grown.crownRadius = tree.crownRadius;
  Vec3d sum;
  std::vector<Vec3d> leaves;
  for (std::size_t k = 0; k < mesh.triangles.size(); ++k) {
    const auto [a, b, c] = cornersIn(mesh, mesh.triangles[k]);
    const std::string& material = scene.materials[mesh.surfaces[mesh.surfaceOf[k]].material].name;
    if (!material.starts_with("leaf")) continue;
    const double area = length(cross(b - a, c - a)) / 2;
    grown.leafArea += area;
    sum = sum + (a + b + c) * (area / 3);
    leaves.push_back((a + b + c) * (1.0 / 3));
  }
  Box crown;
  for (const Vec3d& p : leaves) crown.add(p);
  const Vec3d half = (crown.high - crown.low) * 0.5;
  for (const Vec3d& p : leaves) {
    const Vec3d d = p - crown.center();
    grown.inner += length(Vec3d{d.x / half.x, d.y / half.y, d.z / half.z}) < 0.5 ? 1.0 / double(leaves.size()) : 0;
  }
  grown.leaves = leaves.size();
  grown.lopsided = std::hypot(sum.x, sum.y) / grown.leafArea;
  for (const Vec3f& p : mesh.positions) {
    grown.farthest = std::max({grown.farthest, std::abs(double{p.x}), std::abs(double{p.y})});
  }
  return grown;
}

TEST(Trees, HaveTheSameAreaOfLeavesWhateverTheDetailAndHoweverRagged) {
  for (int form = 0; form < kBroadleafForms; ++form) {
    const Grown full = grow(3, form, 1, 0);
    EXPECT_NEAR(grow(3, form, 0.3, 0).leafArea, full.leafArea, 0.1 * full.leafArea) << form;
    EXPECT_NEAR(grow(3, form, 1, 1).leafArea, full.leafArea, 0.15 * full.leafArea) << form;
  }
}

// An ellipsoid of half the crown's size has an eighth of its volume, and few of the leaves, which seek the light.
TEST(Trees, HaveManySmallLeavesMostlyOutside) {
  for (int form = 0; form < kBroadleafForms; ++form) {
    const Grown tree = grow(4, form, 1, 0.6);
    EXPECT_GT(tree.leaves, 6000u) << form;
    EXPECT_LT(tree.leafArea / static_cast<double>(tree.leaves), 0.03) << form;
    EXPECT_LT(tree.inner, 0.35) << form;
  }
}

TEST(Trees, AreHeavierOnOneSideIfRagged) {
  double round = 0;
  double ragged = 0;
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    for (int form = 0; form < kBroadleafForms; ++form) {
      round += grow(seed, form, 0.2, 0).lopsided;
      const Grown tree = grow(seed, form, 0.2, 1);
      ragged += tree.lopsided;
      EXPECT_GE(tree.crownRadius, tree.farthest - 1e-6) << "nothing reaches beyond what is kept clear";
    }
  }
  EXPECT_GT(ragged, 1.5 * round);
}

}  // namespace
}  // namespace scanmill::models
