#include <fmt/format.h>
#include <pcl/io/pcd_io.h>
#include <pcl/point_types.h>

#include <cstring>

#include "base/file.h"
#include "formats/readers.h"
#include "tests/core/formats/scans.h"
#include "tests/support/shared_data.h"
#include "tests/support/temporary_folder.h"

namespace scanmill {
namespace {

using ::testing::HasSubstr;

constexpr const char* kPcdEncodings[] = {"binary_compressed", "binary", "ascii"};

std::unique_ptr<Format> pcd(const char* encoding) {
  return makeFormat("pcd", fmt::format("encoding: {}", encoding));
}

Scan decodedPcd(const std::string& bytes) {
  return makeFormat("pcd")->decode(bytes, "test.pcd");
}

void expectRoundTrips(const Scan& scan) {
  for (const char* encoding : kPcdEncodings) {
    SCOPED_TRACE(encoding);
    expectSame(decodedPcd(pcd(encoding)->encode(scan)), scan);
  }
}

// Columns of others stay what they are, whatever their types.
TEST(Pcd, ForeignColumnsComeBackInTheirTypes) {
  for (const char* encoding : kPcdEncodings) {
    for (const bool organised : {false, true}) {
      SCOPED_TRACE(fmt::format("{} organised {}", encoding, organised));
      Scan scan = randomScan(3, 4, 25, kAllColumns, organised, 50);
      std::mt19937_64 generator(5);
      const auto add = [&]<class T>(const char* name, T) {
        std::vector<T> values;
        for (std::size_t i = 0; i < scan.size(); ++i) {
          values.push_back(std::is_integral_v<T> ? static_cast<T>(generator())
                                                 : static_cast<T>(static_cast<double>(generator()) * 1e-3));
        }
        scan.foreign.push_back({name, std::move(values)});
      };
      add("near_ir", std::uint16_t{}), add("t", std::uint32_t{}), add("timestamp", double{}), add("ambient", float{});
      add("u1", std::uint8_t{}), add("u8", std::uint64_t{}), add("i1", std::int8_t{}), add("i2", std::int16_t{});
      add("i4", std::int32_t{}), add("i8", std::int64_t{});
      const Scan back = decodedPcd(pcd(encoding)->encode(scan));
      expectSame(back, scan);
      ASSERT_EQ(back.foreign.size(), scan.foreign.size());
      for (std::size_t c = 0; c < scan.foreign.size(); ++c) {
        EXPECT_EQ(back.foreign[c].name, scan.foreign[c].name);
        EXPECT_EQ(back.foreign[c].values, scan.foreign[c].values) << scan.foreign[c].name;
      }
    }
  }
}

TEST(Pcd, FurtherReturnsAreFurtherPlanes) {
  Scan scan = randomScan(3, 6, 25, kAllColumns, true, 50);
  scan.rings = 2;
  scan.planes = 3;
  for (auto& ring : scan[kRing]) ring %= 2;
  expectRoundTrips(scan);
  const std::string text =
      "# scanmill sensor: 4 1 organised\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nWIDTH 1\nHEIGHT 6\n";
  EXPECT_THAT(messageOf([&] { decodedPcd(text + "POINTS 6\nDATA ascii\n"); }), HasSubstr("disagree with the sensor"));
}

template <class T>
std::vector<T> fieldOf(const pcl::PCLPointCloud2& cloud, const std::string& name) {
  for (const pcl::PCLPointField& field : cloud.fields) {
    if (field.name != name) continue;
    std::vector<T> values(std::size_t{cloud.width} * cloud.height);
    for (std::size_t i = 0; i < values.size(); ++i) {
      std::memcpy(&values[i], &cloud.data[i * cloud.point_step + field.offset], sizeof(T));
    }
    return values;
  }
  return {};
}

void expectPclReads(const Scan& scan, const std::filesystem::path& file) {
  pcl::PCLPointCloud2 cloud;
  ASSERT_EQ(pcl::PCDReader().read(file.string(), cloud), 0);
  EXPECT_EQ(cloud.width, scan.width());
  EXPECT_EQ(cloud.height, scan.height());
  std::vector<std::string> names;
  for (const pcl::PCLPointField& field : cloud.fields) names.push_back(field.name);
  EXPECT_EQ(names, columnNames(scan));
  Scan read;
  const std::vector<float> x = fieldOf<float>(cloud, "x");
  const std::vector<float> y = fieldOf<float>(cloud, "y");
  const std::vector<float> z = fieldOf<float>(cloud, "z");
  for (std::size_t i = 0; i < x.size(); ++i) read.position.push_back({x[i], y[i], z[i]});
  visitTable(read, [&]<class T>(auto key, std::vector<T>& values) {
    if (key.index != kLabel.index) values = fieldOf<T>(cloud, std::string(key.row.name));
  });
  for (const std::uint32_t label : fieldOf<std::uint32_t>(cloud, "label")) {
    ASSERT_LT(label, 65536u);
    read[kLabel].push_back(static_cast<std::uint16_t>(label));
  }
  expectSameColumns(read, scan);
}

TEST(Pcd, PclReadsWhatWeWrite) {
  const TemporaryFolder folder;
  for (const char* encoding : kPcdEncodings) {
    for (const unsigned columns : {0u, 1u, 2u, 28u, 60u, 127u, 128u, kAllColumns}) {
      for (const bool organised : {false, true}) {
        SCOPED_TRACE(fmt::format("{} columns {:x} organised {}", encoding, columns, organised));
        const Scan scan = randomScan(columns + 1, 6, 50, columns, organised, 120);
        expectPclReads(scan, folder.write("scan.pcd", pcd(encoding)->encode(scan)));
      }
    }
    SCOPED_TRACE(encoding);
    expectPclReads(extremeScan(), folder.write("extreme.pcd", pcd(encoding)->encode(extremeScan())));
    expectPclReads(Scan{}, folder.write("empty.pcd", pcd(encoding)->encode(Scan{})));
  }
}

TEST(Pcd, WeReadWhatPclWrites) {
  const TemporaryFolder folder;
  pcl::PointCloud<pcl::PointXYZL> cloud(5, 2);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const auto f = static_cast<float>(i);
    cloud[i].x = f;
    cloud[i].y = -f / 3;
    cloud[i].z = f * f;
    cloud[i].label = static_cast<std::uint32_t>(i * 7);
  }
  const std::string file = (folder.path() / "pcl.pcd").string();
  const auto expectRead = [&] {
    const Scan scan = decodedPcd(readFile(file));
    EXPECT_TRUE(scan.organised);
    EXPECT_EQ(scan.rings, 2u);
    EXPECT_EQ(scan.columns, 5u);
    ASSERT_EQ(scan.size(), cloud.size());
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      EXPECT_NEAR(scan.position[i].y, cloud[i].y, 1e-6f);
      EXPECT_EQ(scan[kLabel][i], cloud[i].label);
    }
  };
  pcl::io::savePCDFileASCII(file, cloud);
  expectRead();
  pcl::io::savePCDFileBinary(file, cloud);
  expectRead();
  pcl::io::savePCDFileBinaryCompressed(file, cloud);
  expectRead();
}

// Foreign files: other orders, types and fields of no interest.
TEST(Pcd, FieldsMayComeInAnyOrderAndType) {
  const Scan scan = decodedPcd(
      "# a comment\nVERSION .7\nFIELDS label normal z y _ x ring\nSIZE 8 4 8 4 1 4 1\nTYPE I F F F U F U\n"
      "COUNT 1 3 1 1 2 1 1\nWIDTH 2\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS 2\nDATA ascii\n"
      "4 9 9 9 3 2 8 8 1 5\n65535 9 9 9 nan 2.5 8 8 -1e-3 6\n");
  ASSERT_EQ(scan.size(), 2u);
  EXPECT_EQ(scan.position[0], (Vec3f{1, 2, 3}));
  EXPECT_EQ(scan.position[1].x, -1e-3f);
  EXPECT_TRUE(std::isnan(scan.position[1].z));
  EXPECT_EQ(scan[kLabel], (std::vector<std::uint16_t>{4, 65535}));
  EXPECT_EQ(scan[kRing], (std::vector<std::uint16_t>{5, 6}));
  EXPECT_TRUE(scan[kInstance].empty());
  EXPECT_FALSE(scan.organised);
}

TEST(Pcd, ValuesThatDoNotFitAreRefused) {
  const std::string head = "FIELDS x y z label\nSIZE 4 4 4 4\nTYPE F F F {}\nWIDTH 1\nHEIGHT 1\nPOINTS 1\nDATA {}\n";
  const float xyz[3] = {1, 2, 3};
  const auto binary = [&](char type, auto label) {
    return fmt::format(fmt::runtime(head), type, "binary") + std::string(reinterpret_cast<const char*>(xyz), 12) +
           std::string(reinterpret_cast<const char*>(&label), 4);
  };
  EXPECT_EQ(decodedPcd(binary('F', 65535.0f))[kLabel][0], 65535);
  EXPECT_EQ(decodedPcd(binary('I', 65535))[kLabel][0], 65535);
  for (const std::string& bytes :
       {binary('U', 65536u), binary('I', -2), binary('F', 0.5f), binary('F', std::nanf("")), binary('F', 1e10f),
        fmt::format(fmt::runtime(head), 'U', "ascii") + "1 2 3 65536\n"}) {
    EXPECT_THAT(messageOf([&] { decodedPcd(bytes); }),
                AllOf(HasSubstr("test.pcd"), HasSubstr("label"), HasSubstr("label = number & 0xFFFF")));
  }
}

TEST(Pcd, FieldsAreListedIfTheCoordinatesHaveOtherNames) {
  const std::string text = "FIELDS point_x point_y z label\nSIZE 4 4 4 4\nTYPE F F F U\nWIDTH 1\nHEIGHT 1\nPOINTS 1\n";
  EXPECT_THAT(messageOf([&] { decodedPcd(text + "DATA ascii\n1 2 3 4\n"); }),
              HasSubstr("there is no field x, but point_x, point_y, z, label: name the coordinates x, y and z"));
}

TEST(Pcd, LyingHeadersAreRefused) {
  const auto file = [](std::uint64_t width, std::uint64_t height, std::uint64_t points, const std::string& body) {
    return fmt::format("FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH {}\nHEIGHT {}\nPOINTS {}\nDATA {}",
                       width, height, points, body);
  };
  const std::string zeros(24, '\0');
  const auto compressed = [](std::uint32_t packed, std::uint32_t raw, std::size_t bytes) {
    std::string body = "binary_compressed\n";
    body.append(reinterpret_cast<const char*>(&packed), 4);
    body.append(reinterpret_cast<const char*>(&raw), 4);
    return body + std::string(bytes, '\xff');
  };
  const std::string bad[] = {
      "",
      "hello",
      file(1'000'000'000'000, 1, 1'000'000'000'000, "binary\n" + zeros),
      file(1'000'000'000, 1, 1'000'000'000, "binary\n" + zeros),
      file(1'000'000'000, 4, 4'000'000'000, "ascii\n1 2 3\n"),
      file(2, 2, 2, "binary\n" + zeros),
      file(3, 1, 3, "binary\n" + zeros),
      file(2, 1, 2, "zip\n" + zeros),
      file(2, 1, 2, "ascii\n1 2 3\n"),
      file(1, 1, 1, "ascii\n1 2 3 4\n"),
      file(1, 1, 1, "ascii\n1 2\n"),
      file(1, 1, 1, "ascii\n1 2 three\n"),
      file(2, 1, 2, compressed(8, 24, 8)),
      file(2, 1, 2, compressed(9, 24, 8)),
      file(2, 1, 2, compressed(8, 25, 8)),
      file(300'000'000, 1, 300'000'000, compressed(8, 3'600'000'000u, 8)),
      "FIELDS x y\nSIZE 4 4\nTYPE F F\nWIDTH 0\nHEIGHT 1\nPOINTS 0\nDATA ascii\n",
      "FIELDS x y z\nSIZE 4 4 3\nTYPE F F F\nWIDTH 0\nHEIGHT 1\nPOINTS 0\nDATA ascii\n",
      "FIELDS x y z\nSIZE 4 4\nTYPE F F F\nWIDTH 0\nHEIGHT 1\nPOINTS 0\nDATA ascii\n",
      "SIZE 4 4 4\nFIELDS x y z\nTYPE F F F\nWIDTH 0\nHEIGHT 1\nPOINTS 0\nDATA ascii\n",
      "FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 2\nWIDTH 1\nHEIGHT 1\nPOINTS 1\nDATA ascii\n1 2 3 4\n",
      "FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 0 0 0\nWIDTH 1\nHEIGHT 1\nPOINTS 1\nDATA ascii\n1 2 3\n",
      "FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nWIDTH 2147483648\nHEIGHT 2147483648\nDATA binary\n" + zeros,
      "FIELDS x y z\nSIZE 4 4 4\nTYPE F F Q\nWIDTH 0\nHEIGHT 1\nPOINTS 0\nDATA ascii\n",
      "FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nWIDTH -1\nHEIGHT 1\nPOINTS 0\nDATA ascii\n",
  };
  for (const std::string& bytes : bad) {
    EXPECT_THAT(messageOf([&] { decodedPcd(bytes); }), HasSubstr("test.pcd")) << bytes;
  }
}

TEST(Pcd, TextErrorsNameTheLine) {
  const std::string text = "FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nWIDTH 2\nHEIGHT 1\nPOINTS 2\nDATA ascii\n1 2 3\n";
  EXPECT_THAT(messageOf([&] { decodedPcd(text + "4 five 6\n"); }), HasSubstr("test.pcd:9: y"));
  EXPECT_THAT(messageOf([&] { decodedPcd("FIELDS x y z\nNONSENSE 1\n"); }), HasSubstr("test.pcd:2"));
  EXPECT_THAT(messageOf([&] { decodedPcd(text + "4,5 5 6\n"); }), HasSubstr("test.pcd:9: x must be a number"));
}

TEST(Pcd, TheLastLineMayHaveNoEnd) {
  const std::string head = "FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nWIDTH 2\nHEIGHT 1\nPOINTS 2\nDATA ascii\n";
  EXPECT_EQ(decodedPcd(head + "1 2 3\n4 5 6").position[1], (Vec3f{4, 5, 6}));
  EXPECT_THAT(messageOf([&] { decodedPcd(head + "1 2 3\n4 5"); }),
              HasSubstr("test.pcd:9: there is no value of field z"));
  EXPECT_THAT(messageOf([&] { decodedPcd(head + "1 2 3"); }), HasSubstr("truncated"));
}

std::string withViewpoint(const std::string& numbers) {
  return "VERSION .7\nFIELDS x y z Classification normal\nSIZE 4 4 4 1 4\nTYPE F F F U F\nCOUNT 1 1 1 1 3\nWIDTH 1\n"
         "HEIGHT 1\nVIEWPOINT " +
         numbers + "\nPOINTS 1\nDATA ascii\n1 2 3 40 0 0 1\n";
}

TEST(Pcd, TheViewpointIsThePoseAndTheScanKeepsItsFrame) {
  const Cloud cloud = readPcd(withViewpoint("10 20 30 0.7071 0 0 0.7071"), "a.pcd");
  EXPECT_EQ(cloud.scan.position[0], (Vec3f{1, 2, 3}));
  EXPECT_LT(length(cloud.worldFromFile * Vec3d{1, 2, 3} - Vec3d{8, 21, 33}), 1e-12) << "the quaternion is normalised";
  EXPECT_EQ(readPcd(withViewpoint("0 0 0 0 0 0 0"), "a.pcd").worldFromFile, Pose{});
  const auto refused = [](const char* numbers) { return messageOf([&] { readPcd(withViewpoint(numbers), "a.pcd"); }); };
  EXPECT_THAT(refused("1 0 0 0 0 0 0"),
              HasSubstr("a.pcd:8: VIEWPOINT has the quaternion 0 0 0 0 (w x y z), of the length 0"));
  EXPECT_THAT(refused("0 0 0 2 0 0 0"), HasSubstr("of the length 2, where a rotation has the length 1"));
  EXPECT_THAT(refused("0 inf 0 1 0 0 0"), HasSubstr("a.pcd:8: VIEWPOINT has the translation 0 inf 0"));
  EXPECT_THAT(refused("0 0 0 nan 0 0 0"), HasSubstr("a.pcd:8"));
  EXPECT_THAT(refused("0 0 0 1"), HasSubstr("seven values"));
  EXPECT_THAT(refused("0 0 0 one 0 0 0"), HasSubstr("a.pcd:8: VIEWPOINT must be a number"));
}

TEST(Pcd, NamesOfOtherProgramsAreFoundAndWhatIsLeftOutIsCounted) {
  const Cloud cloud = readPcd(withViewpoint("0 0 0 1 0 0 0"), "a.pcd");
  EXPECT_EQ(cloud.scan[kLabel], std::vector<std::uint16_t>{40});
  EXPECT_TRUE(cloud.scan.foreign.empty());
  EXPECT_EQ(cloud.leftOut.text(), "1 fields of several values 'normal'");
  std::string reflectivity = withViewpoint("0 0 0 1 0 0 0");
  reflectivity.replace(reflectivity.find("Classification"), 14, "reflectivity");
  EXPECT_EQ(readPcd(reflectivity, "a.pcd").scan[kIntensity], std::vector<float>{40});
}

TEST(Pcd, WhatFollowsTheStatedPointsIsCounted) {
  const auto told = [](const std::string& data, const std::string& body) {
    return readPcd(
               "VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 1\nHEIGHT 1\nVIEWPOINT 0 0 0 "
               "1 0 0 0\nPOINTS 1\nDATA " +
                   data + "\n" + body,
               "a.pcd")
        .leftOut.text();
  };
  EXPECT_EQ(told("ascii", "1 2 3\n\n"), "");
  EXPECT_EQ(told("ascii", "1 2 3\n4 5 6\n"), "6 bytes behind the stated contents");
  EXPECT_EQ(told("binary", std::string(12, 'a') + std::string(5, '\0')), "");
  EXPECT_EQ(told("binary", std::string(24, 'a')), "12 bytes behind the stated contents");
}

TEST(Pcd, RealRecordingIsReadAsPclReadsIt) {
  const char* const kFrame = "lidar/ouster_os1_128/frame_1795.pcd";
  SKIP_WITHOUT_SHARED_DATA(kFrame);
  const std::string file = (sharedData() / kFrame).string();
  const Scan scan = makeFormat("pcd")->decode(readFile(file), file);
  EXPECT_TRUE(scan.organised);
  EXPECT_EQ(scan.rings, 128u);
  EXPECT_EQ(scan.columns, 1024u);
  EXPECT_EQ(columnNames(scan),
            (std::vector<std::string>{"x", "y", "z", "intensity", "ring", "column", "range", "near_ir"}));
  pcl::PCLPointCloud2 cloud;
  ASSERT_EQ(pcl::PCDReader().read(file, cloud), 0);
  const std::vector<float> x = fieldOf<float>(cloud, "x");
  std::vector<float> ours;
  for (const Vec3f& p : scan.position) ours.push_back(p.x);
  expectSameBits(ours, x, "x");
  EXPECT_EQ(scan[kRing], fieldOf<std::uint16_t>(cloud, "ring"));
  EXPECT_EQ(scan[kColumn], fieldOf<std::uint16_t>(cloud, "column"));
  const std::vector<std::uint8_t> reflectivity = fieldOf<std::uint8_t>(cloud, "reflectivity");
  EXPECT_TRUE(std::equal(scan[kIntensity].begin(), scan[kIntensity].end(), reflectivity.begin(), reflectivity.end()));
  expectRoundTrips(scan);
}

}  // namespace
}  // namespace scanmill
