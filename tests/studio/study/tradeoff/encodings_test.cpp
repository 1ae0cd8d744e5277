#include <limits>

#include "base/random.h"
#include "study/tradeoff/study.h"

namespace scanmill {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;

// Points of a revolution, up to 80 m away, in the order of firing.
Scan turnOf(std::uint32_t seed, std::uint32_t rings, std::uint32_t columns) {
  Scan scan;
  scan.rings = rings;
  scan.columns = columns;
  for (std::uint32_t column = 0; column < columns; ++column) {
    for (std::uint32_t ring = 0; ring < rings; ++ring) {
      const RandomBlock r = randomBlock({.seed = seed, .beam = ring * columns + column});
      const double azimuth = 2 * kPi * column / columns;
      const double range = 2 + 78 * uniform(r[0]);
      scan.position.push_back(
          Vec3f(Vec3d{range * std::cos(azimuth), range * std::sin(azimuth), 4 * uniform(r[1]) - 2}));
      scan[kIntensity].push_back(static_cast<float>(uniform(r[2])));
      scan[kLabel].push_back(static_cast<std::uint16_t>(r[3] % 20));
      scan[kRing].push_back(static_cast<std::uint16_t>(ring));
      scan[kColumn].push_back(static_cast<std::uint16_t>(column));
    }
  }
  return scan;
}

StudyEncoding encodingOf(const std::string& format, const std::string& options) {
  const Value value = parseYaml(options, "options");
  const FormatEntry& entry = requireFormat(format, {});
  Fields fields(value, format);
  return {format + " " + options, options, {&entry, entry.make(fields)}};
}

EncodingResult measured(const std::string& format, const std::string& options, std::span<const Scan> scans) {
  const EncodingResult result = measureEncoding(encodingOf(format, options), scans, 1);
  EXPECT_EQ(result.name, format + " " + options);
  EXPECT_EQ(result.format, format);
  EXPECT_EQ(result.options, options);
  return result;
}

TEST(Encodings, LosslessOnesLoseNothing) {
  const std::vector<Scan> scans{turnOf(1, 16, 64), turnOf(2, 16, 64)};
  for (const auto& [format, options] : {std::pair{"pcd", "{}"},
                                        {"pcd", "{encoding: binary}"},
                                        {"pcd", "{encoding: binary_compressed}"},
                                        {"csv", "{}"}}) {
    const EncodingResult result = measured(format, options, scans);
    EXPECT_THAT(result.failure, IsEmpty()) << format;
    EXPECT_EQ(result.largestError, 0) << format << options;
    EXPECT_EQ(result.statedError, 0) << format;
    EXPECT_GT(result.encodePointsPerSecond, 0);
    EXPECT_GT(result.decodePointsPerSecond, 0);
  }
}

TEST(Encodings, DracoKeepsItsBoundAndTakesFewerBytesForLargerOnes) {
  const std::vector<Scan> scans{turnOf(1, 32, 256)};
  double bytes = std::numeric_limits<double>::infinity();
  double error = 0;
  for (const double bound : {0.1, 1.0, 10.0, 50.0}) {
    const EncodingResult result = measured("draco", "{max_error_mm: " + std::to_string(bound) + "}", scans);
    ASSERT_THAT(result.failure, IsEmpty());
    EXPECT_LE(result.statedError, bound * 1e-3 * (1 + 1e-9));
    EXPECT_GT(result.largestError, result.statedError / 10) << "the bound is used";
    EXPECT_LE(result.largestError, result.statedError);
    EXPECT_LT(result.bytesPerPoint, bytes);
    EXPECT_GT(result.largestError, error);
    bytes = result.bytesPerPoint;
    error = result.largestError;
  }
}

TEST(Encodings, BytesAreThoseOfAllScans) {
  const std::vector<Scan> scans{turnOf(1, 4, 64), turnOf(2, 8, 64)};
  const StudyEncoding csv = encodingOf("csv", "{}");
  const double bytes =
      static_cast<double>(csv.choice.format->encode(scans[0]).size() + csv.choice.format->encode(scans[1]).size());
  EXPECT_DOUBLE_EQ(measureEncoding(csv, scans, 3).bytesPerPoint, bytes / (12 * 64));
}

TEST(Encodings, MissesOfOrganisedScansAreNoPoints) {
  Scan organised = turnOf(1, 4, 64);
  organised.organised = true;
  organised.position[5] = Vec3f{NAN, NAN, NAN};
  const EncodingResult draco = measured("draco", "{max_error_mm: 1}", std::vector<Scan>{organised});
  EXPECT_THAT(draco.failure, IsEmpty());
  EXPECT_GT(draco.largestError, 0);
  EXPECT_LE(draco.largestError, 1e-3);
  const StudyEncoding csv = encodingOf("csv", "{}");
  EXPECT_DOUBLE_EQ(measureEncoding(csv, std::vector<Scan>{organised}, 1).bytesPerPoint,
                   static_cast<double>(csv.choice.format->encode(organised).size()) / (4 * 64 - 1));
  const EncodingResult pcd = measured("pcd", "{}", std::vector<Scan>{organised});
  EXPECT_THAT(pcd.failure, IsEmpty());
  EXPECT_EQ(pcd.largestError, 0);
  EXPECT_THAT(measured("pcd", "{}", {}).failure, HasSubstr("empty"));
  EXPECT_THAT(measured("pcd", "{}", std::vector<Scan>{Scan{}}).failure, HasSubstr("empty"));
}

// A format that gives back what it should not.
class Careless : public Format {
 public:
  explicit Careless(Scan decoded) : decoded_(std::move(decoded)) {}
  double maxError() const override { return 0.5; }
  bool keepsMisses() const override { return true; }
  double mostBytes(const ScanOutline&) const override { return 1; }
  std::string encode(const Scan&) const override { return "x"; }
  Scan decode(std::string_view, const std::string&) const override { return decoded_; }

 private:
  Scan decoded_;
};

TEST(Encodings, LostAndMovedPointsAreSeen) {
  const std::vector<Scan> scans{turnOf(1, 4, 64)};
  const auto given = [&](const Scan& decoded) {
    StudyEncoding careless{"careless", "{}", {&requireFormat("pcd", {}), std::make_unique<Careless>(decoded)}};
    return measureEncoding(careless, scans, 1);
  };
  Scan moved = scans[0];
  moved.position[7].y += 0.25f;
  EXPECT_NEAR(given(moved).largestError, 0.25, 1e-5);
  EXPECT_EQ(given(moved).statedError, 0.5);
  Scan fewer = scans[0];
  fewer.position.pop_back();
  EXPECT_THAT(given(fewer).failure, HasSubstr("255 of 256 points were decoded"));
  Scan lost = scans[0];
  lost.position[9].x = NAN;
  EXPECT_THAT(given(lost).failure, HasSubstr("point 9 was lost"));
}

}  // namespace
}  // namespace scanmill
