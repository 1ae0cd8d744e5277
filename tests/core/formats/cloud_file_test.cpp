#include "formats/cloud_file.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>

#include "base/file.h"
#include "tests/support/message_of.h"
#include "tests/support/shared_data.h"
#include "tests/support/temporary_folder.h"

namespace scanmill {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

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
  for (const int minor : {0, 1, 2, 3, 4}) {
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
  EXPECT_THAT(refused("b.ply", header("ascii") + text.substr(0, 40)), HasSubstr("b.ply"));
  EXPECT_THAT(refused("b.ply", header("binary_little_endian") + binary(false).substr(0, 50)), HasSubstr("truncated"));
  // Numbers that their type cannot hold.
  const auto one = [&](const char* type, const char* number) {
    return refused("b.ply", fmt::format("ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n"
                                        "property float z\nproperty {} red\nend_header\n1 2 3 {}\n",
                                        type, number));
  };
  EXPECT_THAT(one("uchar", "300"), AllOf(HasSubstr("red of point 0 is 300"), HasSubstr("0 to 255")));
  EXPECT_THAT(one("char", "-129"), AllOf(HasSubstr("red of point 0 is -129"), HasSubstr("-128 to 127")));
  EXPECT_THAT(one("uint", "-1"), HasSubstr("red of point 0 is -1"));
  EXPECT_EQ(one("char", "-128"), "accepted");
  EXPECT_THAT(refused("b.ply", "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nend_header\n1\n"),
              HasSubstr("no property y"));
  EXPECT_THAT(refused("b.ply",
                      "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float "
                      "z\nproperty int label\nend_header\n1 2 3 -4\n"),
              HasSubstr("label of point 0 is -4"));
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
  EXPECT_THAT(refused("a.xyz", "1 2 3"), HasSubstr("no scan of a known kind"));
  EXPECT_FALSE(isCloud("a.glb"));
  EXPECT_TRUE(isCloud("a.LAS"));
}

TEST_F(CloudFiles, ARealRecordingIsReadAsItsScan) {
  SKIP_WITHOUT_SHARED_DATA("lidar/ouster_os1_128");
  const Cloud cloud = readCloud(sharedData() / "lidar/ouster_os1_128/frame_1795.pcd");
  EXPECT_EQ(cloud.scan.size(), 128u * 1024);
  EXPECT_EQ(cloud.origin, Vec3d{});
}

}  // namespace
}  // namespace scanmill
