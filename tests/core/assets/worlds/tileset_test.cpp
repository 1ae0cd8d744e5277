#include <fmt/format.h>

#include <cstring>
#include <map>

#include "assets/worlds/world_asset.h"
#include "base/earth.h"
#include "tests/core/assets/meshes/gltf/gltf_builder.h"
#include "world_files.h"

namespace scanmill {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using Json = nlohmann::json;

// A wing as glTF, whose y axis is up: in z-up coordinates its corners are (1, 0, 0), (0, 0, 2), (0, -3, 0).
GltfBuilder upright(const std::string& node = "wing") {
  GltfBuilder b;
  const std::size_t positions = b.numbers<float>({1, 0, 0, 0, 2, 0, 0, 0, 3}, "VEC3", 3);
  b.json["scenes"] = {{{"nodes", {0}}}};
  b.json["nodes"] = {{{"name", node}, {"mesh", 0}}};
  b.json["meshes"] = {{{"primitives", {{{"attributes", {{"POSITION", positions}}}}}}}};
  return b;
}

void word(std::string& bytes, std::uint32_t value) {
  bytes.append(reinterpret_cast<const char*>(&value), 4);
}

std::string b3dm(const std::string& inside, const std::string& features, const std::string& binary = "") {
  std::string bytes = "b3dm";
  const std::string batches = "{\"id\":[1]}";
  word(bytes, 1);
  word(bytes, static_cast<std::uint32_t>(28 + features.size() + binary.size() + batches.size() + inside.size()));
  word(bytes, static_cast<std::uint32_t>(features.size()));
  word(bytes, static_cast<std::uint32_t>(binary.size()));
  word(bytes, static_cast<std::uint32_t>(batches.size()));
  word(bytes, 0);
  return bytes + features + binary + batches + inside;
}

const std::vector<Vec3d> kUpright = {{1, 0, 0}, {0, 0, 2}, {0, -3, 0}};

class Tileset : public WorldFiles {
 protected:
  Asset tileset(const Json& root, const std::string& version = "1.0") const {
    return read("tileset.json", Json{{"asset", {{"version", version}}}, {"root", root}}.dump());
  }
  std::string refused(const Json& root) const {
    return messageOf([&] { tileset(root); });
  }
  static Json local() { return {{"box", {0, 0, 0, 50, 0, 0, 0, 50, 0, 0, 0, 50}}}; }
  void expectPlaced(const Asset& asset, const std::string& node, const Affine& place, double within = 1e-4) const {
    const std::vector<Vec3d> found = corners(asset, node);
    for (std::size_t i = 0; i < 3; ++i) EXPECT_LT(length(found.at(i) - place * kUpright[i]), within) << i;
  }
  static Json columns(const Affine& a) {
    return {a.linear.x.x, a.linear.x.y, a.linear.x.z, 0, a.linear.y.x,    a.linear.y.y,    a.linear.y.z,    0,
            a.linear.z.x, a.linear.z.y, a.linear.z.z, 0, a.translation.x, a.translation.y, a.translation.z, 1};
  }
};

TEST_F(Tileset, TakesTheFinestTilesWithTheirTransforms) {
  for (const char* name : {"coarse.gltf", "a.gltf", "b.gltf"}) folder_.write(name, upright().text());
  const Affine outer = toAffine({fromYawPitchRoll(0.5, 0, 0), {10, 0, 0}});
  const Affine inner = toAffine({fromYawPitchRoll(0, 0.2, 0), {0, 5, 1}});
  const Json root{{"boundingVolume", local()},
                  {"refine", "REPLACE"},
                  {"transform", columns(outer)},
                  {"content", {{"uri", "coarse.gltf"}}},
                  {"children",
                   {{{"boundingVolume", local()}, {"content", {{"url", "a.gltf"}}}},
                    {{"boundingVolume", local()}, {"transform", columns(inner)}, {"content", {{"uri", "b.gltf"}}}}}}};
  const Asset asset = tileset(root);
  ASSERT_EQ(asset.parts.size(), 2u);
  expectPlaced(asset, "a.gltf/wing", outer);
  expectPlaced(asset, "b.gltf/wing", outer * inner);
  EXPECT_NE(asset.parts[0].nodeIndex, asset.parts[1].nodeIndex);
  // Where children add to it, the coarse tile stays.
  Json other = root;
  for (const auto& [refine, parts] : std::map<std::string, std::size_t>{{"ADD", 3}, {"Add", 3}, {"replace", 2}}) {
    other["refine"] = refine;
    EXPECT_EQ(tileset(other).parts.size(), parts) << refine;
  }
}

TEST_F(Tileset, RelativeCentresAreThoseOfTheContent) {
  GltfBuilder rtc = upright();
  rtc.json["extensionsUsed"] = rtc.json["extensionsRequired"] = {"CESIUM_RTC"};
  rtc.json["extensions"]["CESIUM_RTC"]["center"] = {100, 200, 300};
  folder_.write("a.gltf", rtc.text());
  folder_.write("b.b3dm", b3dm(glb(upright().text()), R"({"BATCH_LENGTH":0,"RTC_CENTER":[10,20,30]})"));
  const float center[] = {1, 2, 3};
  std::string binary(12, '\0');
  std::memcpy(binary.data(), center, 12);
  folder_.write("c.b3dm", b3dm(glb(upright().text()), R"({"BATCH_LENGTH":0,"RTC_CENTER":{"byteOffset":0}})", binary));
  const Asset asset = tileset(
      {{"boundingVolume", local()}, {"contents", {{{"uri", "a.gltf"}}, {{"uri", "b.b3dm"}}, {{"uri", "c.b3dm"}}}}},
      "1.1");
  expectPlaced(asset, "a.gltf/wing", {{}, {100, 200, 300}});
  expectPlaced(asset, "b.b3dm/wing", {{}, {10, 20, 30}});
  expectPlaced(asset, "c.b3dm/wing", {{}, {1, 2, 3}});
  // A centre that is not on the earth is one of the file's own frame, and most are zero.
  expectPlaced(readAsset(folder_.path() / "b.b3dm", {}), "wing", {{}, {10, 20, 30}});
  folder_.write("d.b3dm", b3dm(glb(upright().text()), R"({"BATCH_LENGTH":0,"RTC_CENTER":[0,0,0]})"));
  expectPlaced(readAsset(folder_.path() / "d.b3dm", {}), "wing", {});
}

// A region across the date line has its east below its west.
TEST_F(Tileset, RegionsMayCrossTheDateLine) {
  const double west = radians(179.999), east = radians(-179.999), latitude = 0.3;
  const Vec3d middle = earthCentred(kPi, latitude, 7);
  folder_.write("a.GLB", glb(upright().text()));
  const Json root{{"boundingVolume", {{"region", {west, latitude, east, latitude, 5, 9}}}},
                  {"transform", columns(inverse(eastNorthUp(middle)))},
                  {"content", {{"uri", "a.GLB"}}}};
  expectPlaced(tileset(root), "a.GLB/wing", {}, 1e-4);
  EXPECT_TRUE(tileset(root).ownMiddle) << "so that two tilesets at one position are told";
  EXPECT_THAT(tileset(root).system, HasSubstr(fmt::format("[{:.2f}, ", middle.x)));
  Json inDegrees = root;
  inDegrees["boundingVolume"]["region"] = {8.5, 47.3, 8.6, 47.4, 0, 50};
  EXPECT_THAT(refused(inDegrees), HasSubstr("must be in radians"));
}

// On the earth to the millimetre, though its coordinates have seven digits before the point.
TEST_F(Tileset, OnTheEarthStandsAsTheHorizonHasIt) {
  const double longitude = 0.2, latitude = 0.9;
  const Vec3d middle = earthCentred(longitude, latitude, 40);
  const Affine earthFromLocal = inverse(eastNorthUp(middle));
  folder_.write("a.gltf", upright().text());
  const Json byTransform{
      {"boundingVolume", local()}, {"transform", columns(earthFromLocal)}, {"content", {{"uri", "a.gltf"}}}};
  expectPlaced(tileset(byTransform), "a.gltf/wing", {}, 1e-4);

  GltfBuilder rtc = upright();
  rtc.json["extensionsUsed"] = {"CESIUM_RTC"};
  rtc.json["extensions"]["CESIUM_RTC"]["center"] = {middle.x, middle.y, middle.z};
  folder_.write("b.gltf", rtc.text());
  const Json byCenter{
      {"boundingVolume", {{"region", {longitude - 1e-5, latitude - 1e-5, longitude + 1e-5, latitude + 1e-5, 30, 50}}}},
      {"content", {{"uri", "b.gltf"}}}};
  // Its axes are the earth's, so it lies turned.
  expectPlaced(tileset(byCenter), "b.gltf/wing", {eastNorthUp(middle).linear, {}}, 1e-4);
  // So it does by itself.
  const Asset alone = readAsset(folder_.path() / "b.gltf", {});
  const std::vector<Vec3d> found = corners(alone, "wing");
  for (int i = 0; i < 3; ++i) EXPECT_LT(length(found[i] - eastNorthUp(middle).linear * kUpright[i]), 1e-5);
}

// A root that spans the globe, and volumes of other kinds, do not say where the tiles are.
TEST_F(Tileset, TheFirstTileOnTheEarthIsTheOrigin) {
  const Affine place = inverse(eastNorthUp(earthCentred(0.2, 0.9, 40)));
  folder_.write("a.gltf", upright().text());
  GltfBuilder earthCentredContent = upright();
  earthCentredContent.json["extensionsUsed"] = {"CESIUM_RTC"};
  earthCentredContent.json["extensions"]["CESIUM_RTC"]["center"] = {place.translation.x, place.translation.y,
                                                                    place.translation.z};
  folder_.write("b.gltf", earthCentredContent.text());
  const Json globe{{"sphere", {0, 0, 0, 7e6}}};
  const Json cell{{"extensions", {{"3DTILES_bounding_volume_S2", {{"token", "3"}}}}}};
  const Json content{{"uri", "a.gltf"}};
  const Json leaf{{"boundingVolume", local()}, {"transform", columns(place)}, {"content", content}};
  for (const Json& volume : {globe, cell}) {
    expectPlaced(tileset({{"boundingVolume", volume}, {"children", {leaf}}}), "a.gltf/wing", {}, 1e-4);
    EXPECT_THAT(refused({{"boundingVolume", volume}, {"content", {{"uri", "b.gltf"}}}}),
                HasSubstr("tileset.json: its bounding volumes do not say where on the earth it lies: add a region"));
  }
}

TEST_F(Tileset, TilesetsWithinTilesetsGoOnFromTheirTile) {
  folder_.write("part/a.gltf", upright().text());
  folder_.write("part/inner.json", Json{{"asset", {{"version", "1.0"}, {"gltfUpAxis", "Z"}}},
                                        {"root", {{"boundingVolume", local()}, {"content", {{"uri", "a.gltf"}}}}}}
                                       .dump());
  const Affine place = toAffine({fromYawPitchRoll(1, 0, 0), {3, 4, 5}});
  const Asset asset =
      tileset({{"boundingVolume", local()}, {"transform", columns(place)}, {"content", {{"uri", "part/inner.json"}}}});
  const std::vector<Vec3d> found = corners(asset, "part/a.gltf/wing");
  const Vec3d zUp[] = {{1, 0, 0}, {0, 2, 0}, {0, 0, 3}};
  for (int i = 0; i < 3; ++i) EXPECT_LT(length(found[i] - place * zUp[i]), 1e-5);
}

TEST_F(Tileset, SeveralContentsOfATileMayStandInAnExtension) {
  folder_.write("a.gltf", upright().text());
  folder_.write("b.gltf", upright().text());
  const Json contents{{"contents", {{{"uri", "a.gltf"}}, {{"uri", "b.gltf"}}}}};
  EXPECT_EQ(
      tileset({{"boundingVolume", local()}, {"extensions", {{"3DTILES_multiple_contents", contents}}}}).parts.size(),
      2u);
}

TEST_F(Tileset, LeftOutContentsAreToldOnceWithTheirNumber) {
  folder_.write("a.gltf", upright().text());
  folder_.write("b.b3dm", b3dm(glb(upright().text()), R"({"BATCH_LENGTH":0})"));
  for (const char* name : {"a.i3dm", "b.i3dm", "a.cmpt", "a.pnts", "a.xyz"}) folder_.write(name, "tile");
  Json contents;
  for (const char* name : {"a.gltf", "b.b3dm", "a.i3dm", "b.i3dm", "a.cmpt", "a.pnts", "a.xyz"}) {
    contents.push_back({{"uri", name}, {"metadata", Json::object()}});
  }
  const Json root{{"boundingVolume", local()}, {"geometricError", 1}, {"shape", 2}, {"contents", contents}};
  EXPECT_THAT(
      printedBy([&] { tileset(root); }),
      AllOf(HasSubstr("2 instanced models (.i3dm)"), HasSubstr("1 composite tiles (.cmpt)"),
            HasSubstr("1 point clouds (.pnts)"), HasSubstr("1 unknown '.xyz'"), HasSubstr("1 batch tables (.b3dm)"),
            HasSubstr("7 metadata"), HasSubstr("1 unknown 'shape'"), testing::Not(HasSubstr("geometricError"))));
}

TEST_F(Tileset, MistakesAreNamed) {
  folder_.write("a.gltf", upright().text());
  folder_.write("cut.b3dm", "b3dm\1");
  folder_.write("short.b3dm", b3dm("", "{").substr(0, 29));
  folder_.write("gz.b3dm", "\x1F\x8B\x08 and more");
  folder_.write("bad.b3dm", b3dm(glb(upright().text()), R"({"RTC_CENTER":{"byteOffset":4}})"));
  const auto root = [](const std::string& version, Json more = Json::object()) {
    more["boundingVolume"] = local();
    return Json{{"asset", {{"version", version}}}, {"root", more}}.dump();
  };
  const auto content = [&](const char* uri) { return root("1.0", {{"content", {{"uri", uri}}}}); };
  expectRefusals([&](const std::string& text) { return messageOf([&] { read("tileset.json", text); }); },
                 {{"{", "tileset.json | not a tileset"},
                  {"{}", "the keys asset and root are missing"},
                  {root("0.0"), "version '0.0'"},
                  {root("1.0"), "has no triangle"},
                  {root("1.0", {{"implicitTiling", Json::object()}}), "implicit tiling"},
                  {root("1.0", {{"extensions", {{"3DTILES_implicit_tiling", Json::object()}}}}), "implicit tiling"},
                  {root("1.0", {{"transform", {1, 2}}}), "not a tileset"},
                  {root("1.0", {{"refine", "additive"}}), "the refine 'additive', but it must be ADD or REPLACE"},
                  {content("https://a/b.glb"), "download"},
                  {content("tileset.json"), "includes itself"},
                  {content("cut.b3dm"), "cut.b3dm | truncated"},
                  {content("short.b3dm"), "longer than the file"},
                  {content("gz.b3dm"), "gz.b3dm | compressed by gzip | gunzip"},
                  {content("bad.b3dm"), "outside the feature table"},
                  {root("1.0", {{"contents", {{{"uri", "gone.glb"}}, {{"uri", "a.gltf"}}, {{"uri", "lost.json"}}}}}),
                   "tileset.json | 'gone.glb' | missing: 'lost.json'"}});
  EXPECT_EQ(readAsset(folder_.path() / "tileset.json", {.leaveOutMissing = true}).parts.size(), 1u);
}

}  // namespace
}  // namespace scanmill
