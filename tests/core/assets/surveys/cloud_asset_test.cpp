#include <fmt/format.h>

#include <cstring>
#include <set>
#include <tuple>

#include "assets/meshes/asset_parts.h"
#include "assets/surveys/surveys.h"
#include "scene/texture.h"
#include "tests/core/assets/read_assets.h"
#include "tests/support/message_of.h"
#include "tests/support/shared_data.h"
#include "tests/support/temporary_folder.h"

namespace scanmill {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::UnorderedElementsAre;

// A PLY in text: its properties besides x, y, z, and its lines.
std::string ply(const std::string& properties, const std::vector<std::string>& lines) {
  std::string text = fmt::format("ply\nformat ascii 1.0\nelement vertex {}\n", lines.size());
  for (const char* axis : {"x", "y", "z"}) text += fmt::format("property double {}\n", axis);
  text += properties + "end_header\n";
  for (const std::string& line : lines) text += line + "\n";
  return text;
}

// A level square of points, 0.1 m apart.
std::vector<std::string> lawn(const std::string& more, double x0 = 0, double y0 = 0) {
  std::vector<std::string> lines;
  for (int i = 0; i < 20; ++i) {
    for (int j = 0; j < 20; ++j) lines.push_back(fmt::format("{} {} 5 {}", x0 + 0.1 * i, y0 + 0.1 * j, more));
  }
  return lines;
}

// Returns the reflectance of a point.
double reflectanceAt(const Asset& asset, std::size_t k) {
  const AssetPart& part = asset.parts.at(0);
  const Vec2f uv = part.uvs.at(4 * k);
  const Material& own = part.fileMaterial;
  return own.reflectance * luminance(own.texture->texel(uv.x, uv.y)) / own.textureMean;
}

class Clouds : public testing::Test {
 protected:
  Asset read(const std::string& text, const AssetOptions& options = {}) const {
    return readAsset(folder_.write("a.ply", text), options);
  }
  Scene scene(const std::string& object) const {
    return sceneOf(folder_, "objects:\n  - {file: a.ply" + object + "}\n");
  }
  TemporaryFolder folder_;
};

// Two triangles a point, of a disc's area, square to the normal, about the point: also where coordinates are large.
TEST_F(Clouds, EveryPointIsASquareAsLargeAsItsDisc) {
  const Asset asset = read(ply("", lawn("", 691000, 5334000)));
  ASSERT_EQ(asset.parts.size(), 1u);
  const AssetPart& part = asset.parts[0];
  ASSERT_EQ(part.triangles.size(), 800u);
  Box box;
  for (const Vec3f& p : part.positions) EXPECT_NEAR(p.z, 5, 1e-5);
  for (std::size_t k = 0; k < 400; ++k) {
    Vec3d middle;
    for (std::size_t c = 0; c < 4; ++c) middle = middle + Vec3d(part.positions[4 * k + c]) * 0.25;
    box.add(asset.origin + middle);
  }
  EXPECT_LT(length(box.low - Vec3d{691000, 5334000, 5}), 1e-4);
  EXPECT_LT(length(box.high - Vec3d{691001.9, 5334001.9, 5}), 1e-4);
  // In the middle the twelfth neighbour is 0.2 m away: a share of pi 0.04 / 12.
  const std::size_t k = 10 * 20 + 10;
  const double side = length(Vec3d(part.positions[4 * k + 1]) - Vec3d(part.positions[4 * k]));
  EXPECT_NEAR(side * side, 1.5 * 1.5 * kPi * 0.04 / 12, 1e-6);
}

TEST_F(Clouds, LabelsAndInstancesAreCarriedOver) {
  std::vector<std::string> lines = lawn("40 0");
  for (const std::string& line : lawn("10 7", 50)) lines.push_back(line);
  for (const std::string& line : lawn("10 9", 90)) lines.push_back(line);
  read(ply("property int label\nproperty int instance\n", lines));
  // SemanticKITTI's 40 is road, its 10 a car.
  const Scene s = scene(", points: {labels: semantic_kitti}");
  EXPECT_EQ(s.things(), 2u);
  std::set<std::pair<std::string, std::uint32_t>> found;
  const Mesh& mesh = s.meshes.at(0);
  for (const Surface& surface : mesh.surfaces) found.emplace(s.ontology.find(surface.semantic)->name, surface.object);
  EXPECT_THAT(found, UnorderedElementsAre(std::pair{"road", 0u}, std::pair{"car", 1u}, std::pair{"car", 2u}));
  EXPECT_TRUE(s.unlabeled.empty());
  // Rules go before what the file says, and numbers are names where nothing says what they mean.
  const Scene other = scene(", rules: [{match: {material: \"10\"}, class: truck}]");
  std::set<std::string> classes;
  for (const Surface& surface : other.meshes.at(0).surfaces)
    classes.insert(other.ontology.find(surface.semantic)->name);
  EXPECT_THAT(classes, UnorderedElementsAre("truck", "unlabeled"));
}

// SemanticKITTI's 10 is a car, its 30 a pedestrian, its 40 road; it counts the instances of each class from 1.
TEST_F(Clouds, ClassesShareNoInstance) {
  const auto found = [&](const std::string& properties, const std::vector<std::string>& labels,
                         const std::string& more = "") {
    std::vector<std::string> lines;
    for (const std::string& label : labels) {
      for (const std::string& line : lawn(label, 0.01 * static_cast<double>(lines.size()))) lines.push_back(line);
    }
    folder_.write("a.ply", ply(properties, lines));
    testing::internal::CaptureStderr();
    const Scene s = scene(", points: {labels: semantic_kitti}" + more);
    const std::string told = testing::internal::GetCapturedStderr();
    std::set<std::pair<std::string, std::uint32_t>> objects;
    for (const Surface& surface : s.meshes.at(0).surfaces)
      objects.emplace(s.ontology.find(surface.semantic)->name, surface.object);
    return std::pair(objects, told);
  };
  const std::string both = "property int label\nproperty int instance\n";
  auto [objects, told] = found(both, {"10 1", "30 1", "10 2"});
  EXPECT_THAT(objects, UnorderedElementsAre(std::pair{"car", 1u}, std::pair{"pedestrian", 2u}, std::pair{"car", 3u}));
  EXPECT_EQ(told, "");
  std::tie(objects, told) = found("property int label\n", {"10", "30", "40"});
  EXPECT_THAT(objects, UnorderedElementsAre(std::pair{"car", 1u}, std::pair{"pedestrian", 2u}, std::pair{"road", 0u}));
  EXPECT_THAT(told, HasSubstr("a.ply: 800 points of classes of things have no instance"));
  std::tie(objects, told) = found(both, {"10 0", "10 4"});
  EXPECT_THAT(told, HasSubstr("a.ply: 400 points of classes of things have no instance"));
  std::tie(objects, told) = found(both, {"10 0", "10 4"}, ", instances: object");
  EXPECT_THAT(objects, UnorderedElementsAre(std::pair{"car", 1u}));
  EXPECT_EQ(told, "");
}

TEST_F(Clouds, TheMaterialOfALabelStatesTheMeanOfItsPoints) {
  std::vector<std::string> lines = lawn("51 1");
  for (const std::string& line : lawn("204 2", 50)) lines.push_back(line);
  const Asset asset = read(ply("property float intensity\nproperty int label\n", lines));
  ASSERT_EQ(asset.parts.size(), 2u);
  for (const std::size_t i : {0u, 1u}) {
    const Material& m = asset.parts[i].fileMaterial;
    EXPECT_NEAR(m.reflectance, i == 0 ? 0.2 : 0.8, 0.004);
    EXPECT_EQ(m.reflectance, m.textureMean) << "each point keeps its own reflectance";
    EXPECT_EQ(m.source, "mean of the intensities in a.ply; each point has its own");
  }
}

TEST_F(Clouds, IntensitiesAreReflectances) {
  std::vector<std::string> lines = lawn("51");
  for (const std::string& line : lawn("204", 50)) lines.push_back(line);
  const std::string text = ply("property float intensity\n", lines);
  const Asset asset = read(text);
  const Material& m = asset.parts.at(0).fileMaterial;
  EXPECT_TRUE(m.textured);
  EXPECT_NEAR(reflectanceAt(asset, 3), 0.2, 0.004) << "of 255";
  EXPECT_NEAR(reflectanceAt(asset, 500), 0.8, 0.004);
  EXPECT_NEAR(m.reflectance, 0.5, 0.006) << "a few texels more than points";
  AssetOptions options;
  options.points.full = 510;
  EXPECT_NEAR(reflectanceAt(read(text, options), 500), 0.4, 0.004);
  options.points.reflectance = PointOptions::Reflectance::None;
  EXPECT_FALSE(read(text, options).parts.at(0).fileMaterial.textured);
  options.points.reflectance = PointOptions::Reflectance::Color;
  EXPECT_THAT(messageOf([&] { read(text, options); }), HasSubstr("has no colours"));
}

// A wall whose points have the intensity `usual`, and one more point: one that is saturated does not darken the others,
// ordinary scales are taken in silence, and what is no reflectance is told.
TEST_F(Clouds, IntensitiesHaveAScaleThatIsGuessedOrStated) {
  struct Row {
    const char *usual, *last;
    double full;  // stated; 0: it is guessed
    double reflectance;
    std::vector<const char*> told;
  };
  int files = 0;
  for (const Row& row : {Row{"300",
                             "65535",
                             0,
                             1,
                             {"the intensity 300 is taken as a reflectance of 1: 1 of 400 points are above",
                              "the greatest is 65535", "points: {full: ...}"}},
                         {"300", "65535", 65535, 300.0 / 65535, {}},
                         {"100", "65535", 0, 100.0 / 255, {"the intensity 255 is taken"}},
                         {"0.5", "1", 0, 0.5, {}},
                         {"51", "255", 0, 0.2, {}},
                         {"1000", "2000", 0, 0.5, {}},
                         {"0.5", "1.2", 0, 0.5, {"the intensity 1 is taken"}},
                         {"nan", "200", 0, 0, {"399 are no numbers"}},
                         {"-3.5", "2", 0, 0, {"399 are below 0"}}}) {
    std::vector<std::string> lines = lawn(row.usual);
    lines.back() = fmt::format("1.9 1.9 5 {}", row.last);
    AssetOptions options;
    options.points.full = row.full;
    testing::internal::CaptureStderr();
    const Asset asset =
        readAsset(folder_.write(fmt::format("{}.ply", ++files), ply("property float intensity\n", lines)), options);
    const std::string told = testing::internal::GetCapturedStderr();
    EXPECT_NEAR(reflectanceAt(asset, 0), row.reflectance, 0.01) << row.usual << ' ' << row.last;
    EXPECT_EQ(told.empty(), row.told.empty()) << told;
    for (const char* words : row.told) EXPECT_THAT(told, HasSubstr(words));
  }
}

TEST_F(Clouds, ColumnsWithoutAUseAreTold) {
  testing::internal::CaptureStderr();
  read(
      ply("property int class\nproperty int label\nproperty float nir\nproperty double gps_time\nproperty list uchar "
          "int w\n",
          lawn("1 2 3 4 1 5")));
  EXPECT_THAT(testing::internal::GetCapturedStderr(),
              HasSubstr("a.ply: left out: 2 columns (class, nir), 1 lists at vertices 'w'"));
}

// A LAS of 400 points at 1 unit of the US survey foot from each other, of the classes 2 and 7 (noise).
std::string lasInFeet() {
  std::string bytes(227 + 54 + 16 + 400 * 20, '\0');
  const auto put = [&](std::size_t at, auto value) { std::memcpy(bytes.data() + at, &value, sizeof value); };
  bytes.replace(0, 4, "LASF");
  bytes.replace(229, 15, "LASF_Projection");
  bytes[24] = 1, bytes[25] = 2, bytes[100] = 1, bytes[105] = 20;
  put(94, std::uint16_t{227}), put(96, std::uint32_t{297}), put(107, std::uint32_t{400});
  for (std::size_t axis = 0; axis < 3; ++axis) put(131 + 8 * axis, 0.01);
  put(245, std::uint16_t{34735}), put(247, std::uint16_t{16});
  for (std::size_t k = 0; const int number : {1, 1, 0, 1, 3076, 0, 1, 9003}) {
    put(281 + 2 * k++, static_cast<std::uint16_t>(number));
  }
  for (int i = 0; i < 400; ++i) {
    const std::size_t at = 297 + 20 * static_cast<std::size_t>(i);
    put(at, 100 * (i / 20)), put(at + 4, 100 * (i % 20));
    bytes[at + 15] = i == 399 ? 7 : 2;
  }
  return bytes;
}

TEST_F(Clouds, AStatedUnitGoesBeforeThatOfLas) {
  const auto file = folder_.write("a.las", lasInFeet());
  const auto width = [&](const AssetOptions& options) {
    Box box;
    const Asset asset = readAsset(file, options);
    for (const Vec3f& p : asset.parts.at(0).positions) box.add(Vec3d(p));
    return box.high.x - box.low.x;
  };
  testing::internal::CaptureStderr();
  EXPECT_NEAR(width({}), 19 * 0.3048, 0.5);
  EXPECT_THAT(testing::internal::GetCapturedStderr(),
              AllOf(HasSubstr("a.las: its coordinate system cannot be read"), HasSubstr("units of 0.3048006096 m"),
                    HasSubstr("a.las: left out: 1 points of classes of noise")));
  EXPECT_NEAR(width({.unitStated = true}), 19, 0.5);
  EXPECT_NEAR(width({.metresPerUnit = 2, .unitStated = true}), 38, 0.5);
}

// Points of a PCD stand where its VIEWPOINT puts them, with their normals.
TEST_F(Clouds, ThePoseOfAPcdIsTaken) {
  std::string text =
      "FIELDS x y z normal_x normal_y normal_z\nSIZE 4 4 4 4 4 4\nTYPE F F F F F F\nWIDTH 400\nHEIGHT 1\n"
      "VIEWPOINT 691000 20 30 0.70710678 0 0.70710678 0\nPOINTS 400\nDATA ascii\n";
  for (const std::string& line : lawn("0 0 1")) text += line + "\n";
  const Asset asset = readAsset(folder_.write("a.pcd", text), {});
  Box box;
  for (std::size_t k = 0; k < 400; ++k) {
    Vec3d middle;
    for (std::size_t c = 0; c < 4; ++c) middle = middle + Vec3d(asset.parts[0].positions[4 * k + c]) * 0.25;
    box.add(asset.origin + middle);
  }
  EXPECT_LT(length(box.low - Vec3d{691005, 20, 28.1}), 1e-3) << "x of the file is down, z of the file is x";
  EXPECT_LT(length(box.high - Vec3d{691005, 21.9, 30}), 1e-3);
}

TEST_F(Clouds, ColoursAreReflectancesWhereThereIsNoIntensity) {
  const std::string green = "property uchar red\nproperty uchar green\nproperty uchar blue\n";
  const Asset asset = read(ply(green, lawn("0 255 0")));
  EXPECT_NEAR(asset.parts.at(0).fileMaterial.reflectance, 0.7152, 1e-3);
  const Scene s = scene(", rules: [{match: {color: \"#00ff00\"}, class: terrain}]");
  EXPECT_TRUE(s.unlabeled.empty());
}

TEST_F(Clouds, ColoursHaveTheScaleOfTheirTypeAndPackedOnesThatOfTheirBits) {
  const auto first = [&](const std::string& name, const std::string& text) {
    const Asset asset = readAsset(folder_.write(name, text), {});
    const std::vector<std::uint8_t>& rgba = asset.parts.at(0).fileMaterial.texture->rgba;
    return std::vector<int>(rgba.begin(), rgba.begin() + 3);
  };
  const auto plyOf = [&](const std::string& type, const std::string& values) {
    std::string properties;
    for (const char* color : {"red", "green", "blue"}) properties += fmt::format("property {} {}\n", type, color);
    return first("a.ply", ply(properties, lawn(values)));
  };
  EXPECT_EQ(plyOf("float", "1.0000001 0.5 0"), (std::vector{255, 128, 0}));
  EXPECT_EQ(plyOf("uchar", "1 1 0"), (std::vector{1, 1, 0}));
  EXPECT_EQ(plyOf("ushort", "65535 32896 0"), (std::vector{255, 128, 0}));
  testing::internal::CaptureStderr();
  EXPECT_EQ(plyOf("ushort", "3840 100 0"), (std::vector{15, 0, 0}));
  EXPECT_THAT(testing::internal::GetCapturedStderr(), HasSubstr("its greatest colour is 3840, but 65535 is taken"));
  const std::vector packed{0xFF, 0x80, 0x40};
  for (const char* number : {"16744512", "2.3464059e-38"}) {  // an integer, and the float of its bits
    EXPECT_EQ(first("a.csv", fmt::format("x,y,z,rgb\n0,0,0,{0}\n1,0,0,{0}\n0,1,0,{0}\n1,1,0,{0}\n", number)), packed)
        << number;
  }
  testing::internal::CaptureStderr();
  EXPECT_EQ(first("a.ply", ply("property float rgb\n", {"0 0 0 nan", "1 0 0 2.3464059e-38", "0 1 0 0", "1 1 0 0"})),
            (std::vector{0, 0, 0}));
  EXPECT_THAT(testing::internal::GetCapturedStderr(), HasSubstr("left out: 1 colours that are no numbers"));
}

TEST_F(Clouds, SeveralPointsAtZeroAreMisses) {
  std::vector<std::string> lines = lawn("", 3);
  testing::internal::CaptureStderr();
  lines.push_back("0 0 0");
  EXPECT_EQ(trianglesOf(read(ply("", lines))), 2u * 401);
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
  testing::internal::CaptureStderr();
  lines.push_back("0 0 0");
  EXPECT_EQ(trianglesOf(read(ply("", lines))), 2u * 400);
  EXPECT_THAT(testing::internal::GetCapturedStderr(), HasSubstr("left out: 2 points at 0, 0, 0, which are misses"));
}

TEST_F(Clouds, MayBeThinnedOut) {
  const AssetOptions options{.points = {.spacing = 0.5}};
  EXPECT_EQ(read(ply("", lawn("", 0.01, 0.01)), options).parts.at(0).triangles.size(), 2u * 4 * 4);
}

TEST_F(Clouds, MistakesAreNamed) {
  for (const char* point : {"", "nan nan nan"}) {
    EXPECT_THAT(messageOf([&] { read(ply("", std::vector<std::string>(*point == '\0' ? 0 : 1, point))); }),
                AllOf(HasSubstr("a.ply"), HasSubstr("has no point")));
  }
  folder_.write("b.obj", "o a\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  for (const auto& [properties, values, object, words] :
       {std::tuple{"", "", ", points: {spacng: 3}", "scene.yaml:4:"},
        {"", "", ", points: {spacng: 3}", "'spacng'"},
        {"", "", ", points: {radius: [2, 1]}", "[least, most]"},
        {"", "", ", heights: {every: 2}", "rasters, such as .tif"},
        {"", "", ", points: {labels: scanmill}",
         "a.ply: has no labels (a column `label`, or LAS classes), but x, y, z"},
        {"property int class\n", "70000", ", points: {labels: scanmill}",
         "; left out: 1 columns 'class' (label of point 0 is 70000: no integer of 0 to 65535): leave"},
        {"", "", "}\n  - {file: b.obj, points: {}", "point clouds"}}) {
    read(ply(properties, lawn(values)));
    EXPECT_THAT(messageOf([&] { scene(object); }), HasSubstr(words));
  }
}

// A revolution of a real sensor: its points are where the surfaces are.
TEST_F(Clouds, ARealRevolutionIsASceneOfItsPoints) {
  SKIP_WITHOUT_SHARED_DATA("lidar/ouster_os1_128");
  const Asset asset = readAsset(sharedData() / "lidar/ouster_os1_128/frame_1795.pcd", {});
  EXPECT_EQ(trianglesOf(asset), 2u * 107647);
  EXPECT_TRUE(asset.parts[0].fileMaterial.textured) << "by its reflectivity";
}

}  // namespace
}  // namespace scanmill
