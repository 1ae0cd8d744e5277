#include "formats/cloud_file.h"

#include <fmt/format.h>

#include <array>
#include <cstring>
#include <optional>

#include "base/file.h"
#include "tests/support/message_of.h"
#include "tests/support/temporary_folder.h"

namespace scanmill {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

template <class T>
void put(std::string& bytes, std::size_t at, T value) {
  if (bytes.size() < at + sizeof(value)) bytes.resize(at + sizeof(value));
  std::memcpy(bytes.data() + at, &value, sizeof(value));
}

// Three points of a point format: the second is withheld.
std::string las(int minor, std::uint8_t format) {
  static constexpr std::uint16_t kRecord[] = {20, 28, 26, 34, 57, 63, 30, 36, 38, 59, 67};
  static constexpr std::size_t kColors[] = {0, 0, 20, 28, 0, 28, 0, 30, 30, 0, 30};
  const std::uint16_t header = minor == 4 ? 375 : minor == 3 ? 235 : 227;
  const std::uint16_t record = kRecord[format] + 2;  // and two bytes of somebody's
  std::string bytes(header + 10, '\0');
  bytes.replace(0, 4, "LASF");
  put<std::uint8_t>(bytes, 24, 1);
  put<std::uint8_t>(bytes, 25, static_cast<std::uint8_t>(minor));
  put<std::uint16_t>(bytes, 94, header);
  put<std::uint32_t>(bytes, 96, header + 10);
  put<std::uint8_t>(bytes, 104, format);
  put<std::uint16_t>(bytes, 105, record);
  if (minor == 4) {
    put<std::uint64_t>(bytes, 247, 3);
  } else {
    put<std::uint32_t>(bytes, 107, 3);
  }
  for (std::size_t axis = 0; axis < 3; ++axis) {
    put(bytes, 131 + 8 * axis, 0.001);
    put(bytes, 155 + 8 * axis, axis == 2 ? 0.0 : 5e5);
  }
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t at = header + 10 + i * record;
    bytes.resize(at + record);
    put<std::int32_t>(bytes, at, static_cast<std::int32_t>(1000 * i + 1));
    put<std::int32_t>(bytes, at + 4, -2000);
    put<std::int32_t>(bytes, at + 8, 3123);
    put<std::uint16_t>(bytes, at + 12, static_cast<std::uint16_t>(100 + i));
    put<std::uint8_t>(bytes, at + 14, format >= 6 ? 0x21 : 0x11);  // the first of two
    const bool withheld = i == 1;
    if (format >= 6) {
      put<std::uint8_t>(bytes, at + 15, withheld ? 0x04 : 0);
      put<std::uint8_t>(bytes, at + 16, 40);
    } else {
      put<std::uint8_t>(bytes, at + 15, static_cast<std::uint8_t>(6 | (withheld ? 0x80 : 0x20)));
    }
    for (std::size_t c = 0; c < 3 && kColors[format] > 0; ++c) {
      put<std::uint16_t>(bytes, at + kColors[format] + 2 * c, static_cast<std::uint16_t>(1000 * (c + 1) + i));
    }
  }
  return bytes;
}

class CloudFiles : public testing::Test {
 protected:
  Cloud read(const std::string& name, const std::string& bytes) const { return readCloud(folder_.write(name, bytes)); }
  std::string refused(const std::string& name, const std::string& bytes) const {
    return messageOf([&] { read(name, bytes); });
  }
  TemporaryFolder folder_;
};

Vec3d placeOf(const Cloud& cloud, std::size_t i) {
  return cloud.origin + Vec3d(cloud.scan.position.at(i));
}

const ForeignColumn::Values& foreign(const Scan& scan, const std::string& name) {
  for (const ForeignColumn& column : scan.foreign) {
    if (column.name == name) return column.values;
  }
  throw Error("there is no column " + name);
}

TEST_F(CloudFiles, LasOfAllVersionsAndFormats) {
  const Cloud oldest = read("a.las", las(0, 0));
  EXPECT_THAT(oldest.scan[kLabel], ElementsAre(38, 134, 38)) << "classes of LAS 1.0 have all eight bits";
  EXPECT_TRUE(oldest.leftOut.empty() || oldest.leftOut.text().find("withheld") == std::string::npos);
  for (const int minor : {1, 2, 3, 4}) {
    for (std::uint8_t format = 0; format <= 10; ++format) {
      if (minor < 4 && format > 5) continue;
      SCOPED_TRACE(fmt::format("1.{}, format {}", minor, format));
      const Cloud cloud = read("a.las", las(minor, format));
      ASSERT_EQ(cloud.scan.size(), 2u) << "without the one that is withheld";
      EXPECT_LT(length(placeOf(cloud, 1) - Vec3d{500002.001, 499998, 3.123}), 1e-5);
      EXPECT_THAT(cloud.scan[kIntensity], ElementsAre(100, 102));
      EXPECT_THAT(cloud.scan[kLabel], ElementsAre(format >= 6 ? 40 : 6, format >= 6 ? 40 : 6));
      EXPECT_THAT(cloud.scan[kReturn], ElementsAre(1, 1));
      if (format == 2 || format == 3 || format == 5 || format == 7 || format == 8 || format == 10) {
        EXPECT_THAT(std::get<std::vector<std::uint16_t>>(foreign(cloud.scan, "green")), ElementsAre(2000, 2002));
      }
    }
  }
}

// A description of extra bytes: type and name; `none` is the value of points without one.
std::string described(std::uint8_t type, const std::string& name, std::optional<std::uint64_t> none = {}) {
  std::string text(192, '\0');
  text[2] = static_cast<char>(type);
  text[3] = none ? 1 : 0;
  text.replace(4, name.size(), name);
  put<std::uint64_t>(text, 40, none.value_or(0));
  return text;
}

// Puts records between the header of a file of las() and its points.
std::string withRecords(const std::string& bytes,
                        const std::vector<std::tuple<std::string, std::uint16_t, std::string>>& records,
                        std::uint16_t encoding = 0) {
  std::string all;
  for (const auto& [user, id, data] : records) {
    std::string record(54, '\0');
    record.replace(2, user.size(), user);
    put(record, 18, id);
    put(record, 20, static_cast<std::uint16_t>(data.size()));
    all += record + data;
  }
  std::uint32_t points = 0;
  std::uint16_t header = 0;
  std::memcpy(&points, bytes.data() + 96, 4);
  std::memcpy(&header, bytes.data() + 94, 2);
  std::string out = bytes.substr(0, header) + all + bytes.substr(points);
  put(out, 6, encoding);
  put(out, 96, static_cast<std::uint32_t>(header + all.size()));
  put(out, 100, static_cast<std::uint32_t>(records.size()));
  return out;
}

// The last two bytes of the points are the extra bytes of las().
std::string withExtraBytes(const std::string& description, const std::vector<std::uint16_t>& values,
                           std::uint8_t format = 6) {
  std::string bytes = withRecords(las(4, format), {{"LASF_Spec", 4, description}});
  std::uint16_t record = 0;
  std::memcpy(&record, bytes.data() + 105, 2);
  for (std::size_t i = 0; i < 3; ++i) put(bytes, bytes.size() - (3 - i) * record + record - 2, values.at(i));
  return bytes;
}

TEST_F(CloudFiles, ExtraBytesOfLasAreColumns) {
  for (const char* name : {"instance", "treeID", "PredInstance", "instance_id", "object_id"}) {
    const Cloud cloud = read("a.las", withExtraBytes(described(3, name), {7, 8, 9}));
    EXPECT_THAT(cloud.scan[kInstance], ElementsAre(7, 9)) << name << ", without the point that is withheld";
    EXPECT_EQ(cloud.leftOut.text(), "1 points marked as withheld");
  }
  // -1 is none: then 0 is a tree, too.
  const auto none = static_cast<std::uint16_t>(-1);
  EXPECT_THAT(read("a.las", withExtraBytes(described(4, "treeID"), {none, 8, 0})).scan[kInstance], ElementsAre(0, 1));
  EXPECT_THAT(read("a.las", withExtraBytes(described(3, "treeID", none), {none, 8, 9})).scan[kInstance],
              ElementsAre(0, 9));
  const Cloud other = read("a.las", withExtraBytes(described(3, "Amplitude"), {7, 8, 9}));
  EXPECT_THAT(std::get<std::vector<std::uint16_t>>(foreign(other.scan, "Amplitude")), ElementsAre(7, 9));
  std::string scaled = described(4, "Reflectance");
  scaled[3] = 8 | 16;
  put(scaled, 112, 0.5);
  put(scaled, 136, 10.0);
  EXPECT_THAT(std::get<std::vector<double>>(foreign(
                  read("a.las", withExtraBytes(scaled, {6, 0, static_cast<std::uint16_t>(-4)})).scan, "Reflectance")),
              ElementsAre(13, 8));
  EXPECT_THAT(read("a.las", withExtraBytes(described(4, "ring"), {none, 8, 9})).leftOut.text(),
              HasSubstr("1 columns 'ring' (ring of point 0 is -1"));
  // Those of several values, without a description or beyond the points are told.
  EXPECT_EQ(read("a.las", las(4, 6)).leftOut.text(),
            "2 bytes of each point that nothing describes, 1 points marked as withheld");
  EXPECT_THAT(read("a.las", withExtraBytes(described(11, "pair"), {0, 0, 0})).leftOut.text(),
              HasSubstr("1 extra bytes 'pair' of several values"));
  EXPECT_THAT(read("a.las", withExtraBytes(described(10, "large"), {0, 0, 0})).leftOut.text(),
              HasSubstr("2 bytes of each"));
}

TEST_F(CloudFiles, ClassesOfLasMayBeExtraBytesAndHaveNames) {
  std::string bytes = withExtraBytes(described(3, "semantic"), {2, 2, 3});
  for (std::size_t i = 0; i < 3; ++i) put<std::uint8_t>(bytes, bytes.size() - (3 - i) * 32 + 16, 0);
  Cloud cloud = read("a.las", bytes);
  EXPECT_THAT(cloud.scan[kLabel], ElementsAre(2, 3));
  EXPECT_TRUE(cloud.classNames.empty()) << "numbers of others are not those of the specification";
  std::string names(16 * 256, '\0');
  names.replace(16 * 40, 6, "\x28tree\0", 6);
  names.replace(16 * 41, 5, "\x06hut", 4);
  cloud = read("a.las", withRecords(las(4, 6), {{"LASF_Spec", 0, names}}));
  EXPECT_EQ(cloud.classNames.at(40), "tree");
  EXPECT_EQ(cloud.classNames.at(6), "hut");
  EXPECT_EQ(cloud.classNames.at(2), "ground");
}

std::string keysOf(const std::vector<std::array<std::uint16_t, 2>>& keys) {
  std::string bytes;
  const auto add = [&](std::initializer_list<std::uint16_t> numbers) {
    for (const std::uint16_t number : numbers) put(bytes, bytes.size(), number);
  };
  add({1, 1, 0, static_cast<std::uint16_t>(keys.size())});
  for (const auto& [key, value] : keys) add({key, 0, 1, value});
  return bytes;
}

// Well-known text of a projected system in US survey feet, with further nodes behind its unit.
std::string statePlane(const std::string& more = R"(,AXIS["X",EAST],AXIS["Y",NORTH])") {
  return R"(PROJCS["NAD83 / New York",GEOGCS["NAD83",DATUM["D",SPHEROID["GRS 1980",6378137,298.257222101]],)"
         R"(PRIMEM["Greenwich",0],UNIT["degree",0.0174532925199433]],PROJECTION["Transverse_Mercator"],)"
         R"(PARAMETER["latitude_of_origin",38.8],PARAMETER["central_meridian",-74.5],PARAMETER["scale_factor",0.9999],)"
         R"(PARAMETER["false_easting",492125],UNIT["US survey foot",0.304800609601219])" +
         more + "]";
}

// The coordinate system of a LAS file, as well-known text or as keys of GeoTIFF.
struct LasSystem {
  std::string wkt;
  std::vector<std::array<std::uint16_t, 2>> keys;
  std::string bytes() const {
    return withRecords(las(4, 6), {{"LASF_Projection", 2112, wkt}, {"LASF_Projection", 34735, keysOf(keys)}},
                       wkt.empty() ? 0 : 16);
  }
};

TEST_F(CloudFiles, FeetOfLasBecomeMetres) {
  constexpr double kSurvey = 1200.0 / 3937;
  const std::string metres = R"(VERT_CS["NAVD88",VERT_DATUM["N",2005],UNIT["metre",1],AXIS["Up",UP]])";
  const std::string depth = R"(VERT_CS["MSL",VERT_DATUM["M",2005],UNIT["metre",1],AXIS["Depth",DOWN]])";
  const std::string esri = R"(VERTCS["NAVD_1988",VDATUM["North_American_Vertical_Datum_1988"],)"
                           R"(PARAMETER["Vertical_Shift",0.0],PARAMETER["Direction",1.0],UNIT["Meter",1.0]])";
  const std::tuple<LasSystem, double, double> cases[] = {
      {{statePlane(), {}}, kSurvey, kSurvey},
      {{"COMPD_CS[\"both\"," + statePlane() + "," + metres + "]", {}}, kSurvey, 1},
      {{"COMPD_CS[\"both\"," + statePlane() + "," + depth + "]", {}}, kSurvey, -1},
      {{statePlane("") + "," + esri, {}}, kSurvey, 1},
      {{R"(LOCAL_CS["scanmill world",LOCAL_DATUM["w",32767],UNIT["metre",1],AXIS["x",EAST],AXIS["y",NORTH]])", {}},
       1,
       1},
      {{"", {{{1024, 1}, {3072, 2263}, {3076, 9003}}}}, kSurvey, kSurvey},
      {{"", {{{1024, 1}, {3072, 2263}}}}, kSurvey, kSurvey},
      {{"", {{{1024, 1}, {3072, 25832}, {4096, 6360}}}}, 1, kSurvey},
      {{"", {{{1024, 1}, {3072, 25832}, {4096, 5703}, {4099, 9003}}}}, 1, kSurvey},
      {{"", {{{1024, 1}, {3072, 25832}, {4099, 9002}}}}, 1, 0.3048},
      {{"", {{{1024, 1}, {3072, 32632}, {4096, 5715}}}}, 1, -1},
      {{"", {{{1024, 1}, {3072, 32632}, {4096, 6358}}}}, 1, -kSurvey},
  };
  for (const auto& [system, horizontal, vertical] : cases) {
    const auto file = folder_.write("a.las", system.bytes());
    const Vec3d place{500002.001 * horizontal, 499998 * horizontal, 3.123 * vertical};
    EXPECT_LT(length(placeOf(readCloud(file), 1) - place), 1e-4) << system.wkt;
    EXPECT_LT(length(placeOf(readCloud(file, CloudUnit::Metre), 1) - Vec3d{500002.001, 499998, 3.123}), 1e-5);
  }
}

TEST_F(CloudFiles, CoordinateSystemsOfLasThatCannotBeUsedAreRefused) {
  for (const auto& [system, words] :
       {std::pair{LasSystem{R"(GEOGCS["WGS 84",DATUM["W",SPHEROID["WGS 84",6378137,298.25]],PRIMEM["G",0],)"
                            R"(UNIT["degree",0.0174532925199433]])",
                            {}},
                  "in degrees: reproject it"},
        {{"", {{{1024, 2}, {2048, 4326}}}}, "the key `unit`"},
        {{"", {{{1024, 3}, {2048, 4978}}}}, "earth-centred coordinates: reproject it"},
        {{"", {{{1024, 1}, {3072, 5513}}}}, "mirror the ground"}}) {
    const auto file = folder_.write("a.las", system.bytes());
    EXPECT_THAT(messageOf([&] { readCloud(file); }), AllOf(HasSubstr("a.las"), HasSubstr(words)));
    EXPECT_NO_THROW(readCloud(file, CloudUnit::Metre));
  }
}

TEST_F(CloudFiles, LasInMercatorOrAnUnknownSystemIsTold) {
  int files = 0;
  const auto warned = [&](const std::string& bytes) {
    testing::internal::CaptureStderr();
    read(fmt::format("{}.las", ++files), bytes);  // the same warning is not given twice
    return testing::internal::GetCapturedStderr();
  };
  // At y = 6000 km, 47.4 degrees, lengths are 1/cos(47.4 degrees) of those on the ground.
  std::string mercator = LasSystem{"", {{{1024, 1}, {3072, 3857}}}}.bytes();
  put(mercator, 155 + 8, 6e6);
  EXPECT_THAT(warned(mercator), AllOf(HasSubstr("1.las: "), HasSubstr("1.478 times"), HasSubstr("pdal translate")));
  EXPECT_EQ(warned(LasSystem{"", {{{1024, 1}, {3072, 32632}}}}.bytes()), "");
  for (const LasSystem& system : {LasSystem{statePlane().substr(0, 40), {}}, {"foo", {}}, {"", {{{3072, 1}}}}}) {
    EXPECT_THAT(warned(system.bytes()), AllOf(HasSubstr("cannot be read ("), HasSubstr("give the key `unit`")));
  }
}

TEST_F(CloudFiles, WhatLasHasBesidesItsPointsIsCounted) {
  for (const int minor : {2, 4}) {
    std::string bytes = las(minor, 1);
    EXPECT_THAT(read("a.las", bytes).leftOut.text(), Not(HasSubstr("behind the announced")));
    bytes += std::string(2 * 30, '\0');
    EXPECT_THAT(read("a.las", bytes).leftOut.text(), HasSubstr("2 points behind the announced ones"));
  }
  EXPECT_THAT(
      read("a.las", withRecords(las(4, 6), {{"LASF_Projection", 2111, "x"}, {"Somebody", 7, "x"}})).leftOut.text(),
      AllOf(HasSubstr("1 transforms of coordinates"), Not(HasSubstr("Somebody"))));
}

TEST_F(CloudFiles, LasThatIsNoneIsRefused) {
  EXPECT_THAT(refused("a.las", "LASF"), AllOf(HasSubstr("a.las"), HasSubstr("no LAS")));
  std::string bytes = las(4, 6);
  EXPECT_THAT(refused("a.las", bytes.substr(0, bytes.size() - 1)), HasSubstr("truncated"));
  put<std::uint64_t>(bytes, 247, std::uint64_t{1} << 62);
  EXPECT_THAT(refused("a.las", bytes), HasSubstr("truncated"));
  bytes = las(2, 1);
  put<std::uint8_t>(bytes, 104, 0x81);
  EXPECT_THAT(refused("a.laz", bytes), AllOf(HasSubstr("LAZ"), HasSubstr("pdal translate")));
  put<std::uint8_t>(bytes, 104, 11);
  EXPECT_THAT(refused("a.las", bytes), HasSubstr("point format 11"));
  bytes = las(2, 1);
  put<std::uint16_t>(bytes, 105, 20);
  EXPECT_THAT(refused("a.las", bytes), HasSubstr("points of 20 bytes"));
  put<std::uint8_t>(bytes, 25, 5);
  EXPECT_THAT(refused("a.las", bytes), HasSubstr("LAS 1.5"));
  // Whatever byte is damaged, it is read or refused.
  const std::string whole = las(4, 7);
  for (std::size_t i = 0; i < whole.size(); ++i) {
    std::string damaged = whole;
    damaged[i] = static_cast<char>(0xFF);
    const std::string message = refused("d.las", damaged);
    EXPECT_TRUE(message == "accepted" || message.find("d.las") != std::string::npos) << i << ": " << message;
  }
}

std::string plyOf(const std::string& properties, const std::string& line, const std::string& format = "ascii") {
  return "ply\nformat " + format + " 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n" +
         properties + "end_header\n" + line;
}

// The same cloud in text and in both orders of bytes, with names as other programs have them.
TEST_F(CloudFiles, PlyInAllItsFormats) {
  const auto header = [](const std::string& format) {
    return "ply\nformat " + format +
           " 1.0\ncomment a cloud\nelement camera 1\nproperty float focus\nelement vertex 2\nproperty double "
           "x\nproperty "
           "double y\nproperty double z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\nproperty float "
           "scalar_Classification\nproperty short rest\nproperty float nx\nend_header\n";
  };
  const auto binary = [](bool big) {
    std::string bytes;
    const auto add = [&](auto value) {
      std::string own(reinterpret_cast<const char*>(&value), sizeof(value));
      if (big) std::reverse(own.begin(), own.end());
      bytes += own;
    };
    add(9.0f);
    for (int i = 0; i < 2; ++i) {
      add(691234.5 + i), add(5334567.25), add(-2.5);
      for (const int c : {10, 20, 30}) add(static_cast<std::uint8_t>(c + i));
      add(static_cast<float>(5 + i)), add(static_cast<std::int16_t>(-7)), add(0.5f);
    }
    return bytes;
  };
  const std::string text =
      "9\n691234.5 5334567.25 -2.5 10 20 30 5 -7 0.5\n691235.5 5334567.25 -2.5 11 21 31 6 -7 0.5\n";
  for (const std::string& bytes : {header("ascii") + text, header("binary_little_endian") + binary(false),
                                   header("binary_big_endian") + binary(true)}) {
    const auto file = folder_.write("a.ply", bytes);
    EXPECT_TRUE(isCloud(file));
    const Cloud cloud = readCloud(file);
    ASSERT_EQ(cloud.scan.size(), 2u);
    EXPECT_LT(length(placeOf(cloud, 1) - Vec3d{691235.5, 5334567.25, -2.5}), 1e-6);
    EXPECT_THAT(cloud.scan[kLabel], ElementsAre(5, 6));
    EXPECT_THAT(std::get<std::vector<std::uint8_t>>(foreign(cloud.scan, "blue")), ElementsAre(30, 31));
    EXPECT_THAT(std::get<std::vector<std::int16_t>>(foreign(cloud.scan, "rest")), ElementsAre(-7, -7));
    EXPECT_THAT(std::get<std::vector<float>>(foreign(cloud.scan, "nx")), ElementsAre(0.5f, 0.5f));
  }
  // Numbers that their type cannot hold.
  const auto one = [&](const char* type, const char* number) {
    return refused("b.ply", plyOf(fmt::format("property {} red\n", type), fmt::format("1 2 3 {}\n", number)));
  };
  EXPECT_THAT(one("uchar", "300"), AllOf(HasSubstr("red of point 0 is 300"), HasSubstr("0 to 255")));
  EXPECT_THAT(one("char", "-129"), AllOf(HasSubstr("red of point 0 is -129"), HasSubstr("-128 to 127")));
  EXPECT_THAT(one("uint", "-1"), HasSubstr("red of point 0 is -1"));
  EXPECT_EQ(one("char", "-128"), "accepted");
  EXPECT_THAT(refused("b.ply", "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nend_header\n1\n"),
              HasSubstr("no property y"));
  EXPECT_THAT(refused("b.ply", plyOf("property int label\n", "1 2 3 -4\n")), HasSubstr("label of point 0 is -4"));
  EXPECT_FALSE(
      isCloud(folder_.write("m.ply",
                            "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nelement face 1\nproperty "
                            "list uchar int vertex_index\nend_header\n1\n1 0\n")));
}

// Doubles of a projection keep their millimetres; positions near zero stay bit for bit what they are.
TEST_F(CloudFiles, PcdKeepsTheMillimetresOfAProjection) {
  const std::string head =
      "VERSION 0.7\nFIELDS x y z label\nSIZE 8 8 8 4\nTYPE F F F U\nCOUNT 1 1 1 1\nWIDTH 2\nHEIGHT 1\nPOINTS 2\n";
  std::string binary;
  for (const double x : {5334567.123, 5334568.456}) {
    for (const double value : {x, 12.5, -3.25}) binary.append(reinterpret_cast<const char*>(&value), 8);
    binary.append("\7\0\0\0", 4);
  }
  for (const std::string& bytes :
       {head + "DATA binary\n" + binary, head + "DATA ascii\n5334567.123 12.5 -3.25 7\n5334568.456 12.5 -3.25 7\n"}) {
    const Cloud cloud = read("a.pcd", bytes);
    EXPECT_LT(length(placeOf(cloud, 1) - Vec3d{5334568.456, 12.5, -3.25}), 1e-6);
    EXPECT_EQ(cloud.origin.y, 0);
    EXPECT_EQ(cloud.scan.position[1].y, 12.5f);
    EXPECT_THAT(cloud.scan[kLabel], ElementsAre(7, 7));
  }
  EXPECT_THAT(refused("a.txt", "1 2 3"), HasSubstr("no scan of a known kind"));
  EXPECT_THAT(refused("a.npz", "PK"), AllOf(HasSubstr("a.npz"), HasSubstr("numpy.savetxt")));
  EXPECT_THAT(refused("a.e57", "ASTM-E57"), AllOf(HasSubstr("a.e57"), HasSubstr("pdal translate a.e57 a.las")));
  EXPECT_FALSE(isCloud("a.glb"));
  EXPECT_TRUE(isCloud("a.LAS"));
}

TEST_F(CloudFiles, TextKeepsTheMillimetresOfAProjection) {
  const Cloud cloud = read("a.xyz", "X Y Z Intensity\n5334567.123 12.5 -3.25 7\n5334568.456 12.5 -3.25 8");
  EXPECT_LT(length(placeOf(cloud, 1) - Vec3d{5334568.456, 12.5, -3.25}), 1e-6);
  EXPECT_THAT(cloud.scan[kIntensity], ElementsAre(7, 8));
}

// Both clouds and grids of heights are called .asc.
TEST_F(CloudFiles, AscIsACloudIfItListsPoints) {
  EXPECT_THAT(read("a.asc", "//X Y Z Intensity\n1 2 3 7\n4 5 6 8\n").scan[kIntensity], ElementsAre(7, 8));
  EXPECT_EQ(read("b.asc", "1.5;2;-3\n2.5;2;4\n").scan.position.at(0), (Vec3f{1.5f, 2, -3}));
  EXPECT_TRUE(isScan(folder_.path() / "b.asc"));
  EXPECT_FALSE(isCloud(folder_.write("g.asc", "ncols 3\nnrows 1\nxllcorner 0\nyllcorner 0\ncellsize 1\n1 2 3\n")));
  EXPECT_FALSE(isCloud(folder_.write("h.asc", "# by x\nnorth: 1\nsouth: 0\nrows: 1\ncols: 3\n1 2 3\n")));
}

TEST_F(CloudFiles, ListsOfPlyAreSkipped) {
  const std::string weights = "property list uchar short weights\nproperty int label\n";
  std::string binary;
  for (const float c : {1.0f, 2.0f, 3.0f}) put(binary, binary.size(), c);
  put<std::uint8_t>(binary, 12, 2), put<std::int16_t>(binary, 13, 8), put<std::int16_t>(binary, 15, 9);
  put<std::int32_t>(binary, 17, 40);
  for (const std::string& bytes : {plyOf(weights, "1 2 3 2 8 9 40"), plyOf(weights, binary, "binary_little_endian")}) {
    const Cloud cloud = read("a.ply", bytes);
    EXPECT_EQ(cloud.scan.position[0], (Vec3f{1, 2, 3}));
    EXPECT_THAT(cloud.scan[kLabel], ElementsAre(40));
    EXPECT_EQ(cloud.leftOut.text(), "1 lists at vertices 'weights'");
  }
  // Blanks within numbers make too many values.
  EXPECT_THAT(refused("b.ply", plyOf("", "1 234.5 2 3")), HasSubstr("b.ply:8: 'vertex' 1 of 1 has more values"));
}

TEST_F(CloudFiles, NamesOfOtherProgramsAreFound) {
  // Of CARLA.
  Cloud cloud = read(
      "a.ply", plyOf("property float32 CosAngle\nproperty uint32 ObjIdx\nproperty uint32 ObjTag\n", "1 2 3 0.5 17 14"));
  EXPECT_THAT(cloud.scan[kLabel], ElementsAre(14));
  EXPECT_THAT(cloud.scan[kInstance], ElementsAre(17u));
  EXPECT_EQ(cloud.scan.foreign.at(0).name, "cosangle");
  // The column's own name goes before others, which stay what they are.
  cloud =
      read("a.ply", plyOf("property int class\nproperty int label\nproperty float scalar_Intensity\n", "1 2 3 8 9 5"));
  EXPECT_THAT(cloud.scan[kLabel], ElementsAre(9));
  EXPECT_THAT(cloud.scan[kIntensity], ElementsAre(5));
  EXPECT_EQ(cloud.scan.foreign.at(0).name, "class");
  // The label -1 means none.
  cloud = read("a.ply", plyOf("property float scalar_Label\n", "1 2 3 -1"));
  EXPECT_THAT(cloud.scan[kLabel], ElementsAre(0));
  cloud = read("a.pcd",
               "VERSION 0.7\nFIELDS x y z label instance\nSIZE 4 4 4 4 4\nTYPE F F F I I\nCOUNT 1 1 1 1 1\nWIDTH 2\n"
               "HEIGHT 1\nPOINTS 2\nDATA ascii\n1 2 3 -1 -1\n4 5 6 7 0\n");
  EXPECT_THAT(cloud.scan[kLabel], ElementsAre(0, 7));
  EXPECT_THAT(cloud.scan[kInstance], ElementsAre(0u, 1u));
  // Other names whose numbers do not fit are told.
  cloud = read("a.csv", "x,y,z,class,laser_id\n1,2,3,-2,5\n");
  EXPECT_TRUE(cloud.scan[kLabel].empty());
  EXPECT_THAT(cloud.scan[kRing], ElementsAre(5));
  EXPECT_EQ(cloud.leftOut.text(), "1 columns 'class' (label of point 0 is -2: no integer of 0 to 65535)");
}

}  // namespace
}  // namespace scanmill
