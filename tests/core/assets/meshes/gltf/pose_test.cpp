#include "assets/meshes/gltf/pose.h"

#include <array>
#include <nlohmann/json.hpp>

#include "assets/meshes/gltf/reader.h"
#include "tests/core/assets/meshes/gltf/gltf_builder.h"
#include "tests/core/assets/read_assets.h"
#include "tests/support/message_of.h"

namespace scanmill {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using Json = nlohmann::json;

using Builder = GltfBuilder;

constexpr std::array<float, 16> kOneDown{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, -1, 0, 1};  // by columns: y - 1

// A triangle along y: (0,0,0) hangs on a shoulder at the origin, (0,2,0) on an elbow at (0,1,0), (1,1,0) on both by
// halves. The clip "bend" turns the elbow about z by 90 degrees within a second. The mesh's node is far away.
Builder arm() {
  Builder b;
  const std::size_t positions = b.numbers<float>({0, 0, 0, 0, 2, 0, 1, 1, 0}, "VEC3", 3);
  const std::size_t joints = b.numbers<std::uint8_t>({0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0}, "VEC4", 4, 5121);
  const std::size_t weights =
      b.numbers<std::uint8_t>({255, 0, 0, 0, 255, 0, 0, 0, 127, 127, 0, 0}, "VEC4", 4, 5121, true);
  std::vector<float> inverses{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
  inverses.insert(inverses.end(), kOneDown.begin(), kOneDown.end());
  const std::size_t matrices = b.numbers(inverses, "MAT4", 16);
  const std::size_t times = b.numbers<float>({0, 1}, "SCALAR", 1);
  const float half = std::sqrt(0.5f);
  const std::size_t turns = b.numbers<float>({0, 0, 0, 1, 0, 0, half, half}, "VEC4", 4);
  b.json["scenes"] = {{{"nodes", {0, 2}}}};
  b.json["nodes"] = {{{"name", "shoulder"}, {"children", {1}}},
                     {{"name", "elbow"}, {"translation", {0, 1, 0}}},
                     {{"name", "sleeve"}, {"mesh", 0}, {"skin", 0}, {"translation", {50, 60, 70}}}};
  b.json["meshes"] = {
      {{"primitives", {{{"attributes", {{"POSITION", positions}, {"JOINTS_0", joints}, {"WEIGHTS_0", weights}}}}}}}};
  b.json["skins"] = {{{"joints", {0, 1}}, {"inverseBindMatrices", matrices}}};
  b.json["animations"] = {{{"name", "bend"},
                           {"channels", {{{"sampler", 0}, {"target", {{"node", 1}, {"path", "rotation"}}}}}},
                           {"samplers", {{{"input", times}, {"output", turns}}}}}};
  return b;
}

class GltfPose : public testing::Test {
 protected:
  // The corners of its triangle as the file has them, which is y-up.
  std::vector<Vec3f> cornersAt(Builder& b, std::optional<ClipTime> clip) {
    return corners(readAsset(folder_.write("arm.gltf", b.text()), {.up = 'z', .clip = std::move(clip)}));
  }

  std::string refusal(Builder& b, std::optional<ClipTime> clip = std::nullopt) {
    return messageOf([&] { cornersAt(b, clip); });
  }

  TemporaryFolder folder_;
};

void expectCorners(const std::vector<Vec3f>& found, const std::vector<Vec3d>& wanted) {
  ASSERT_EQ(found.size(), wanted.size());
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    EXPECT_LT(length(Vec3d(found[i]) - wanted[i]), 1e-5) << i << ": " << found[i].x << ", " << found[i].y;
  }
}

TEST_F(GltfPose, ASkinIsWhereItsJointsAreWhereverItsNodeIs) {
  Builder b = arm();
  expectCorners(cornersAt(b, {}), {{0, 0, 0}, {0, 2, 0}, {1, 1, 0}});
  b.json["nodes"][0]["translation"] = {0, 0, 5};
  expectCorners(cornersAt(b, {}), {{0, 0, 5}, {0, 2, 5}, {1, 1, 5}});
}

// The elbow turns by 90 degrees times t: the far end goes round it, and what hangs on both is the mean of both.
TEST_F(GltfPose, AClipBendsASkin) {
  Builder b = arm();
  for (const double t : {0.0, 0.25, 0.5, 1.0}) {
    const double angle = kPi / 2 * t;
    const Vec3d end{-std::sin(angle), 1 + std::cos(angle), 0};
    const Vec3d both = (Vec3d{1, 1, 0} + Vec3d{std::cos(angle), 1 + std::sin(angle), 0}) * 0.5;
    expectCorners(cornersAt(b, ClipTime{"bend", t}), {{0, 0, 0}, end, both});
    expectCorners(cornersAt(b, ClipTime{"0", t}), {{0, 0, 0}, end, both});
  }
  expectCorners(cornersAt(b, ClipTime{"bend", 7}), {{0, 0, 0}, {-1, 1, 0}, {0.5, 1.5, 0}});
  const std::filesystem::path file = folder_.write("arm.gltf", b.text());
  EXPECT_EQ(gltf::clipSpan(file, "bend"), (std::pair<double, double>{0, 1}));
  const std::vector<gltf::Clip> clips = gltf::readClips(file);
  ASSERT_EQ(clips.size(), 1u);
  EXPECT_EQ(clips[0].name, "bend");
  EXPECT_EQ(clips[0].first, 0);
  EXPECT_EQ(clips[0].last, 1);
}

TEST_F(GltfPose, AMeshWithoutASkinMovesAsItsNodeDoes) {
  Builder b = arm();
  b.json.erase("skins");
  b.json["nodes"] = {{{"name", "lift"}, {"mesh", 0}}};
  b.json["scenes"] = {{{"nodes", {0}}}};
  const std::size_t times = b.numbers<float>({1, 2, 4}, "SCALAR", 1);
  const std::size_t ways = b.numbers<float>({0, 0, 0, 0, 0, 6, 0, 0, 0}, "VEC3", 3);
  b.json["animations"][0]["channels"] = {{{"sampler", 0}, {"target", {{"node", 0}, {"path", "translation"}}}}};
  b.json["animations"][0]["samplers"] = {{{"input", times}, {"output", ways}}};
  for (const auto& [time, height] : {std::pair{0.0, 0.0}, {1.5, 3.0}, {2.0, 6.0}, {3.0, 3.0}, {9.0, 0.0}}) {
    expectCorners(cornersAt(b, ClipTime{"bend", time}), {{0, 0, height}, {0, 2, height}, {1, 1, height}});
  }
  b.json["animations"][0]["samplers"][0]["interpolation"] = "STEP";
  expectCorners(cornersAt(b, ClipTime{"bend", 1.99}), {{0, 0, 0}, {0, 2, 0}, {1, 1, 0}});
  expectCorners(cornersAt(b, ClipTime{"bend", 2.01}), {{0, 0, 6}, {0, 2, 6}, {1, 1, 6}});
  // t^3, of which the tangents are 0 at 0 and 3 at 1, is its own cubic spline.
  b.json["animations"][0]["samplers"] = {
      {{"input", b.numbers<float>({0, 1}, "SCALAR", 1)},
       {"output", b.numbers<float>({0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 3, 0, 0, 1, 0, 0, 0}, "VEC3", 3)},
       {"interpolation", "CUBICSPLINE"}}};
  for (const double t : {0.0, 0.3, 0.8, 1.0}) {
    const double z = t * t * t;
    expectCorners(cornersAt(b, ClipTime{"bend", t}), {{0, 0, z}, {0, 2, z}, {1, 1, z}});
  }
}

TEST_F(GltfPose, MorphTargetsAddUpByTheirWeights) {
  Builder b = arm();
  b.json.erase("skins");
  b.json["nodes"] = {{{"name", "face"}, {"mesh", 0}}};
  b.json["scenes"] = {{{"nodes", {0}}}};
  const std::size_t up = b.numbers<float>({0, 0, 1, 0, 0, 2, 0, 0, 0}, "VEC3", 3);
  const std::size_t aside = b.numbers<float>({4, 0, 0, 0, 0, 0, 0, 0, 0}, "VEC3", 3);
  b.json["meshes"][0]["primitives"][0]["targets"] = {{{"POSITION", up}}, {{"POSITION", aside}}};
  b.json.erase("animations");
  expectCorners(cornersAt(b, {}), {{0, 0, 0}, {0, 2, 0}, {1, 1, 0}});
  b.json["meshes"][0]["weights"] = {0.5, 0.25};
  expectCorners(cornersAt(b, {}), {{1, 0, 0.5}, {0, 2, 1}, {1, 1, 0}});
  b.json["nodes"][0]["weights"] = {1, 0};
  expectCorners(cornersAt(b, {}), {{0, 0, 1}, {0, 2, 2}, {1, 1, 0}});
  b.json["animations"] = {{{"channels", {{{"sampler", 0}, {"target", {{"node", 0}, {"path", "weights"}}}}}},
                           {"samplers",
                            {{{"input", b.numbers<float>({0, 2}, "SCALAR", 1)},
                              {"output", b.numbers<float>({0, 0, 1, 1}, "SCALAR", 1)}}}}}};
  expectCorners(cornersAt(b, ClipTime{"0", 1}), {{2, 0, 0.5}, {0, 2, 1}, {1, 1, 0}});
}

TEST_F(GltfPose, WhatDoesNotFitIsRefused) {
  Builder good = arm();
  EXPECT_THAT(refusal(good, ClipTime{"bent", 0}),
              AllOf(HasSubstr("arm.gltf"), HasSubstr("no animation 'bent'"), HasSubstr("did you mean 'bend'")));
  const auto refuses = [&](const std::function<void(Builder&)>& spoil, const char* words) {
    Builder b = arm();
    spoil(b);
    EXPECT_THAT(refusal(b, ClipTime{"bend", 0.5}), AllOf(HasSubstr("arm.gltf"), HasSubstr(words)));
  };
  refuses([](Builder& b) { b.json.erase("animations"); }, "has no animation");
  refuses([](Builder& b) { b.json["nodes"][2]["skin"] = 1; }, "nodes[2].skin is 1, but only 1 exist");
  refuses([](Builder& b) { b.json["skins"][0]["joints"] = {0, 7}; }, "skins[0].joints is 7, but only 3 exist");
  refuses([](Builder& b) { b.json["scenes"][0]["nodes"] = {2}; },
          "joint of the skin of the mesh of 'sleeve' is not a node of the scene");
  refuses([](Builder& b) { b.json["skins"][0]["joints"] = {0}; }, "refers to the joint 1, but its skin has 1");
  refuses([](Builder& b) { b.json["skins"][0]["inverseBindMatrices"] = 99; }, "inverseBindMatrices is 99");
  refuses([](Builder& b) { b.json["skins"][0]["joints"] = {0, 1, 0}; }, "fewer matrices than joints");
  refuses([](Builder& b) { b.json["animations"][0]["channels"][0]["sampler"] = 4; }, "channel's sampler is 4");
  refuses([](Builder& b) { b.json["animations"][0]["channels"][0]["target"]["path"] = "scale"; }, "do not match");
  refuses([](Builder& b) { b.json["animations"][0]["channels"][0]["target"]["node"] = 9; },
          "target is 9, but only 3 exist");
  refuses([](Builder& b) { b.json["animations"][0]["channels"] = 3; }, "not valid glTF");
  refuses([](Builder& b) { b.json["animations"][0]["samplers"][0]["input"] = 1; }, "whole numbers");
  refuses([](Builder& b) { b.json["accessors"][2]["normalized"] = false; }, "whole numbers");
  refuses(
      [](Builder& b) {
        b.json["skins"][0]["inverseBindMatrices"] = b.json["accessors"].size();
        b.json["accessors"].push_back({{"componentType", 5126}, {"type", "MAT4"}, {"count", std::uint64_t{1} << 31}});
      },
      "without data");
  refuses(
      [](Builder& b) {
        b.json["meshes"][0]["primitives"][0]["attributes"]["JOINTS_0"] =
            b.numbers<float>({0, 0, 0, 0, 1e30f, 0, 0, 0, 0, 1, 0, 0}, "VEC4", 4);
      },
      "must have unsigned whole numbers");
  refuses([](Builder& b) { b.json["meshes"][0]["primitives"][0]["attributes"].erase("WEIGHTS_0"); }, "not valid glTF");
  const AssetOptions options{.clip = ClipTime{"bend", 0}};
  EXPECT_THAT(messageOf([&] { readAsset(folder_.write("wing.obj", kObj), options); }), HasSubstr("glTF"));
}

// Whatever else a channel names is an extension's, and no key of a node is written that does not move.
TEST_F(GltfPose, ChannelsOfOtherKindsAreLeftOut) {
  for (const char* const path : {"children", "mesh", "pointer"}) {
    Builder b = arm();
    const std::size_t zeroes = b.numbers<float>({0, 0, 0, 0, 0, 0}, "VEC3", 3);
    b.json["animations"][0]["channels"][0]["target"]["path"] = path;
    b.json["animations"][0]["samplers"][0]["output"] = zeroes;
    const auto pose = [&] { expectCorners(cornersAt(b, ClipTime{"bend", 0.5}), {{0, 0, 0}, {0, 2, 0}, {1, 1, 0}}); };
    EXPECT_THAT(printedBy(pose), HasSubstr(std::string(path) == "pointer" ? "1 channels" : ""));
  }
}

// As tools that load such files have it: without weights a vertex follows its first joint.
TEST_F(GltfPose, AVertexWithoutWeightsFollowsItsFirstJoint) {
  Builder b = arm();
  b.json["meshes"][0]["primitives"][0]["attributes"]["WEIGHTS_0"] =
      b.numbers<float>({1, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0}, "VEC4", 4);
  expectCorners(cornersAt(b, ClipTime{"bend", 1}), {{0, 0, 0}, {-1, 1, 0}, {1, 1, 0}});
}

TEST_F(GltfPose, ARotationOfNoLengthIsNone) {
  Builder b = arm();
  b.json["animations"][0]["samplers"][0]["output"] = b.numbers<float>({0, 0, 0, 0, 0, 0, 0, 0}, "VEC4", 4);
  expectCorners(cornersAt(b, ClipTime{"bend", 0.5}), {{0, 0, 0}, {0, 2, 0}, {1, 1, 0}});
}

TEST_F(GltfPose, AGlbIsPosedAsAGltfIs) {
  Builder b = arm();
  b.text();
  b.json["buffers"][0].erase("uri");
  const AssetOptions options{.up = 'z', .clip = ClipTime{"bend", 1}};
  b.bytes.resize((b.bytes.size() + 3) / 4 * 4, '\0');
  expectCorners(corners(readAsset(folder_.write("arm.glb", glb(b.json.dump(), b.bytes)), options)),
                {{0, 0, 0}, {-1, 1, 0}, {0.5, 1.5, 0}});
}

}  // namespace
}  // namespace scanmill
