#include <draco/compression/decode.h>
#include <draco/compression/expert_encode.h>
#include <fmt/format.h>

#include <cstring>

#include "formats/draco_writer.h"
#include "formats/readers.h"
#include "tests/core/formats/scans.h"

namespace scanmill {
namespace {

using ::testing::HasSubstr;

Scan roundTrip(const Scan& scan, std::string_view options = "{}") {
  const auto format = makeFormat("draco", options);
  return format->decode(format->encode(scan), "test.drc");
}

double distance(Vec3f a, Vec3f b) {
  return length(Vec3d(a) - Vec3d(b));
}

double distance(float a, float b) {
  return std::fabs(double{a} - double{b});
}

template <class T>
double largestError(const std::vector<T>& a, const std::vector<T>& b) {
  EXPECT_EQ(a.size(), b.size());
  double worst = 0;
  for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i) worst = std::fmax(worst, distance(a[i], b[i]));
  return worst;
}

double largestError(const Scan& a, const Scan& b) {
  return largestError(a.position, b.position);
}

void expectSameIds(const Scan& read, const Scan& scan) {
  EXPECT_EQ(read[kLabel], scan[kLabel]);
  EXPECT_EQ(read[kInstance], scan[kInstance]);
  EXPECT_EQ(read[kRing], scan[kRing]);
  EXPECT_EQ(read[kColumn], scan[kColumn]);
}

std::unique_ptr<draco::PointCloud> byDraco(const std::string& bytes) {
  draco::DecoderBuffer buffer;
  buffer.Init(bytes.data(), bytes.size());
  draco::Decoder decoder;
  auto cloud = decoder.DecodePointCloudFromBuffer(&buffer);
  EXPECT_TRUE(cloud.ok()) << cloud.status().error_msg_string();
  return cloud.ok() ? std::move(cloud).value() : nullptr;
}

// Whatever the speed, which changes the size alone.
TEST(Draco, ErrorStaysWithinTheBound) {
  int speed = 0;
  for (const double bound : {0.1, 1.0, 10.0}) {
    for (const float reach : {0.5f, 1.0f, 7.0f, 30.0f, 100.0f, 150.0f, 299.0f, 300.0f}) {
      for (const float shift : {0.0f, 0.7f * reach}) {
        speed = (speed + 1) % 11;
        SCOPED_TRACE(fmt::format("{} mm, {} m, shifted {}, speed {}", bound, reach, shift, speed));
        Scan scan = randomScan(17, 40, 500, 0, false, reach);
        for (Vec3f& p : scan.position) p = {std::fmin(p.x + shift, 300.0f), p.y, p.z * 0.1f};
        const double error =
            largestError(scan, roundTrip(scan, fmt::format("{{max_error_mm: {}, speed: {}}}", bound, speed)));
        EXPECT_LE(error, bound * 1e-3);
        EXPECT_GT(error, bound * 0.3e-3) << "the step is far smaller than it need be";
      }
    }
  }
}

TEST(Draco, FloatsThatCannotKeepTheBoundAreRefused) {
  const Scan far = randomScan(1, 2, 50, 0, false, 300);
  EXPECT_THAT(messageOf([&] { roundTrip(far, "max_error_mm: 0.001"); }),
              AllOf(HasSubstr("0.001 mm"), HasSubstr("possible")));
  EXPECT_THAT(messageOf([&] { roundTrip(extremeScan()); }), HasSubstr("possible"));
  const Scan near = randomScan(1, 2, 50, 0, false, 2);
  EXPECT_LE(largestError(near, roundTrip(near, "max_error_mm: 0.001")), 1e-6);
}

TEST(Draco, SmallestPossibleBoundIsTheOneNamed) {
  for (const float reach : {1.0f, 40.0f, 300.0f}) {
    const Scan scan = randomScan(23, 20, 100, 0, false, reach);
    const float low[3] = {-reach, -reach, -reach};
    const float high[3] = {reach, reach, reach};
    double bound = 1e-3;
    try {
      for (;; bound *= 0.97) chooseGrid(low, high, bound, "scan");
    } catch (const InputError&) {
      bound /= 0.97;
    }
    EXPECT_GT(bound, reach * 1e-8);
    EXPECT_LT(bound, reach * 1e-6);
    if (bound < 1e-6) continue;
    EXPECT_LE(largestError(scan, roundTrip(scan, fmt::format("max_error_mm: {}", bound * 1e3))), bound);
  }
}

TEST(Draco, IntegersAreNeverChangedAndOrderIsKept) {
  for (const unsigned columns : {2u, 4u, 8u, 16u, 30u, 31u, kAllColumns}) {
    for (const auto& [rings, width] : {std::pair{1u, 1u}, {3u, 50u}, {64u, 300u}, {2u, 70'000u}}) {
      SCOPED_TRACE(fmt::format("columns {:x}, {} x {}", columns, rings, width));
      Scan scan = randomScan(columns, rings, width, columns, false, 100);
      const Scan read = roundTrip(scan);
      expectSameIds(read, scan);
      EXPECT_EQ(read.rings, scan.rings);
      EXPECT_EQ(read.columns, scan.columns);
      EXPECT_LE(largestError(scan, read), 1e-3);
    }
  }
}

TEST(Draco, IdsAtTheEndsOfTheirTypes) {
  Scan scan = extremeScan();
  for (std::size_t i = 0; i < scan.size(); ++i) scan.position[i] = {static_cast<float>(i), 0, 1};
  forEachColumn([&](auto key) {
    if (key.row.loss == ColumnLoss::AsPositions) scan[key].clear();
  });
  const Scan read = roundTrip(scan);
  expectSameIds(read, scan);
  expectSameBits(read[kIntensity], scan[kIntensity], "intensity");
  for (const std::uint32_t id : {0u, 255u, 256u, 65535u, 65536u, 0x7FFFFFFFu, 0x80000000u, 0xFFFFFFFFu}) {
    scan[kInstance].assign(scan.size(), id);
    EXPECT_EQ(roundTrip(scan)[kInstance], scan[kInstance]);
    scan[kInstance][3] = 0;
    EXPECT_EQ(roundTrip(scan)[kInstance], scan[kInstance]);
  }
}

TEST(Draco, IdenticalPointsStay) {
  Scan scan;
  scan.position.assign(1000, {1, 2, 3});
  scan[kLabel].assign(1000, 9);
  EXPECT_EQ(roundTrip(scan)[kLabel], scan[kLabel]);
}

TEST(Draco, MissesAreLeftOutAndRingAndColumnJoinTheRest) {
  const Scan scan = randomScan(31, 16, 100, kAllColumns, true, 80);
  const Scan read = roundTrip(scan, "{time: true}");
  EXPECT_FALSE(makeFormat("draco")->keepsMisses());
  EXPECT_FALSE(read.organised);
  EXPECT_EQ(read.rings, 16u);
  EXPECT_EQ(read.columns, 100u);
  std::size_t next = 0;
  for (std::size_t beam = 0; beam < scan.size(); ++beam) {
    if (!isFinite(scan.position[beam])) continue;
    ASSERT_LT(next, read.size());
    EXPECT_EQ(read[kRing][next] * 100u + read[kColumn][next], beam);
    EXPECT_LE(distance(read.position[next], scan.position[beam]), 1e-3);
    EXPECT_LE(distance(read[kRangeTrue][next], scan[kRangeTrue][beam]), 1e-3);
    EXPECT_LE(distance(read[kIncidence][next], scan[kIncidence][beam]), 1e-4);
    EXPECT_EQ(read[kTime][next], scan[kTime][beam]);
    EXPECT_EQ(read[kIntensity][next], scan[kIntensity][beam]);
    ++next;
  }
  EXPECT_EQ(next, read.size());
  EXPECT_TRUE(roundTrip(scan)[kTime].empty()) << "time is left out unless asked for";
}

TEST(Draco, EmptyScans) {
  Scan empty;
  empty.rings = 64;
  empty.columns = 2048;
  expectSame(roundTrip(empty), empty);
  EXPECT_EQ(byDraco(makeFormat("draco")->encode(empty))->num_points(), 0u);
  Scan misses = randomScan(1, 4, 4, kAllColumns, true, 10);
  for (Vec3f& p : misses.position) p.z = std::nanf("");
  EXPECT_EQ(roundTrip(misses).size(), 0u);
}

TEST(Draco, IntensitiesAreNarrowedOnlyWhereNothingIsLost) {
  const auto typeOf = [](std::vector<float> intensity) {
    Scan scan;
    scan.position.assign(intensity.size(), {1, 2, 3});
    scan[kIntensity] = intensity;
    const auto format = makeFormat("draco");
    const std::string bytes = format->encode(scan);
    expectSameBits(format->decode(bytes, "x")[kIntensity], intensity, "intensity");
    return byDraco(bytes)->attribute(1)->data_type();
  };
  EXPECT_EQ(typeOf({0, 1, 255}), draco::DT_UINT8);
  EXPECT_EQ(typeOf({0, 1, 256}), draco::DT_UINT16);
  EXPECT_EQ(typeOf({65535}), draco::DT_UINT16);
  for (const float odd : {0.5f, 65536.0f, -1.0f, -0.0f, std::nanf(""), INFINITY, 1e-45f}) {
    EXPECT_EQ(typeOf({0, 1, odd}), draco::DT_FLOAT32) << odd;
  }
}

// Whatever the bound of positions; what is no angle is kept bit by bit.
TEST(Draco, IncidencesKeepTheirOwnBound) {
  for (const char* options : {"max_error_mm: 0.1", "max_error_mm: 100"}) {
    const Scan scan = randomScan(4, 20, 200, 128, false, 40);
    const Scan read = roundTrip(scan, options);
    const double worst = largestError(read[kIncidence], scan[kIncidence]);
    EXPECT_LE(worst, 1e-4) << options;
    EXPECT_GT(worst, 0.5e-4) << "the step is far smaller than it need be";
  }
  Scan scan;
  scan.position.assign(3, {1, 2, 3});
  const auto halfPi = static_cast<float>(kPi / 2);
  scan[kIncidence] = {0, halfPi, halfPi};
  EXPECT_NEAR(roundTrip(scan)[kIncidence][1], halfPi, 1e-4);
  for (const float odd : {-1.0f, 90.0f, 1e30f, std::nanf(""), INFINITY}) {
    scan[kIncidence] = {0.25f, odd, 1.0f / 3};
    expectSameBits(roundTrip(scan)[kIncidence], scan[kIncidence], "incidence");
  }
}

TEST(Draco, AnyDracoReaderFindsMetresAndNames) {
  const Scan scan = randomScan(12, 8, 60, kAllColumns, false, 70);
  const auto cloud = byDraco(makeFormat("draco", "{time: true}")->encode(scan));
  ASSERT_EQ(cloud->num_points(), scan.size());
  const draco::PointAttribute* position = cloud->GetNamedAttribute(draco::GeometryAttribute::POSITION);
  ASSERT_NE(position, nullptr);
  EXPECT_EQ(position->data_type(), draco::DT_FLOAT32);
  for (std::uint32_t i = 0; i < cloud->num_points(); ++i) {
    Vec3f p;
    position->GetMappedValue(draco::PointIndex(i), &p);
    ASSERT_LE(distance(p, scan.position[i]), 1e-3);
  }
  std::vector<std::string> names = ColumnSet::all().names();
  names.insert(names.begin(), "position");
  ASSERT_EQ(cloud->num_attributes(), static_cast<int>(names.size()));
  for (int i = 0; i < cloud->num_attributes(); ++i) {
    EXPECT_EQ(cloud->GetAttributeIdByMetadataEntry("name", names[static_cast<std::size_t>(i)]), i);
  }
  std::int32_t rings = 0;
  EXPECT_TRUE(cloud->GetMetadata()->GetEntryInt("rings", &rings));
  EXPECT_EQ(rings, 8);
}

TEST(Draco, ForeignColumnsThatItHoldsExactlyAreKept) {
  Scan scan = randomScan(4, 3, 50, kAllColumns, false, 50);
  std::vector<std::uint16_t> infrared;
  std::vector<float> signal;
  for (std::size_t i = 0; i < scan.size(); ++i) {
    infrared.push_back(static_cast<std::uint16_t>(i * 431));
    signal.push_back(0.1f * static_cast<float>(i));
  }
  scan.foreign = {{"near_ir", infrared}, {"signal", signal}, {"t", std::vector<double>(scan.size(), 0.5)}};
  const Scan back = makeFormat("draco")->decode(makeFormat("draco")->encode(scan), "test.drc");
  ASSERT_EQ(back.foreign.size(), 2u) << "doubles are none of its";
  EXPECT_EQ(back.foreign[1].name, "signal");
  EXPECT_EQ(std::get<std::vector<float>>(back.foreign[1].values), signal);
  std::visit(
      [&](const auto& values) {
        EXPECT_TRUE(std::equal(values.begin(), values.end(), infrared.begin(), infrared.end()));
      },
      back.foreign[0].values);
}

// Draco's own encoder, with both of its methods: foreign to us, and valid.
TEST(Draco, ForeignCloudsAreRead) {
  const Scan scan = randomScan(12, 8, 60, 0, false, 70);
  draco::PointCloud cloud;
  cloud.set_num_points(static_cast<std::uint32_t>(scan.size()));
  draco::GeometryAttribute shape;
  shape.Init(draco::GeometryAttribute::POSITION, nullptr, 3, draco::DT_FLOAT32, false, sizeof(Vec3f), 0);
  const int id = cloud.AddAttribute(shape, true, cloud.num_points());
  std::memcpy(cloud.attribute(id)->buffer()->data(), scan.position.data(), scan.size() * sizeof(Vec3f));
  shape.Init(draco::GeometryAttribute::NORMAL, nullptr, 3, draco::DT_FLOAT32, false, sizeof(Vec3f), 0);
  const int normal = cloud.AddAttribute(shape, true, cloud.num_points());
  std::memcpy(cloud.attribute(normal)->buffer()->data(), scan.position.data(), scan.size() * sizeof(Vec3f));
  for (const int method : {draco::POINT_CLOUD_SEQUENTIAL_ENCODING, draco::POINT_CLOUD_KD_TREE_ENCODING}) {
    draco::ExpertEncoder encoder(cloud);
    encoder.SetEncodingMethod(method);
    for (const int attribute : {id, normal}) encoder.SetAttributeQuantization(attribute, 18);
    draco::EncoderBuffer buffer;
    ASSERT_TRUE(encoder.EncodeToBuffer(&buffer).ok());
    const Cloud foreign = readDraco({buffer.data(), buffer.size()}, "foreign.drc");
    EXPECT_EQ(foreign.leftOut.text(), "1 attributes 'NORMAL' of 3 values");
    const Scan& read = foreign.scan;
    EXPECT_EQ(read.size(), scan.size());
    Vec3d sum;
    for (std::size_t i = 0; i < read.size(); ++i) {
      sum += Vec3d(read.position[i]) - Vec3d(scan.position[i]);
    }
    EXPECT_LT(length(sum) / static_cast<double>(read.size()), 1e-3) << method;
  }
}

TEST(Draco, LyingHeadersAreRefused) {
  const Scan scan = randomScan(12, 8, 60, kAllColumns, false, 70);
  const auto format = makeFormat("draco");
  const std::string good = format->encode(scan);
  const std::string points(reinterpret_cast<const char*>("\xE0\x01\0\0"), 4);  // 480
  const std::size_t at = good.find(points);
  ASSERT_NE(at, std::string::npos);
  for (const std::uint32_t lie : {481u, 0x00FFFFFFu, 0x7FFFFFFFu, 0xFFFFFFFFu}) {
    std::string bad = good;
    std::memcpy(&bad[at], &lie, sizeof(lie));
    EXPECT_THAT(messageOf([&] { format->decode(bad, "test.drc"); }), HasSubstr("test.drc")) << lie;
  }
  for (const char* text : {"", "DRACO", "DRACO\x02\x03", "# .PCD v0.7", "DRACO\x02\x03\x01\x01"}) {
    EXPECT_THAT(messageOf([&] { format->decode(text, "test.drc"); }), HasSubstr("test.drc"));
  }
}

}  // namespace
}  // namespace scanmill
