// Beams with two returns, one or none, all the way from a method to a dataset.

#include <set>
#include <tuple>

#include "formats/format.h"
#include "tests/core/pipeline/two_returns_yard.h"
#include "tests/support/lines_of.h"

namespace scanmill {
namespace {

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

  // The points of a frame, each once, whatever misses stand between them; `numbered`: the keys know the return.
  void expectPoints(const Scan& scan, std::uint32_t frame, double maxError, bool numbered) const {
    std::set<std::tuple<std::uint32_t, std::uint32_t, std::uint32_t>> seen;
    std::map<std::uint32_t, std::uint32_t>
        before;  // returns of a beam, which dense scans without numbers have in order
    for (std::uint32_t i = 0; i < scan.size(); ++i) {
      if (!isFinite(scan.position[i])) continue;
      const PointKey key = keyOf(scan, i);
      const std::uint32_t beam = key.ring * kColumns + key.column;
      const std::uint32_t number = numbered ? key.number : before[beam]++;
      EXPECT_TRUE(seen.emplace(key.ring, key.column, number).second);
      ASSERT_LT(number, returnsOfBeam(beam, frame));
      expectPoint(scan, i, beam, number, maxError);
    }
    EXPECT_EQ(seen.size(), pointsOfFrame(frame));
  }

  Scene scene_ = scene();
};

TEST_F(SeveralReturns, AreInEveryFormatOfEveryLayout) {
  for (const bool organised : {false, true}) {
    for (const char* columns : {kAllColumns, kWithoutReturn}) {
      SCOPED_TRACE(columns);
      const bool numbered = organised || columns == kAllColumns;
      const std::string name = fmt::format("{}{}", organised, numbered && columns == kAllColumns);
      make({columns, "effects=[intensity]", fmt::format("output.layout={}", organised ? "organised" : "dense"),
            "output.formats=[pcd, csv, draco: {max_error_mm: 2, time: true}]"},
           name);
      for (const char* suffix : {".pcd", ".csv", ".drc"}) {
        const std::vector<Scan> all = scans(suffix, name);
        ASSERT_EQ(all.size(), 4u);
        for (std::uint32_t frame = 0; frame < 4; ++frame) {
          const bool draco = std::string(suffix) == ".drc";
          if (organised && !draco && columns == kWithoutReturn && std::string(suffix) == ".csv") continue;
          expectPoints(all[frame], frame, draco ? 2e-3 : 0, numbered && (columns == kAllColumns || !draco));
          // Draco leaves the misses out; CSV keeps them as rows and does not say that they form an image.
          EXPECT_EQ(all[frame].size(), organised && !draco ? 2u * kRings * kColumns : pointsOfFrame(frame));
          EXPECT_EQ(all[frame].planes, organised && std::string(suffix) == ".pcd" ? 2u : 1u);
        }
      }
    }
  }
}

TEST_F(SeveralReturns, MayBeOneOrNone) {
  for (const std::uint32_t most : {0u, 1u}) {
    for (const bool organised : {false, true}) {
      const std::string name = fmt::format("most{}{}", most, organised);
      const GenerateSummary summary = make({kAllColumns, "output.formats=[pcd, csv, draco]",
                                            fmt::format("output.layout={}", organised ? "organised" : "dense")},
                                           name, fmt::format("{{most: {}}}", most));
      EXPECT_EQ(summary.points > 0, most > 0);
      EXPECT_EQ(summary.warnings.empty(), most > 0) << "hits nothing";
      for (const Scan& scan : scans(".pcd", name)) {
        EXPECT_EQ(scan.planes, 1u);
        EXPECT_EQ(scan.height(), organised ? kRings : 1u);
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

}  // namespace
}  // namespace scanmill
