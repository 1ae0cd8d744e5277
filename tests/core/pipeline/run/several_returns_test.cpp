// Beams with two returns, one or none, all the way from a method to a dataset.

#include <algorithm>
#include <set>
#include <tuple>

#include "formats/format.h"
#include "pipeline/plan/shard_jobs.h"
#include "tests/core/pipeline/two_returns_yard.h"
#include "tests/support/lines_of.h"

namespace scanmill {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::HasSubstr;

class SeveralReturns : public TwoReturnsYard {
 protected:
  // The point of a beam's return: what the method says of it. Which it is follows from `beam` and `number` alone.
  void expectPoint(const Scan& scan, std::size_t point, std::uint32_t beam, std::uint32_t number,
                   double maxError) const {
    SCOPED_TRACE(fmt::format("point {}, beam {}, return {}", point, beam, number + 1));
    const double range = rangeOfReturn({}, beam, number);
    EXPECT_NEAR(length(Vec3d(scan.position[point])), range, maxError + 1e-5);
    EXPECT_EQ(scan[kRing][point], beam / kColumns);
    EXPECT_EQ(scan[kColumn][point], beam % kColumns);
    EXPECT_EQ(scan[kLabel][point], labelOfReturn(scene_.ontology, beam, number));
    EXPECT_EQ(scan[kInstance][point], instanceOfReturn(scene_, beam, number));
    EXPECT_NEAR(scan[kRangeTrue][point], range, maxError + 1e-5);
    if (!scan[kReturn].empty()) {
      EXPECT_EQ(scan[kReturn][point], number + 1);
    }
    if (!scan[kCause].empty()) {
      EXPECT_EQ(scan[kCause][point], 1);
    }
    if (!scan[kIncidence].empty()) {
      EXPECT_NEAR(scan[kIncidence][point], number == 0 ? 0 : std::acos(0.5), kIncidence.row.lossBound + 1e-6);
    }
  }

  // By column, ring and return; `numbered`: the keys know the return.
  void expectDense(const Scan& scan, std::uint32_t frame, double maxError, bool numbered) const {
    EXPECT_FALSE(scan.organised);
    EXPECT_EQ(scan.planes, 1u);
    ASSERT_EQ(scan.size(), pointsOfFrame(frame));
    EXPECT_TRUE(knowsBeams(scan));
    EXPECT_EQ(extentOf(scan), (PointKey{kRings, kColumns, numbered ? 2u : 1u}));
    std::size_t point = 0;
    for (std::uint32_t column = 0; column < kColumns; ++column) {
      for (std::uint32_t ring = 0; ring < kRings; ++ring) {
        const std::uint32_t beam = ring * kColumns + column;
        for (std::uint32_t number = 0; number < returnsOfBeam(beam, frame); ++number, ++point) {
          EXPECT_EQ(keyOf(scan, point), (PointKey{ring, column, numbered ? number : 0}));
          expectPoint(scan, point, beam, number, maxError);
        }
      }
    }
  }

  Scene scene_ = scene();
};

struct Written {
  std::string format;
  std::string suffix;
  double maxError = 0;
};

const std::vector<Written> kFormats{{"pcd", "pcd"},
                                    {"pcd: {encoding: binary}", "pcd"},
                                    {"pcd: {encoding: ascii}", "pcd"},
                                    {"csv", "csv"},
                                    {"draco: {max_error_mm: 2, time: true}", "drc", 2e-3}};

TEST_F(SeveralReturns, AreInEveryFormatOfDenseScans) {
  int number = 0;
  for (const Written& written : kFormats) {
    for (const char* columns : {kAllColumns, kWithoutReturn}) {
      SCOPED_TRACE(written.format + ", " + columns);
      const std::string name = fmt::format("dense{}", number++);
      make({columns, "effects=[intensity]", fmt::format("output.formats=[{}]", written.format)}, name);
      const std::vector<Scan> all = scans("." + written.suffix, name);
      ASSERT_EQ(all.size(), 4u);
      for (std::uint32_t frame = 0; frame < all.size(); ++frame) {
        expectDense(all[frame], frame, written.maxError, columns == kAllColumns);
      }
    }
  }
}

TEST_F(SeveralReturns, ArePlanesOfOrganisedScans) {
  int number = 0;
  for (const Written& written : kFormats) {
    if (written.suffix != "pcd") continue;
    for (const char* columns : {kAllColumns, kWithoutReturn}) {
      SCOPED_TRACE(written.format + ", " + columns);
      const std::string name = fmt::format("organised{}", number++);
      make({columns, "effects=[intensity]", "output.layout=organised",
            fmt::format("output.formats=[{}]", written.format)},
           name);
      const std::vector<Scan> all = scans(".pcd", name);
      ASSERT_EQ(all.size(), 4u);
      for (std::uint32_t frame = 0; frame < all.size(); ++frame) {
        const Scan& scan = all[frame];
        EXPECT_TRUE(scan.organised);
        EXPECT_EQ(scan.planes, 2u);
        EXPECT_EQ(scan.width(), kColumns);
        EXPECT_EQ(scan.height(), 2 * kRings);
        ASSERT_EQ(scan.size(), 2u * kRings * kColumns);
        EXPECT_EQ(extentOf(scan), (PointKey{kRings, kColumns, 2}));
        for (std::uint32_t i = 0; i < scan.size(); ++i) {
          const std::uint32_t beam = i % (kRings * kColumns);
          const std::uint32_t plane = i / (kRings * kColumns);
          ASSERT_EQ(keyOf(scan, i), (PointKey{beam / kColumns, beam % kColumns, plane}));
          ASSERT_EQ(isFinite(scan.position[i]), plane < returnsOfBeam(beam, frame));
          if (isFinite(scan.position[i])) {
            expectPoint(scan, i, beam, plane, 0);
          } else if (!scan[kReturn].empty()) {
            EXPECT_EQ(scan[kReturn][i], 0);
          }
        }
        EXPECT_EQ(withoutMisses(scan).size(), pointsOfFrame(frame));
      }
    }
  }
}

// Draco leaves the misses out; CSV keeps them as rows and does not say that they form an image.
TEST_F(SeveralReturns, OfOrganisedScansAreInFormatsWithoutImagesToo) {
  make({kAllColumns, "output.layout=organised", "output.formats=[draco: {max_error_mm: 2, time: true}, csv]"});
  const std::vector<Scan> draco = scans(".drc");
  const std::vector<Scan> csv = scans(".csv");
  ASSERT_EQ(draco.size(), 4u);
  ASSERT_EQ(csv.size(), 4u);
  for (std::uint32_t frame = 0; frame < 4; ++frame) {
    ASSERT_EQ(draco[frame].size(), pointsOfFrame(frame));
    ASSERT_EQ(csv[frame].size(), 2u * kRings * kColumns);
    for (const Scan& scan : {draco[frame], withoutMisses(csv[frame])}) {
      ASSERT_EQ(scan.size(), pointsOfFrame(frame));
      for (std::size_t i = 0; i < scan.size(); ++i) {
        const PointKey key = keyOf(scan, i);
        expectPoint(scan, i, key.ring * kColumns + key.column, key.number, 2e-3);
      }
    }
  }
}

TEST_F(SeveralReturns, AreCountedInTheManifest) {
  for (const char* layout : {"dense", "organised"}) {
    const GenerateSummary summary =
        make({kAllColumns, fmt::format("output.layout={}", layout)}, fmt::format("counted_{}", layout));
    const Manifest manifest = readManifest(out(fmt::format("counted_{}", layout)));
    EXPECT_THAT(manifest.columns, AllOf(Contains("return"), Contains("cause")));
    EXPECT_THAT(linesOf(manifest.modelled), Contains("two returns: of no scene"));
    ASSERT_EQ(manifest.samples.size(), 4u);
    std::uint64_t points = 0;
    for (std::uint32_t frame = 0; frame < 4; ++frame) {
      const ScanRecord& record = manifest.samples[frame].scans.at(0);
      EXPECT_EQ(record.method, "two_returns");
      EXPECT_EQ(record.beams, kRings * kColumns);
      EXPECT_EQ(record.points, pointsOfFrame(frame));
      EXPECT_GT(record.points, beamsThatReturn(frame));
      EXPECT_EQ(record.instances, scene_.things());
      std::map<std::uint16_t, std::uint64_t> perClass;
      for (std::uint32_t beam = 0; beam < record.beams; ++beam) {
        for (std::uint32_t number = 0; number < returnsOfBeam(beam, frame); ++number) {
          ++perClass[labelOfReturn(scene_.ontology, beam, number)];
        }
      }
      EXPECT_EQ(record.pointsPerClass, perClass);
      points += record.points;
    }
    EXPECT_EQ(summary.points, points);
    EXPECT_EQ(summary.beams, 4u * kRings * kColumns);
  }
}

TEST_F(SeveralReturns, ThreadsDoNotChangeAByte) {
  for (const char* layout : {"dense", "organised"}) {
    const std::vector<std::string> overrides{
        kAllColumns, fmt::format("output.layout={}", layout), "motion={steps: per_column, deskew: true}",
        "output.formats=[pcd, draco: {max_error_mm: 2}, csv]",
        "effects=[intensity: {output: u8}, dropout: {probability: 0.2}, range_noise: {sigma_m: 0.02}, "
        "angular_jitter: {sigma_deg: 0.05}, shell: {scale_m: 0.01}, quantize: {step_m: 0.004}]"};
    std::vector<Bytes> bytes;
    for (const int threads : {1, 8}) {
      const ThreadLimit limit(threads);
      const std::string name = fmt::format("{}{}", layout, threads);
      make(overrides, name);
      bytes.push_back(shards(name));
    }
    EXPECT_TRUE(bytes[0] == bytes[1]) << layout;
  }
}

// What is left of a beam is counted from 1 again, and no key is of two points.
TEST_F(SeveralReturns, ThatAreLostMoveTheOthersUp) {
  make({kAllColumns, "effects=[dropout: {probability: 0.3}]"});
  const std::vector<Scan> all = scans();
  std::size_t moved = 0;
  for (const Scan& scan : all) {
    std::set<std::tuple<std::uint32_t, std::uint32_t, std::uint32_t>> keys;
    for (std::size_t i = 0; i < scan.size(); ++i) {
      const PointKey key = keyOf(scan, i);
      EXPECT_TRUE(keys.emplace(key.ring, key.column, key.number).second);
      if (key.number == 1) {
        EXPECT_TRUE(keys.contains({key.ring, key.column, 0}));
      }
      const std::uint32_t beam = key.ring * kColumns + key.column;
      moved += key.number == 0 && scan[kRangeTrue][i] > rangeOfReturn({}, beam, 0) + 1 ? 1 : 0;
    }
  }
  EXPECT_GT(moved, 20u) << "second returns that are now their beams' first";
}

TEST_F(SeveralReturns, MayBeNone) {
  for (const char* layout : {"dense", "organised"}) {
    const std::string name = fmt::format("none_{}", layout);
    const GenerateSummary summary = make(
        {kAllColumns, "output.formats=[pcd, csv, draco]", fmt::format("output.layout={}", layout)}, name, "{most: 0}");
    EXPECT_EQ(summary.points, 0u);
    EXPECT_THAT(summary.warnings, Contains(HasSubstr("hits nothing")));
    for (const Scan& scan : scans(".pcd", name)) {
      EXPECT_EQ(scan.planes, 1u);
      EXPECT_EQ(scan.size(), scan.organised ? kRings * kColumns : 0u);
    }
  }
}

TEST_F(SeveralReturns, AreOneWhereNoBeamHasMore) {
  make({kAllColumns, "output.layout=organised"}, "one", "{most: 1}");
  for (const Scan& scan : scans(".pcd", "one")) {
    EXPECT_EQ(scan.planes, 1u);
    EXPECT_EQ(scan.height(), kRings);
  }
}

TEST_F(SeveralReturns, FitTheSizeThatThePlanSays) {
  for (const char* layout : {"dense", "organised"}) {
    const std::vector<std::string> overrides{kAllColumns, "effects=[intensity]",
                                             "output.formats=[pcd: {encoding: ascii}, csv, draco]",
                                             fmt::format("output.layout={}", layout)};
    const GenerateSummary summary = make(overrides, layout);
    EXPECT_GE(mostSampleBytes(planned(overrides)) * static_cast<double>(summary.samples),
              static_cast<double>(summary.bytes));
  }
  EXPECT_EQ(planned({}).bytesPerFrameInMemory(), 2 * makePlan(readPipeline(pipeline_, {})).bytesPerFrameInMemory());
}

TEST_F(SeveralReturns, AreNoImagesOfHits) {
  EXPECT_THAT(
      messageOf<InputError>([&] { generate(planned({}), {.folder = out(), .keepHits = out("hits"), .quiet = true}); }),
      AllOf(HasSubstr("yard.yaml: the method two_returns traces several rays per beam"),
            HasSubstr("take `method: ray_tracing`")));
  EXPECT_FALSE(std::filesystem::exists(out()));
}

}  // namespace
}  // namespace scanmill
