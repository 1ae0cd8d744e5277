#include <iterator>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "assets/meshes/asset_parts.h"
#include "assets/surveys/surveys.h"
#include "base/file.h"
#include "tests/core/assets/read_assets.h"
#include "tests/support/geo_tiff.h"
#include "tests/support/message_of.h"
#include "tests/support/temporary_folder.h"

namespace scanmill {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

double slope(double x, double y) {
  return 0.2 * (x - 500000) - 0.1 * (y - 5400000) + 300;
}

void expectOnSlope(const Asset& asset) {
  for (const Vec3f& p : asset.parts.at(0).positions) {
    const Vec3d at = asset.origin + Vec3d(p);
    EXPECT_NEAR(at.z, slope(at.x, at.y), 1e-3);
  }
}

// Heights of a plane in UTM coordinates: 30 x 20 samples of 5 m, the first of which is at [500002.5, 5400097.5].
GeoTiff tilted() {
  GeoTiff tiff{30, 20, {}, 500000, 5400100, 5};
  for (int row = 0; row < 20; ++row) {
    for (int column = 0; column < 30; ++column) {
      tiff.values.push_back(static_cast<float>(slope(500002.5 + 5 * column, 5400097.5 - 5 * row)));
    }
  }
  return tiff;
}

class Heights : public testing::Test {
 protected:
  Asset read(const GeoTiff& tiff, const AssetOptions& options = {}) const {
    return readAsset(folder_.write("dem.tif", tiff.bytes()), options);
  }
  std::string refused(const GeoTiff& tiff, const AssetOptions& options = {}) const {
    return messageOf([&] { read(tiff, options); });
  }
  std::string refusedGrid(const std::string& text) const {
    const auto file = folder_.write("g.asc", text);
    return messageOf([&] { readAsset(file, {}); });
  }

  // Returns a band of a mosaic that takes its samples from `file`. `states`: what the mosaic says of the band.
  static std::string band(const std::string& file, const std::string& states = "", const char* type = "Float32") {
    return std::string("<VRTRasterBand dataType=\"") + type + "\">" + states +
           "<SimpleSource><SourceFilename relativeToVRT=\"1\">" + file +
           "</SourceFilename><SourceBand>1</SourceBand></SimpleSource></VRTRasterBand>";
  }
  // Writes dem.vrt of 6 x 4 samples of 5 m, with these bands.
  std::filesystem::path mosaic(const std::string& bands, const std::string& system = "EPSG:32633",
                               const std::string& transform = "500000, 5, 0, 5400100, 0, -5") const {
    return folder_.write("dem.vrt", "<VRTDataset rasterXSize=\"6\" rasterYSize=\"4\"><SRS>" + system +
                                        "</SRS><GeoTransform>" + transform + "</GeoTransform>" + bands +
                                        "</VRTDataset>");
  }
  // Returns what is warned of while the file is read, and its least and greatest height.
  struct Reading {
    Box box;
    std::size_t triangles = 0;
    std::string warnings;
  };
  static Reading reading(const std::filesystem::path& file, const AssetOptions& options = {}) {
    testing::internal::CaptureStderr();
    try {
      const Asset asset = readAsset(file, options);
      return {boundsOf(asset), trianglesOf(asset), testing::internal::GetCapturedStderr()};
    } catch (const InputError& e) {
      testing::internal::GetCapturedStderr();
      ADD_FAILURE() << e.what();
      return {};
    }
  }
  TemporaryFolder folder_;
};

TEST_F(Heights, AreWhereTheRasterSaysToTheMillimetre) {
  const Asset asset = read(tilted());
  ASSERT_EQ(asset.parts.size(), 1u);
  EXPECT_EQ(asset.parts[0].positions.size(), 600u);
  EXPECT_EQ(trianglesOf(asset), 2u * 29 * 19);
  expectOnSlope(asset);
  const Box box = boundsOf(asset);
  EXPECT_NEAR(box.low.x, 500002.5, 1e-3);
  EXPECT_NEAR(box.high.y, 5400097.5, 1e-3);
  for (const Triangle& t : asset.parts[0].triangles) {
    const auto& p = asset.parts[0].positions;
    EXPECT_GT(cross(Vec3d(p[t[1]]) - Vec3d(p[t[0]]), Vec3d(p[t[2]]) - Vec3d(p[t[0]])).z, 0) << "facing up";
  }
}

// The mean of a plane's samples is the plane at their middle, so a coarser raster is the same surface.
TEST_F(Heights, MayBeTakenCoarserAndInPart) {
  AssetOptions options;
  options.heights.every = 4;
  const Asset coarse = read(tilted(), options);
  EXPECT_EQ(coarse.parts.at(0).positions.size(), 7u * 5);
  expectOnSlope(coarse);
  options.heights.every = 1;
  options.heights.within = {{500050, 5400000, 500100, 5400050}};
  const Asset part = read(tilted(), options);
  EXPECT_EQ(part.parts.at(0).positions.size(), 10u * 10);
  const Box box = boundsOf(part);
  EXPECT_NEAR(box.low.x, 500052.5, 1e-3);
  EXPECT_NEAR(box.high.y, 5400047.5, 1e-3);
  options.heights.within = {{0, 0, 10, 10}};
  EXPECT_THAT(refused(tilted(), options), AllOf(HasSubstr("no sample there"), HasSubstr("[500002.5, 5400002.5]")));
}

TEST_F(Heights, WithoutAValueAreHoles) {
  GeoTiff tiff = tilted();
  tiff.none = "-9999";
  tiff.values[5 * 30 + 7] = -9999;  // touches four cells
  tiff.values[0] = NAN;             // touches one
  EXPECT_EQ(trianglesOf(read(tiff)), 2u * (29 * 19 - 5));
}

// A flat place with a pit of two samples in the middle of the second row, which touch six cells.
GeoTiff flat(float height, float pit) {
  GeoTiff tiff{6, 4, std::vector<float>(24, height), 500000, 5400100, 5};
  tiff.values[8] = tiff.values[9] = pit;
  return tiff;
}

TEST_F(Heights, HolesAreWhatTheFileMarksInAnyWay) {
  folder_.write("dem.tif", flat(30, 0).bytes());
  folder_.write("mask.tif", flat(255, 0).bytes());
  const std::string masked = "<MaskBand>" + band("mask.tif", "", "Byte") + "</MaskBand>";
  const std::string none = "<NoDataValue>-9999</NoDataValue>";
  for (const std::string& bands :
       {band("dem.tif") + masked, band("dem.tif", none) + masked, band("dem.tif", "<NoDataValue>0</NoDataValue>"),
        band("dem.tif") + band("mask.tif", "<ColorInterp>Alpha</ColorInterp>", "Byte"),
        band("dem.tif", none) + band("dem.tif") + band("mask.tif", "<ColorInterp>Alpha</ColorInterp>")}) {
    const Reading found = reading(mosaic(bands));
    EXPECT_EQ(found.triangles, 2u * (15 - 6)) << bands;
    EXPECT_EQ(found.box.low.z, 30) << bands;
    AssetOptions options;
    options.heights.every = 2;
    EXPECT_EQ(reading(mosaic(bands), options).box.low.z, 30) << "means leave holes out: " << bands;
  }
  folder_.write("beside.tif", flat(30, 7).bytes());
  folder_.write("beside.tif.aux.xml",
                "<PAMDataset><PAMRasterBand band=\"1\"><NoDataValue>7</NoDataValue>"
                "</PAMRasterBand></PAMDataset>");
  EXPECT_EQ(reading(folder_.path() / "beside.tif").triangles, 2u * (15 - 6));
  // Files round the value in their texts.
  for (const auto& [value, text] : {std::pair{-9999.9f, "-9999.9"},
                                    {-3.40282347e38f, "-3.40282e+38"},
                                    {-3.40282347e38f, "-3.4028234663852886e+38"},
                                    {1e20f, "1e+20"}}) {
    GeoTiff tiff = flat(30, value);
    tiff.none = text;
    EXPECT_EQ(trianglesOf(read(tiff)), 2u * (15 - 6)) << text;
  }
}

// Nothing lies in the western third of the mosaic.
TEST_F(Heights, GapsOfMosaicsAreHolesAndFilesStayAsTheyAre) {
  folder_.write("dem.tif", flat(30, 30).bytes());
  for (const char* type : {"Float32", "Int16"}) {
    std::string bands = band("dem.tif", "", type);
    bands.insert(bands.find("</SimpleSource>"),
                 R"(<DstRect xOff="2" yOff="0" xSize="4" ySize="4"/><SrcRect xOff="0" yOff="0" xSize="4" ySize="4"/>)");
    const auto file = mosaic(bands);
    const std::string before = readFile(file);
    const Reading found = reading(file);
    EXPECT_EQ(found.triangles, 2u * 3 * 3) << type;
    EXPECT_EQ(found.box.low.z, 30) << type;
    EXPECT_EQ(readFile(file), before);
  }
  const std::filesystem::directory_iterator files(folder_.path());
  EXPECT_EQ(std::distance(begin(files), end(files)), 2);
}

// Returns the message if the file is refused, else what is warned of.
std::string saidOf(const std::filesystem::path& file, const AssetOptions& options = {}) {
  testing::internal::CaptureStderr();
  const std::string message = messageOf([&] { readAsset(file, options); });
  const std::string warnings = testing::internal::GetCapturedStderr();
  return message == "accepted" ? warnings : message;
}

// Heights and coordinates that cannot be, or that contradict their system.
TEST_F(Heights, ThatNoPlaceHasAreRefusedOrTold) {
  GeoTiff north = flat(30, 40);
  north.epsg = 4326;
  const GeoTiff steep{6, 4, {flat(30, 60).values}, 11, 48, 0.001, 32633};
  AssetOptions coarse;
  coarse.heights.every = 2;
  int files = 0;
  for (const auto& [tiff, options, words] :
       {std::tuple<GeoTiff, AssetOptions, std::vector<const char*>>{
            flat(30, -32768), {}, {"has a height of -32768 m", "gdal_edit.py -a_nodata"}},
        {flat(30, 3e38f), {}, {"has a height of 3.00000001e+38"}},
        {flat(30, -9999), {}, {"has samples of -9999"}},
        {flat(30, -9999), coarse, {"has samples of -9999"}},
        {flat(-10500, -9999), {}, {"has samples of -9999"}},  // which are the greatest
        {north, {}, {"has the latitude 54000", "gdal_edit.py -a_srs"}},
        {steep, {}, {"rises by 30 m within 0.005831 units of its coordinate system"}},
        {{1, 3, {1, 2, 3}, 0, 0, 1}, {}, {"at least two"}},
        {{2, 2, {NAN, 2, 3, 4}, 0, 0, 1}, {}, {"no cell whose four samples"}},
        {tilted(), {.up = 'y'}, {"leave out `up`"}}}) {
    const std::string name = std::to_string(++files) + ".tif";
    const std::string said = saidOf(folder_.write(name, tiff.bytes()), options);
    for (const char* part : words) EXPECT_THAT(said, AllOf(HasSubstr(name + ": "), HasSubstr(part)));
  }
}

TEST_F(Heights, OfMosaicsAreReadOrSaidWhatTheyAre) {
  folder_.write("dem.tif", flat(30, 40).bytes());
  folder_.write("pit.tif", flat(30, -9999).bytes());
  folder_.write("inner.vrt", readFile(mosaic(band("dem.tif"))));
  const std::string plain = band("dem.tif"), utm = "EPSG:32633";
  const std::string moon =
      "GEOGCS[\"Moon\",DATUM[\"D\",SPHEROID[\"S\",1737400,0]],PRIMEM[\"P\",0],UNIT[\"degree\",0.0174532925199433]]";
  const std::string alps = "890000, 5, 0, 5900000, 0, -5";  // at 46.9 degrees of latitude in Web Mercator
  const auto called = [](const char* color) {
    return band("dem.tif", std::string("<ColorInterp>") + color + "</ColorInterp>", "Byte");
  };
  for (const auto& [bands, system, transform, words] :
       {std::tuple<std::string, std::string, std::string, std::vector<const char*>>{
            band("inner.vrt"), utm, "", {"is a mosaic of mosaics such as", "inner.vrt", "gdalbuildvrt"}},
        {band("pit.tif", "<UnitType>ft</UnitType><Scale>0.01</Scale>"), utm, "", {"has samples of -9999"}},
        {band("dem.tif", "", "Byte"), utm, "", {"samples of 8 bits"}},
        {band("dem.tif", "<UnitType>m</UnitType>", "Byte"), utm, "", {}},
        {band("dem.tif", "<UnitType>K</UnitType>"), utm, "", {"values in 'K'", "-units"}},
        {plain, "EPSG:4978", "", {"earth-centred", "gdalwarp -dstnodata -9999 -t_srs"}},
        {plain, moon, "", {"another body"}},
        {plain, "EPSG:3857", alps, {"are 1.46", "gdalwarp -dstnodata -9999 -t_srs EPSG:32632"}},
        {plain, "EPSG:3395", alps, {"are 1.46", "gdalwarp -dstnodata -9999 -t_srs EPSG:32632"}},
        {plain, "EPSG:5513", "", {"mirror the ground"}},  // x to the south and y to the west
        {plain, "EPSG:5514", "", {"lengths in its coordinate system are 1.141"}},
        {plain, "EPSG:2180", "", {}},
        {called("Palette"), utm, "", {"holds colours and no heights", "Palette"}},
        {called("Red"), utm, "", {"holds colours and no heights", "Red"}},
        {called("Cyan"), utm, "", {"holds colours and no heights", "Cyan"}},
        {band("dem.tif", "", "CFloat32"), utm, "", {"complex numbers"}},
        {plain + plain + plain, utm, "", {"left out: 2 bands behind the first\n"}}}) {
    const std::string said =
        saidOf(mosaic(bands, system, transform.empty() ? "500000, 5, 0, 5400100, 0, -5" : transform));
    for (const char* part : words) EXPECT_THAT(said, AllOf(HasSubstr("dem.vrt: "), HasSubstr(part)));
    EXPECT_EQ(said.empty(), words.empty()) << bands << system << said;
  }
}

TEST_F(Heights, UnitsBecomeMetres) {
  folder_.write("dem.tif", flat(30, 40).bytes());
  constexpr double kSurveyFoot = 1200.0 / 3937;
  struct Case {
    const char* system;
    std::string unit;
    double horizontal, vertical;
    const char* warning;
  };
  for (const Case& c : {Case{"EPSG:32633", "", 1, 1, ""},
                        {"EPSG:32633", "ft", 1, 0.3048, ""},
                        {"EPSG:32633", "US survey foot", 1, kSurveyFoot, ""},
                        {"EPSG:32633", "cm", 1, 0.01, ""},
                        {"EPSG:26910+6360", "", 1, kSurveyFoot, ""},
                        {"EPSG:26910+5715", "", 1, -1, ""},  // depths
                        {"EPSG:2263", "m", kSurveyFoot, 1, ""},
                        {"EPSG:2263", "", kSurveyFoot, 1, "nothing states the unit of the heights"},
                        {"EPSG:2222", "", 0.3048, 1, "gdal_edit.py -units \"ft\""}}) {
    const Reading found = reading(
        mosaic(band("dem.tif", "<UnitType>" + c.unit + "</UnitType>"), c.system, "500000, 5, 0, 200100, 0, -5"));
    EXPECT_NEAR(found.box.high.x - found.box.low.x, 25 * c.horizontal, 1e-3) << c.system << c.unit;
    EXPECT_NEAR(found.box.low.x, 500002.5 * c.horizontal, 1e-2) << c.system << c.unit;
    EXPECT_NEAR(found.box.high.z - found.box.low.z, std::fabs(10 * c.vertical), 1e-5) << c.system << c.unit;
    EXPECT_NEAR(c.vertical > 0 ? found.box.low.z : found.box.high.z, 30 * c.vertical, 1e-5) << c.system << c.unit;
    EXPECT_EQ(found.warnings.empty(), *c.warning == '\0') << c.system << c.unit << found.warnings;
    EXPECT_THAT(found.warnings, HasSubstr(c.warning)) << c.system;
  }
  // 0.001 grads are 100 m of latitude.
  const Reading grads = reading(mosaic(band("dem.tif"), "EPSG:4807", "2, 0.001, 0, 50, 0, -0.001"));
  EXPECT_NEAR(grads.box.high.y - grads.box.low.y, 300, 1);
}

TEST_F(Heights, UnitsOfTheKeysOfAGeoTiffCount) {
  constexpr double kSurveyFoot = 1200.0 / 3937;
  const auto with = [&](std::uint16_t system, std::vector<std::array<std::uint16_t, 2>> keys) {
    GeoTiff tiff = flat(30, 40);
    tiff.epsg = system;
    tiff.keys = std::move(keys);
    return reading(folder_.write("k.tif", tiff.bytes()));
  };
  constexpr std::uint16_t kOfTheUser = 32767, kUtm = 32633;
  EXPECT_THAT(with(kOfTheUser, {{3076, 9003}}).warnings, HasSubstr("k.tif: its coordinate system is not known"));
  const Reading heights = with(kUtm, {{4096, 6360}});
  EXPECT_NEAR(heights.box.low.z, 30 * kSurveyFoot, 1e-4);
  EXPECT_EQ(heights.warnings, "");
  EXPECT_EQ(with(kUtm, {{4096, 5715}}).box.high.z, -30) << "depths";
}

TEST_F(Heights, UnitsHaveManyNames) {
  folder_.write("dem.tif", flat(30, 40).bytes());
  for (const auto& [unit, metres] : {std::pair{"US_survey_foot", 1200.0 / 3937},
                                     {"US ft", 1200.0 / 3937},
                                     {"ft (US)", 1200.0 / 3937},
                                     {"Foot", 0.3048},
                                     {"[m]", 1.0},
                                     {"m ", 1.0},
                                     {"centimeter", 0.01}}) {
    const std::string states = std::string("<UnitType>") + unit + "</UnitType>";
    EXPECT_NEAR(reading(mosaic(band("dem.tif", states))).box.low.z, 30 * metres, 1e-5) << unit;
  }
}

TEST_F(Heights, SystemsBesideTheRasterAreRead) {
  const std::string degrees =
      "GEOGCS[\"WGS 84\",DATUM[\"WGS_1984\",SPHEROID[\"WGS 84\",6378137,298.257223563]],PRIMEM[\"Greenwich\",0],"
      "UNIT[\"degree\",0.0174532925199433]]";
  std::string plain = GeoTiff{6, 4, std::vector<float>(24, 30), 11, 48, 0.001}.bytes();
  const std::size_t keys = plain.rfind("\xAF\x87", std::string::npos);  // 34735, under a number that nobody knows
  ASSERT_NE(keys, std::string::npos);
  plain[keys] = '\xA0';
  const auto file = folder_.write("p.tif", plain);
  EXPECT_NEAR(reading(file).box.high.y - reading(file).box.low.y, 0.003, 1e-5);
  folder_.write("p.prj", degrees);
  EXPECT_NEAR(reading(file).box.high.y - reading(file).box.low.y, 333.6, 0.5);
  folder_.write("p.prj", "nonsense");
  EXPECT_THAT(reading(file).warnings, HasSubstr("p.prj: is no coordinate system that can be read"));
  folder_.write("p.prj", "Projection UTM\nZone 10\nDatum NAD83\nZunits FEET\n");
  EXPECT_THAT(messageOf([&] { readAsset(file, {}); }),
              AllOf(HasSubstr("p.prj: is of Esri's old kind"), HasSubstr("gdalsrsinfo")));
}

TEST_F(Heights, HaveTheScaleAndTheSignOfTheBand) {
  folder_.write("dem.tif", flat(250, 100).bytes());
  const Reading scaled = reading(mosaic(band("dem.tif", "<Offset>-100</Offset><Scale>0.1</Scale>")));
  EXPECT_NEAR(scaled.box.high.z, -75, 1e-5);
  EXPECT_NEAR(scaled.box.low.z, -90, 1e-5);
  // The file of floats becomes one of signed bytes, whose samples are -6.
  std::string bytes = flat(0, 0).bytes();
  bytes.replace(8, 24, std::string(24, '\xfa'));
  for (const auto& [tag, from, to] : {std::tuple{std::string("\x02\x01\x03\0\1\0\0\0", 8), 32, 8},
                                      {std::string("\x53\x01\x03\0\1\0\0\0", 8), 3, 2}}) {
    const std::size_t at = bytes.find(tag + static_cast<char>(from));
    ASSERT_NE(at, std::string::npos);
    bytes[at + tag.size()] = static_cast<char>(to);
  }
  EXPECT_EQ(reading(folder_.write("signed.tif", bytes)).box.low.z, -6);
}

// Rotated by 37 degrees, running north, and with a tie point at the centre of the first sample.
TEST_F(Heights, AreWhereAnyTransformSays) {
  folder_.write("dem.tif", flat(30, 40).bytes());
  const auto centre = [](const Reading& r) { return (r.box.low + r.box.high) * 0.5; };
  const Reading rotated = reading(mosaic(band("dem.tif"), "EPSG:32633", "500000, 4, 3, 5400100, 3, -4"));
  EXPECT_NEAR(centre(rotated).x, 500000 + 3 * 4 + 2 * 3, 1e-3);
  EXPECT_NEAR(centre(rotated).y, 5400100 + 3 * 3 - 2 * 4, 1e-3);
  const Reading north = reading(mosaic(band("dem.tif"), "EPSG:32633", "500000, 5, 0, 5400100, 0, 5"));
  EXPECT_NEAR(north.box.low.y, 5400102.5, 1e-3);
  std::string point = flat(30, 40).bytes();
  const std::string area("\x01\x04\0\0\1\0\1\0", 8);  // GTRasterTypeGeoKey
  ASSERT_NE(point.find(area), std::string::npos);
  point[point.find(area) + 6] = 2;
  EXPECT_NEAR(reading(folder_.write("point.tif", point)).box.low.x, 500000, 1e-3);
}

TEST_F(Heights, TextGridsOfAllKindsAreRead) {
  const std::string samples = "1 2.5 3\n4 -9999 6\n7 8 9\n";
  const auto box = [&](const std::string& text) { return reading(folder_.write("g.asc", text)).box; };
  const Box corner = box("NCOLS 3\nNROWS 3\nXLLCORNER 500000\nYLLCORNER 5400000\nCELLSIZE 10\n1 2.5 3\n4 5 6\n7 8 9\n");
  EXPECT_NEAR(corner.low.x, 500005, 1e-3);
  EXPECT_NEAR(corner.high.y, 5400025, 1e-3);
  EXPECT_EQ(corner.high.z, 9);
  const Box centre =
      box("ncols 3\nnrows 3\nxllcenter 500000\nyllcenter 5400000\ndx 10\ndy 20\n1.5 2.5 3\n4 5 6\n7 8 9\n");
  EXPECT_NEAR(centre.low.x, 500000, 1e-3);
  EXPECT_NEAR(centre.high.y, 5400040, 1e-3);
  EXPECT_EQ(centre.low.z, 1.5);
  const std::string heading = "ncols 3\nnrows 3\nxllcorner 500000\nyllcorner 5400000\ncellsize 10\n";
  EXPECT_THAT(refusedGrid(heading + samples), HasSubstr("no cell")) << "-9999 is the default of NODATA_value";
  EXPECT_THAT(refusedGrid(heading + "nodata_VALUE 5\n1 2 3\n4 5 6\n7 8 9\n"), HasSubstr("no cell"));
  // GDAL guesses the type of the samples by the first ones.
  std::string late = "ncols 600\nnrows 600\nxllcorner 0\nyllcorner 0\ncellsize 1\ndatum WGS84\n";
  for (int i = 0; i < 600 * 600; ++i) late += i < 300 * 600 ? "-9999 " : "7.75 ";
  EXPECT_EQ(reading(folder_.write("late.asc", late)).box.low.z, 7.75);
}

// Edges of cliffs stay straight: the diagonal that is shorter is taken.
TEST_F(Heights, CellsAreCutAcrossTheShorterDiagonal) {
  const GeoTiff corner{2, 2, {0, 0, 0, 9}, 500000, 5400000, 1};
  const Asset asset = read(corner);
  const auto& p = asset.parts.at(0).positions;
  int flat = 0;
  for (const Triangle& t : asset.parts[0].triangles) {
    const auto high = std::count_if(t.begin(), t.end(), [&](std::uint32_t c) { return p[c].z > 4; });
    EXPECT_LE(high, 1);
    flat += p[t[0]].z == 0 && p[t[1]].z == 0 && p[t[2]].z == 0 ? 1 : 0;
  }
  EXPECT_EQ(flat, 1) << "one of the two lies level";
}

// Classes of another resolution, by where they lie; colours likewise.
TEST_F(Heights, HaveClassesAndColoursOfOtherRasters) {
  GeoTiff cover{3, 2, {10, 20, 30, 40, 50, 60}, 500000, 5400100, 50};
  GeoTiff photo{2, 1, {0, 255}, 500000, 5400100, 75};
  folder_.write("photo.tif", photo.bytes());
  AssetOptions options;
  options.heights.classes = folder_.write("cover.tif", cover.bytes());
  options.heights.image = folder_.path() / "photo.tif";
  const Asset asset = read(tilted(), options);
  ASSERT_EQ(asset.parts.size(), 6u);
  EXPECT_EQ(trianglesOf(asset), 2u * 29 * 19);
  options.textures = false;
  EXPECT_EQ(read(tilted(), options).parts[0].texture, "photo.tif") << "rules ask whether a part has a texture";
  for (const AssetPart& part : asset.parts) {
    const int number = std::stoi(part.material);
    ASSERT_TRUE(part.fileMaterial.texture);
    for (const Triangle& t : part.triangles) {
      Vec3d middle = asset.origin;
      Vec2f uv{0, 0};
      for (const std::uint32_t c : t) {
        middle = middle + Vec3d(part.positions[c]) * (1.0 / 3);
        uv = {uv.x + part.uvs[c].x / 3, uv.y + part.uvs[c].y / 3};
      }
      const int column = static_cast<int>((middle.x - 500000) / 50);
      const int row = static_cast<int>((5400100 - middle.y) / 50);
      const double offX = std::fabs(std::remainder(middle.x - 500000, 50));
      const double offY = std::fabs(std::remainder(5400100 - middle.y, 50));
      if (offX > 3 && offY > 3) {  // cells are taken at their middle
        EXPECT_EQ(number, 10 * (3 * row + column + 1));
      }
      if (std::fabs(middle.x - 500075) > 3) {
        EXPECT_EQ(part.fileMaterial.texture->texel(uv.x, uv.y)[0], middle.x > 500075 ? 255 : 0);
      }
    }
  }
  const Scene scene = sceneOf(folder_,
                              "objects:\n  - {file: dem.tif, class: terrain, heights: {image: photo.tif}, rules: "
                              "[{match: {node: none}, class: road, material: asphalt}]}\n");
  EXPECT_TRUE(std::any_of(scene.materials.begin(), scene.materials.end(), [](const Material& m) {
    return m.texture != nullptr;
  })) << "a rule's material replaces the image only where the rule matches";
  cover.epsg = 32632;
  options.heights.classes = folder_.write("other.tif", cover.bytes());
  EXPECT_THAT(refused(tilted(), options), AllOf(HasSubstr("other.tif"), HasSubstr("gdalwarp")));
}

TEST_F(Heights, ClassesAreWholeNumbersAndWhatHasNoneIsTold) {
  GeoTiff half{1, 1, {10}, 500000, 5400100, 75};
  AssetOptions options;
  options.heights.classes = folder_.write("half.tif", half.bytes());
  testing::internal::CaptureStderr();
  const Asset asset = read(tilted(), options);
  EXPECT_THAT(testing::internal::GetCapturedStderr(),
              AllOf(HasSubstr("half.tif: has no class for "), HasSubstr("of the 551 cells"), HasSubstr("'no class'")));
  ASSERT_EQ(asset.parts.size(), 2u);
  GeoTiff blended{2, 2, {1, 2, 1.6f, 2}, 500000, 5400100, 75};
  options.heights.classes = folder_.write("blended.tif", blended.bytes());
  EXPECT_THAT(refused(tilted(), options),
              AllOf(HasSubstr("blended.tif: has 1 samples"), HasSubstr("such as 1.6"), HasSubstr("gdalwarp -r near")));
}

TEST_F(Heights, ImagesOfAllKindsHaveTheirColours) {
  folder_.write("dem.tif", GeoTiff{6, 4, std::vector<float>(24, 30), 500000, 5400100, 5}.bytes());
  const auto image = [&](const std::string& bands, std::string& warnings) {
    AssetOptions options;
    options.heights.image = mosaic(bands);
    testing::internal::CaptureStderr();
    const Asset asset = readAsset(folder_.path() / "dem.tif", options);
    warnings = testing::internal::GetCapturedStderr();
    const std::vector<std::uint8_t>& rgba = asset.parts.at(0).fileMaterial.texture->rgba;
    return std::vector<int>(rgba.begin(), rgba.begin() + 3);
  };
  const auto write = [&](const char* name, float value) {
    folder_.write(name, GeoTiff{6, 4, std::vector<float>(24, value), 500000, 5400100, 5}.bytes());
    return std::string(name);
  };
  std::string warnings;
  const std::string dark = write("dark.tif", 128), bright = write("bright.tif", 65535), half = write("half.tif", 0.5f);
  EXPECT_EQ(image(band(dark, "", "UInt16") + band(bright, "", "UInt16") + band(dark, "", "UInt16"), warnings),
            (std::vector{0, 255, 0}))
      << "one channel of 16 bits makes all have 16 bits";
  EXPECT_EQ(warnings, "");
  EXPECT_EQ(image(band(half), warnings), (std::vector{128, 128, 128}));
  const std::string whiteIsZero = "<Metadata domain=\"IMAGE_STRUCTURE\"><MDI key=\"MINISWHITE\">YES</MDI></Metadata>";
  const std::string bytes = band(dark, "", "Byte");
  const int shade = image(bytes, warnings)[0];
  EXPECT_EQ(image(whiteIsZero + bytes, warnings)[0], 255 - shade);
  const auto called = [](const char* name) { return std::string("<ColorInterp>") + name + "</ColorInterp>"; };
  EXPECT_EQ(image(band(half, called("Blue")) + band(dark, called("Red")) + band(bright, called("Alpha")) +
                      band(write("grey.tif", 64), called("Green")),
                  warnings),
            (std::vector{128, 64, 1}));
  image(band(write("dim.tif", 2047), "", "UInt16"), warnings);
  EXPECT_THAT(warnings, HasSubstr("dem.vrt: its brightest value is 2047"));
  EXPECT_THAT(messageOf([&] { image(band(dark, called("Palette"), "Byte"), warnings); }), HasSubstr("-expand rgb"));
  testing::internal::GetCapturedStderr();
  EXPECT_EQ(image(band(dark, "<NoDataValue>128</NoDataValue>"), warnings)[0], 0);
  EXPECT_THAT(warnings, HasSubstr("24 samples have no colour"));
  // The image ends in the middle of the heights, and does not repeat behind its edge.
  AssetOptions options;
  GeoTiff small{2, 1, {10, 20}, 500000, 5400100, 10};
  options.heights.image = folder_.write("small.tif", small.bytes());
  testing::internal::CaptureStderr();
  const Asset asset = readAsset(folder_.path() / "dem.tif", options);
  EXPECT_THAT(testing::internal::GetCapturedStderr(), HasSubstr("small.tif: does not cover 16 of the vertices"));
  const AssetPart& part = asset.parts.at(0);
  for (std::size_t i = 0; i < part.uvs.size(); ++i) {
    EXPECT_EQ(part.fileMaterial.texture->texel(part.uvs[i].x, part.uvs[i].y)[0],
              part.positions[i].x + asset.origin.x < 500010 ? 10 : 20);
  }
}

// A degree of latitude is 111.2 km at 48 degrees, one of longitude 74.6 km; level ground bends away as the earth does.
TEST_F(Heights, OfLongitudeAndLatitudeLieAsOnTheEarth) {
  const GeoTiff flat{41, 41, std::vector<float>(41 * 41, 100.0f), 11, 48.5, 0.5 / 41, 4326};
  const Asset asset = read(flat);
  const Box box = boundsOf(asset);
  EXPECT_NEAR((box.high.y - box.low.y) / (0.5 * 40 / 41), 111200, 150);
  EXPECT_NEAR((box.high.x - box.low.x) / (0.5 * 40 / 41), 74400, 400);  // at the southern edge
  for (const Vec3f& p : asset.parts.at(0).positions) {
    const double d = std::hypot(p.x, p.y);
    EXPECT_NEAR(p.z, 100 - d * d / (2 * 6.378e6), 1) << d;
  }
  const Box even = boundsOf(read({6, 4, std::vector<float>(24, 100.0f), 11, 0.002, 0.001, 4326}));
  EXPECT_NEAR(even.low.x, -even.high.x, 1e-3) << "the origin is the middle";
  EXPECT_NEAR(even.low.y, -even.high.y, 1e-3);
}

TEST_F(Heights, AreObjectsOfAScene) {
  folder_.write("dem.tif", tilted().bytes());
  const Scene scene = sceneOf(
      folder_,
      "objects:\n  - {file: dem.tif, position: [-500000, -5400000, 0], heights: {every: 2}, rules: [{match: {box: "
      "[[500000, 5400000, 0], [500050, 5400100, 999]]}, class: road}, {match: {slope_deg: [10, 20]}, class: "
      "terrain}]}\n");
  ASSERT_EQ(scene.instances.size(), 1u);
  EXPECT_EQ(scene.instances[0].name, "dem");
  EXPECT_NEAR(scene.bounds().low.x, 5, 1e-3);
  std::map<std::uint16_t, int> count;
  const Mesh& mesh = scene.meshes[scene.instances[0].mesh];
  for (const std::uint16_t s : mesh.surfaceOf) ++count[mesh.surfaces[s].semantic];
  const std::uint16_t road = scene.ontology.require("road", {}).id;
  EXPECT_EQ(count.size(), 2u) << "road in the western third, terrain of 12.6 degrees elsewhere";
  EXPECT_NEAR(count[road], 2 * 9 * 4.5, 9);
}

TEST_F(Heights, OfOneSceneThatDoNotFitAreToldOnce) {
  const std::vector<float> level(24, 30);
  folder_.write("u33.tif", GeoTiff{6, 4, level, 500000, 5400100, 5}.bytes());
  folder_.write("next.tif", GeoTiff{6, 4, level, 500030, 5400100, 5}.bytes());
  folder_.write("u32.tif", GeoTiff{6, 4, level, 500000, 5400100, 5, 32632}.bytes());
  folder_.write("deg.tif", GeoTiff{6, 4, level, 15, 48.7, 0.001, 4326}.bytes());
  folder_.write("deg2.tif", GeoTiff{6, 4, level, 15.006, 48.7, 0.001, 4326}.bytes());
  const auto warned = [&](const std::string& a, const std::string& b, const std::string& position) {
    testing::internal::CaptureStderr();
    sceneOf(folder_, "objects:\n  - {file: " + a + ".tif, class: terrain}\n  - {file: " + b +
                         ".tif, class: terrain, position: " + position + "}\n");
    return testing::internal::GetCapturedStderr();
  };
  EXPECT_THAT(warned("deg", "deg2", "[0, 0, 2]"),
              AllOf(HasSubstr("scene.yaml:5"), HasSubstr("deg.tif and "), HasSubstr("deg2.tif have the same position"),
                    HasSubstr("gdalbuildvrt")));
  EXPECT_THAT(warned("u32", "u33", "[0, 0, 0]"), HasSubstr("coordinate systems that differ by 4"));
  EXPECT_THAT(warned("u33", "deg", "[0, 0, 0]"), HasSubstr("one of them around a middle of its own"));
  EXPECT_EQ(warned("u33", "next", "[0, 0, 0]"), "");
  EXPECT_EQ(warned("deg", "deg", "[0, 0, 0]"), "");
  EXPECT_EQ(warned("deg", "deg2", "[300, 0, 0]"), "") << "the user says where the tile lies";
}

TEST_F(Heights, MistakesAreNamed) {
  folder_.write("dem.tif", "no raster");
  EXPECT_THAT(messageOf([&] { readAsset(folder_.path() / "dem.tif", {}); }),
              AllOf(HasSubstr("dem.tif"), HasSubstr("no raster that can be read")));
  const std::string grid = "ncols 2\nnrows 2\nxllcorner 11\nyllcorner 48\ncellsize 0.1\nNODATA_value -9999\n";
  for (const auto& [text, words] : std::vector<std::pair<std::string, std::string>>{
           {grid + "+0.01 .02\n0.03 1e-2\n", "accepted"},
           {grid + "0.01 0.02\n0.03 nan\n", "no cell whose four samples"},
           {grid + "0.01 0.02\n0.03 none\n", "g.asc:8: 'none' is no number"},
           {grid + "0.01 *\n0.03 1\n", "g.asc:7: '*' is no number"},
           {grid + "0.01 1D+01\n0.03 1\n", "g.asc:7: '1D+01' is no number"},
           {grid + "1,5 2\n3 4\n", "g.asc:7: '1,5' is no number"},
           {grid + "1 2\n3\n", "has 3 samples, but its heading promises 4"},
           {grid + "510 512\n530 521\n", "rises by 20 m within"},
           {"ncols 2\nnrows 2\nxllcorner 1.0D+02\nyllcorner 0\ncellsize 10\n1 2\n3 4\n", "g.asc:3: '1.0D+02' is no"},
           {"ncols 2\nnrows 2\nxllcorner 5\nyllcenter 6\ncellsize 10\n1 2\n3 4\n", "does not say where it lies"},
           {"# made by x\n" + grid + "1 2\n3 4\n", "no raster that can be read"},
           {"north: 30\nsouth: 0\neast: 20\nwest: 0\nrows: 2\ncols: 2\n1 2\n3 *\n", "of GRASS: write a GeoTIFF"}}) {
    EXPECT_THAT(refusedGrid(text), HasSubstr(words)) << text;
  }
  std::string unplaced = tilted().bytes();
  for (const std::uint16_t tag :
       {std::uint16_t{33550}, std::uint16_t{33922}}) {  // scale and tie point, under numbers that nobody knows
    const std::string bytes(reinterpret_cast<const char*>(&tag), 2);
    const std::size_t at = unplaced.rfind(bytes + std::string("\x0C\0", 2));
    ASSERT_NE(at, std::string::npos);
    const auto other = static_cast<std::uint16_t>(tag + 1);
    unplaced.replace(at, 2, reinterpret_cast<const char*>(&other), 2);
  }
  folder_.write("u.tif", unplaced);
  EXPECT_THAT(messageOf([&] { readAsset(folder_.path() / "u.tif", {}); }), HasSubstr("gdal_edit.py"));
  folder_.write("u.tfw", "5\n0\n0\n-5\n500002.5\n5400097.5\n");
  EXPECT_NEAR(reading(folder_.path() / "u.tif").box.low.x, 500002.5, 1e-3) << "a world file names the first centre";
  std::string cut = tilted().bytes();
  // Whatever is damaged, it is read or refused.
  for (std::size_t i = 0; i < cut.size(); i += 7) {
    std::string damaged = cut;
    damaged[i] = static_cast<char>(~damaged[i]);
    folder_.write("d.tif", damaged);
    const std::string message = messageOf([&] { readAsset(folder_.path() / "d.tif", {}); });
    EXPECT_TRUE(message == "accepted" || message.find("d.tif") != std::string::npos) << i << ": " << message;
  }
}

}  // namespace
}  // namespace scanmill
