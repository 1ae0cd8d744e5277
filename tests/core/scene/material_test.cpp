#include "scene/material.h"

#include <fmt/format.h>

#include <fstream>
#include <map>
#include <sstream>

#include "tests/support/labels.h"
#include "tests/support/message_of.h"
#include "tests/support/shared_data.h"
#include "tests/support/temporary_folder.h"

namespace scanmill {
namespace {

const std::filesystem::path kMaterials = kLabels / "materials.yaml";

TEST(Materials, ofTheTableReflectAndAreUntextured) {
  const MaterialLibrary library = readMaterials(kMaterials);
  EXPECT_GT(library.materials.size(), 25u);
  for (const Material& m : library.materials) {
    EXPECT_GT(m.reflectance, 0) << m.name;
    EXPECT_FALSE(m.textured) << m.name;
    EXPECT_EQ(m.texture, nullptr) << m.name;
  }
  for (const std::string name : {"asphalt",       "bark",     "brick",         "car_paint",     "cloth",
                                 "cloth_dark",    "concrete", "default",       "glass",         "grass",
                                 "grass_dry",     "leaf",     "leaf_conifer",  "metal_bare",    "metal_galvanised",
                                 "painted_metal", "paving",   "plaster",       "plastic_black", "road_paint",
                                 "roof_tile",     "rubber",   "skin",          "snow",          "soil",
                                 "water",         "wood",     "wood_weathered"}) {
    EXPECT_NO_THROW(library.require(name, {})) << "scenes need " << name;
  }
  EXPECT_GT(library.require("sign_retroreflective", {}).retroreflectance, 100);
}

TEST(Materials, SurfacesHaveSizesAndHeights) {
  const MaterialLibrary library = readMaterials(kMaterials);
  const Material& grass = library.require("grass", {});
  ASSERT_EQ(grass.relief.size(), 2u);
  EXPECT_EQ(grass.relief[0], (Relief{0.1f, 0.02f}));
  ASSERT_EQ(grass.variations.size(), 2u);
  EXPECT_EQ(grass.variations[1], (Variation{0.15f, 0.25f}));
}

TEST(Materials, theWavelengthPicksTheColumn) {
  EXPECT_FLOAT_EQ(readMaterials(kMaterials, 850).require("snow", {}).reflectance, 0.938f);
  EXPECT_FLOAT_EQ(readMaterials(kMaterials, 905).require("snow", {}).reflectance, 0.911f);
  EXPECT_FLOAT_EQ(readMaterials(kMaterials, 1064).require("snow", {}).reflectance, 0.829f);
  EXPECT_FLOAT_EQ(readMaterials(kMaterials, 1550).require("snow", {}).reflectance, 0.11f);  // all have this column
  expectInputError([] { readMaterials(kMaterials, 532); }, {"532", "905"});
}

TEST(Materials, tablesMayLeaveOut1550nm) {
  const TemporaryFolder folder;
  const auto file = folder.write(
      "m.yaml", "materials:\n  - {name: stone, reflectance: {850: 0.1, 905: 0.2, 1064: 0.3}, source: x}\n");
  EXPECT_FLOAT_EQ(readMaterials(file, 1064).materials[0].reflectance, 0.3f);
  expectInputError([&] { readMaterials(file, 1550); }, {"m.yaml:2", "'stone'", "1550"});
}

// A source "row: name of the library" quotes a row of measurements: its figures must be that row's.
TEST(Materials, quotedFiguresAreThoseOfTheirSource) {
  SKIP_WITHOUT_SHARED_DATA("materials/nir_reflectance.csv");
  std::ifstream file(sharedData() / "materials" / "nir_reflectance.csv");
  std::map<std::string, std::array<double, 3>> rows;
  std::map<std::string, std::string> sources;
  for (std::string line; std::getline(file, line);) {
    std::istringstream cells(line);
    std::string name, r850, r905, r1064, source;
    if (!std::getline(cells, name, ',') || !std::getline(cells, r850, ',') || !std::getline(cells, r905, ',') ||
        !std::getline(cells, r1064, ',') || !std::getline(cells, source) || name[0] == '#' || name == "material") {
      continue;
    }
    rows[name] = {std::stod(r850) / 100, std::stod(r905) / 100, std::stod(r1064) / 100};
    sources[name] = source;
  }
  ASSERT_GT(rows.size(), 20u);
  const int wavelengths[] = {850, 905, 1064};
  int quoted = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    for (const Material& m : readMaterials(kMaterials, wavelengths[i]).materials) {
      const std::string row = m.source.substr(0, m.source.find(':'));
      if (row == "estimate" || row == "computed") continue;
      ASSERT_TRUE(rows.contains(row)) << m.name << " quotes " << m.source;
      EXPECT_EQ(m.source, row + ": " + sources[row]);
      EXPECT_NEAR(m.reflectance, rows[row][i], 1e-6) << m.name;
      ++quoted;
    }
  }
  EXPECT_GE(quoted, 3 * 15);
}

TEST(Materials, glassFollowsFresnel) {
  const double face = std::pow((1.52 - 1) / (1.52 + 1), 2);
  const double pane = 2 * face / (1 + face);  // both faces, all inner reflections
  EXPECT_NEAR(readMaterials(kMaterials).require("glass", {}).reflectance, pane, 1e-3);
}

TEST(Materials, unknownOneIsRefusedWithSuggestion) {
  const MaterialLibrary library = readMaterials(kMaterials);
  expectInputError([&] { library.require("asfalt", {"s.yaml", 4, 1}); }, {"s.yaml:4:1", "'asfalt'", "asphalt"});
}

TEST(Materials, badFilesAreRefusedWithTheirPlace) {
  const TemporaryFolder folder;
  const auto refuse = [&](const std::string& text, const std::vector<std::string>& words) {
    const auto file = folder.write("bad.yaml", text);
    SCOPED_TRACE(text);
    expectInputError([&] { readMaterials(file); }, words);
  };
  EXPECT_TRUE(readMaterials(folder.write("none.yaml", "materials: []\n")).materials.empty());
  refuse("materials: {}\n", {"bad.yaml:1"});
  refuse("materials:\n  - {name: a, reflectance: 1.5, source: x}\n", {"bad.yaml:2", "reflectance"});
  refuse("materials:\n  - {name: a, reflectance: .nan, source: x}\n", {"bad.yaml:2", "reflectance"});
  refuse("materials:\n  - {name: a, reflectance: {850: 0.1, 905: 0.1}, source: x}\n", {"bad.yaml:2", "1064"});
  refuse("materials:\n  - {name: a, reflectance: 0.5}\n", {"bad.yaml:2", "source"});
  refuse("materials:\n  - {name: a, reflectance: 0.5, source: x, roughnes: 1}\n", {"bad.yaml:2", "roughness"});
  refuse("materials:\n  - {name: a, reflectance: 0.5, source: x, relief: 0.1}\n", {"bad.yaml:2", "height_m: 0.02"});
  refuse("materials:\n  - {name: a, reflectance: 0.5, source: x, relief: [{size_m: 0, height_m: 0.1}]}\n",
         {"bad.yaml:2", "size_m"});
  refuse("materials:\n  - {name: a, reflectance: 0, source: x}\n  - {name: a, reflectance: 0, source: x}\n",
         {"bad.yaml:3", "twice"});
  for (const char* range : {"0.2", "[0.2]", "[0, 0.6]", "[0.55, 0.6]", "[0.2, 0.45]"}) {
    refuse(fmt::format("materials:\n  - {{name: a, reflectance: 0.5, source: x, range_source: y, range: {}}}\n", range),
           {"bad.yaml:2", "range"});
  }
  refuse("materials:\n  - {name: a, reflectance: 0.5, source: x, range: [0.2, 0.6]}\n", {"bad.yaml:2", "range_source"});
}

TEST(Materials, rangesMayEndAtTheReflectance) {
  const TemporaryFolder folder;
  for (const char* figures : {"reflectance: 0.3, range: [0.1, 0.3]", "reflectance: 0.7, range: [0.7, 0.9]"}) {
    const auto file =
        folder.write("m.yaml", fmt::format("materials:\n  - {{name: a, source: x, range_source: y, {}}}\n", figures));
    EXPECT_LT(readMaterials(file).materials[0].least, readMaterials(file).materials[0].greatest) << figures;
  }
}

// A range is stated at 905 nm and scaled to the other wavelengths.
TEST(Materials, rangesFollowTheWavelength) {
  const TemporaryFolder folder;
  const auto file = folder.write("m.yaml",
                                 "materials:\n  - {name: a, reflectance: {850: 0.2, 905: 0.4, 1064: 0.6}, source: x, "
                                 "range: [0.2, 0.5], range_source: y}\n  - {name: b, reflectance: 0.3, source: x}\n");
  for (const auto& [wavelength, mean] : {std::pair{850, 0.2f}, {905, 0.4f}, {1064, 0.6f}}) {
    const MaterialLibrary library = readMaterials(file, wavelength);
    EXPECT_FLOAT_EQ(library.materials[0].least, mean / 2);
    EXPECT_FLOAT_EQ(library.materials[0].greatest, mean * 1.25f);
    EXPECT_EQ(library.materials[1].least, library.materials[1].greatest);
  }
}

}  // namespace
}  // namespace scanmill
