#include <set>

#include "pipeline/checks/warnings.h"
#include "pipeline/scenes/shot_source.h"
#include "tests/core/pipeline/small_world.h"
#include "tests/support/lines_of.h"

namespace scanmill {
namespace {

constexpr ColumnKey<columnIndex("elevation")> kElevation;

// A roof 0.3 m below the sensor, 2 m long and 1.6 m wide, and far behind it a trailer.
class EgoVehicle : public Yard {
 protected:
  EgoVehicle() {
    folder_.write("scenes/roof.yaml", fmt::format(R"(ontology: {0}/labels/scanmill.yaml
materials: {0}/labels/materials.yaml
objects:
  - {{name: roof, primitive: box, size: [2, 1.6, 0.5], position: [0, 0, 1.25], class: truck, material: concrete}}
)",
                                                  SCANMILL_SOURCE_DIR));
  }

  std::vector<std::string> with(std::vector<std::string> more = {}) const {
    more.emplace_back("vehicle=scenes/roof.yaml");
    more.emplace_back("output.columns=[intensity, label, instance, ring, column, range_true, cause, elevation]");
    return more;
  }
};

// `returns: drop` leaves out the returns of the vehicle, and nothing else.
TEST_F(EgoVehicle, DroppedReturns) {
  sound(with({"effects=[intensity]"}), "kept");
  std::vector<std::string> dropping = with({"effects=[intensity]"});
  dropping.emplace_back("vehicle={scene: scenes/roof.yaml, returns: drop}");
  sound(dropping, "dropped");
  const std::vector<Scan> kept = scans(".pcd", "kept");
  const std::vector<Scan> dropped = scans(".pcd", "dropped");
  for (std::size_t s = 0; s < kept.size(); ++s) {
    const auto rows = rowsByBeam(dropped[s]);
    std::size_t others = 0;
    for (std::size_t i = 0; i < kept[s].size(); ++i) {
      const bool roof = kept[s][kCause][i] == static_cast<std::uint8_t>(Reason::EgoVehicle);
      const auto row = rows.find({kept[s][kRing][i], kept[s][kColumn][i]});
      EXPECT_EQ(row == rows.end(), roof);
      if (roof || row == rows.end()) continue;
      ++others;
      EXPECT_EQ(dropped[s].position[row->second], kept[s].position[i]);
    }
    EXPECT_EQ(dropped[s].size(), others);
    EXPECT_LT(others + 50, kept[s].size());
  }
}

// Where a beam is steep enough, it ends on the roof at 0.3 m over the sine of its angle; all other points stay.
TEST_F(EgoVehicle, BlocksAndReturns) {
  for (const std::string motion : {"none", "per_column"}) {
    sound(with({"motion=" + motion, "effects=[intensity]"}), "with" + motion);
    sound({"motion=" + motion, "effects=[intensity]"}, "without" + motion);
    const std::vector<Scan> blocked = scans(".pcd", "with" + motion);
    const std::vector<Scan> open = scans(".pcd", "without" + motion);
    std::size_t roof = 0;
    for (std::size_t s = 0; s < blocked.size(); ++s) {
      const auto rows = rowsByBeam(open[s]);
      for (std::size_t i = 0; i < blocked[s].size(); ++i) {
        const Scan& scan = blocked[s];
        if (scan[kCause][i] == static_cast<std::uint8_t>(Reason::EgoVehicle)) {
          ++roof;
          EXPECT_NEAR(scan[kRangeTrue][i], 0.3 / std::sin(-double{scan[kElevation][i]}), 1e-5);
          EXPECT_EQ(scan[kInstance][i], 0u);
          EXPECT_GT(scan[kIntensity][i], 0);
          EXPECT_LE(std::abs(scan.position[i].x), 1.0001f);
          EXPECT_LE(std::abs(scan.position[i].y), 0.8001f);
          continue;
        }
        const std::size_t k = rows.at({scan[kRing][i], scan[kColumn][i]});
        EXPECT_EQ(scan.position[i], open[s].position[k]);
        EXPECT_EQ(scan[kIntensity][i], open[s][kIntensity][k]);
      }
    }
    EXPECT_GT(roof, 200u);
  }
}

// The beams of a rosette differ from revolution to revolution, and so do those that end on the roof.
TEST_F(EgoVehicle, IsSeenByARosette) {
  const std::string rosette =
      "sensors=[{name: top, rosette: {field_deg: 80, turns_hz: [121, -77.7]}, columns: 2000, rate_hz: 10, "
      "range_m: [0.1, 100], mount: {position: [0, 0, 1.8], pitch_deg: 50}}]";
  sound(with({rosette, "effects=[intensity]"}), "with");
  sound({rosette, "effects=[intensity]", "output.columns=[column]"}, "without");
  const Pose vehicleFromSensor = planOf({rosette}).pipeline.sensors[0].vehicleFromSensor;
  std::set<std::vector<std::uint16_t>> blocked;
  for (std::size_t s = 0; s < 4; ++s) {
    const Scan seen = scans(".pcd", "with")[s];
    const Scan open = scans(".pcd", "without")[s];
    std::vector<std::uint16_t> own;
    for (std::size_t i = 0; i < seen.size(); ++i) {
      if (seen[kCause][i] == 5) {
        own.push_back(seen[kColumn][i]);
        EXPECT_NEAR((vehicleFromSensor * Vec3d(seen.position[i])).z, 1.5, 1e-5);
        continue;
      }
      const auto same = std::find(open[kColumn].begin(), open[kColumn].end(), seen[kColumn][i]);
      ASSERT_NE(same, open[kColumn].end());
      EXPECT_EQ(seen.position[i], open.position[static_cast<std::size_t>(same - open[kColumn].begin())]);
    }
    EXPECT_GT(own.size(), 200u);
    EXPECT_LT(own.size(), seen.size());
    blocked.insert(own);
  }
  EXPECT_EQ(blocked.size(), 4u);
}

TEST_F(EgoVehicle, IsWarnedOfWhereASensorSeesNothingElse) {
  const auto warnings = [&](const std::string& sensors) {
    const Plan plan = planOf(with({"effects=[]", "sensors=[" + sensors + "]"}));
    return vehicleWarnings(plan.pipeline, ShotSource(plan).blockedShares());
  };
  const std::string inside =
      std::string(kTop).replace(kTop.find("[0, 0, 1.8]"), 11, "[0, 0, 1.2]").replace(7, 3, "low");
  EXPECT_THAT(warnings(kTop), IsEmpty());
  EXPECT_THAT(warnings(kTop + ", " + inside),
              ElementsAre(AllOf(HasSubstr("100 %"), HasSubstr("'low'"), HasSubstr("[0, 0, 1.2]"))));
}

// What is nearer than the sensor reports is a gap, not a point.
TEST_F(EgoVehicle, LeavesGapsWhereItIsTooNear) {
  const std::string blind = std::string(kTop).replace(kTop.find("[0.5, 100]"), 10, "[2.5, 100]");
  sound(with({"sensors=[" + blind + "]"}), "with");
  sound({"sensors=[" + blind + "]"}, "without");
  std::size_t lost = 0;
  for (std::size_t s = 0; s < 4; ++s) {
    const Scan scan = scans(".pcd", "with")[s];
    for (const std::uint8_t cause : scan[kCause]) EXPECT_EQ(cause, 1);
    lost += scans(".pcd", "without")[s].size() - scan.size();
  }
  EXPECT_GT(lost, 200u);
}

TEST_F(EgoVehicle, BlocksTheRaysOfFootprintsAndBehindGlass) {
  const std::string wide = std::string(kTop).insert(1, "divergence_mrad: 20, pulse_ns: 5, ");
  sound(with({"sensors=[" + wide + "]", "effects=[intensity, footprint: {rays: 19}, light_paths: {}]"}));
  std::size_t roof = 0;
  for (const Scan& scan : scans()) {
    for (const std::uint8_t cause : scan[kCause]) roof += cause == 5 ? 1 : 0;
  }
  EXPECT_GT(roof, 200u);
}

TEST_F(EgoVehicle, IsPlannedAndRefusedWhereItMeansNothing) {
  const Plan planned = planOf(with());
  const auto lines = linesOf(modelled(planned, ShotSource(planned).blockedShares()));
  EXPECT_THAT(lines, Contains(HasSubstr("own vehicle: roof.yaml, blocks")));
  EXPECT_THAT(messageOf([&] { planOf(with()).requireOneRay(); }), HasSubstr("vehicle"));
  EXPECT_THAT(messageOf([&] { readPipeline(pipeline_, {"vehicle=scenes/none.yaml"}); }), HasSubstr("none.yaml"));
}

}  // namespace
}  // namespace scanmill
