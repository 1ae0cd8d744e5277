// Hits are taken from the columns that a device has written. particle/device_test.cpp tests that their numbers are the
// processor's.

#include "methods/gpu/device_resolver.h"

#include <bit>
#include <vector>

#include "methods/world/worlds.h"
#include "scene/reflectance.h"
#include "tests/support/street.h"
#include "tests/support/test_scene.h"

namespace scanmill {
namespace {

// Columns of all channels, as the shader writes them: a ray's values are told by its number.
std::vector<std::uint32_t> columnsOf(std::uint32_t rays) {
  std::vector<std::uint32_t> words;
  const auto put = [&](auto value) {
    for (std::uint32_t i = 0; i < rays; ++i) words.push_back(std::bit_cast<std::uint32_t>(value(i)));
  };
  put([](std::uint32_t i) { return 1.0f + static_cast<float>(i); });    // range
  put([](std::uint32_t i) { return 0.001f * static_cast<float>(i); });  // incidence
  put([](std::uint32_t i) { return 0.002f * static_cast<float>(i); });  // reflectance
  put([](std::uint32_t i) { return 7 * i; });                           // instance
  put([](std::uint32_t i) { return i % 50 | (i % 9) << 16; });          // class, material
  put([](std::uint32_t i) { return 3 * i; });                           // primitive
  for (std::uint32_t i = 0; i < 3 * rays; ++i) words.push_back(std::bit_cast<std::uint32_t>(static_cast<float>(i)));
  return words;
}

TEST(DeviceResolver, TakesAPieceOfWhatADeviceHasMade) {
  constexpr std::uint32_t kAll = 60'000;
  std::vector<std::uint32_t> words = columnsOf(kAll);
  ASSERT_EQ(words.size() * 4, DeviceResolver::bytesPerRay(Channels::all()) * kAll);
  const auto leave = [&](std::uint32_t ray, UnresolvedReason reason) {
    words[ray] = static_cast<std::uint32_t>(reason);
  };
  leave(40'100, UnresolvedReason::LeftField);
  leave(20'010, UnresolvedReason::Rounding);
  leave(19'999, UnresolvedReason::Rounding);  // of another piece
  leave(59'999, UnresolvedReason::StepsUsedUp);
  Hits hits;
  hits.reset(100, 400, Channels::all());
  std::vector<UnresolvedRay> undecided;
  DeviceResolver::copyHits(std::as_bytes(std::span(words)), {kAll, 20'000, 40'000}, hits, undecided);
  for (const std::uint32_t i : {0u, 11u, 25'000u, 39'998u}) {
    const std::uint32_t from = 20'000 + i;
    EXPECT_EQ(hits.range[i], 1.0f + static_cast<float>(from));
    EXPECT_EQ(hits.incidence[i], 0.001f * static_cast<float>(from));
    EXPECT_EQ(hits.reflectance[i], 0.002f * static_cast<float>(from));
    EXPECT_EQ(hits.instance[i], 7 * from);
    EXPECT_EQ(hits.semantic[i], from % 50);
    EXPECT_EQ(hits.material[i], from % 9);
    EXPECT_EQ(hits.primitive[i], 3 * from);
    EXPECT_EQ(hits.normal[i].z, static_cast<float>(3 * from + 2));
  }
  std::vector<std::pair<std::uint32_t, UnresolvedReason>> rays;
  for (const UnresolvedRay& ray : undecided) rays.emplace_back(ray.ray, ray.reason);
  EXPECT_THAT(rays, testing::ElementsAre(std::pair(10u, UnresolvedReason::Rounding),
                                         std::pair(20'100u, UnresolvedReason::LeftField),
                                         std::pair(39'999u, UnresolvedReason::StepsUsedUp)));
}

// Materials that see a texture alike share its texels; others do not.
TEST(DeviceTables, HoldEachTextureOnce) {
  SceneBuilder builder = testBuilder();
  auto texture = std::make_shared<Texture>();
  texture->width = 4;
  texture->height = 3;
  texture->rgba.assign(48, 90);
  Material paper;
  paper.textured = true;
  paper.textureMean = 0.5f;
  paper.texture = texture;
  Mesh mesh;
  for (const float reflectance : {0.3f, 0.3f, 0.4f}) {
    paper.reflectance = reflectance;
    paper.name = "paper " + std::to_string(mesh.surfaces.size());
    mesh.surfaces.push_back({builder.addMaterial(paper), 2, 1, "", "", {}});
    appendQuad(mesh, static_cast<std::uint16_t>(mesh.surfaces.size() - 1), {0, 5, -5}, {0, -5, -5}, {0, -5, 5},
               {0, 5, 5});
  }
  builder.place(builder.addMesh(std::move(mesh)), {}, "papers");
  const Scene scene = builder.finish();
  const Worlds worlds(scene, Instancing::Never, {});
  const LabelTables tables = labelTables(*worlds.near({}));
  EXPECT_EQ(tables.texels.size(), 2u * 12);
  EXPECT_EQ(tables.textured.size(), 6u);
  const CompactMaterial exact = compact(scene.materials.back());
  EXPECT_EQ(tables.texels.back(), std::bit_cast<std::uint32_t>(exact.texturedAt({0.9f, 0.9f})));
}

}  // namespace
}  // namespace scanmill
