// Beams of finite width, from a pipeline to a dataset, by every method.

#include "pipeline/run/run_shot.h"
#include "tests/core/pipeline/small_world.h"
#include "tests/support/gl.h"
#include "tests/support/lines_of.h"

namespace scanmill {
namespace {

const std::string kWide =
    "sensors=[{name: top, columns: 256, rate_hz: 10, elevation_deg: {top: 5, bottom: -25, rings: 16}, range_m: [0.5, "
    "100], mount: {position: [0, 0, 1.8]}, divergence_mrad: 12, pulse_ns: 20}]";
constexpr ColumnKey<columnIndex("returns")> kReturns;
constexpr ColumnKey<columnIndex("label_2")> kLabel2;
constexpr ColumnKey<columnIndex("share")> kShare;
const std::string kWanted =
    "output.columns=[intensity, label, instance, ring, column, range_true, return, returns, cause, label_2, share]";

class FootprintRun : public Yard {
 protected:
  std::vector<std::string> with(const std::string& effects, const std::string& method = "ray_tracing") const {
    return {kWide, kWanted, "effects=" + effects, "method=" + method};
  }
};

// The longer the pulse, the more beams at the cars' edges report a point between car and wall.
TEST_F(FootprintRun, MixesPixelsAtEdges) {
  sound(with("[intensity, footprint: {rays: 19}]"));
  std::size_t mixed = 0;
  std::size_t shared = 0;
  for (const Scan& scan : scans()) {
    for (std::size_t i = 0; i < scan.size(); ++i) {
      const float share = scan[kShare][i];
      EXPECT_GT(share, 0.25f);
      EXPECT_LE(share, 1.0f);
      EXPECT_EQ(scan[kLabel2][i] == 0, share == 1.0f);
      EXPECT_EQ(scan[kReturns][i], 1);
      shared += share < 1 ? 1 : 0;
      mixed += std::abs(length(Vec3d(scan.position[i])) - double{scan[kRangeTrue][i]}) > 0.1 ? 1 : 0;
    }
  }
  EXPECT_GT(mixed, 20u);
  EXPECT_GT(shared, mixed / 2);
}

// The yard with a glass box around the car at y = 5.
TEST_F(FootprintRun, LooksThroughGlass) {
  std::string scene = yardScene();
  scene += R"(  - {name: case, primitive: box, size: [6, 4, 3], position: [8, 5, 1.5], class: building, material: glass}
)";
  folder_.write("scenes/yard.yaml", scene);
  const std::vector<std::string> clear = with("[intensity, light_paths: {bounces: 0}, detection: {returns: all}]");
  const Manifest through = sound(clear, "clear");
  const Manifest opaque = sound(with("[intensity]"), "opaque");
  std::size_t behind = 0;
  std::size_t carBehind = 0;
  for (const Scan& scan : scans(".pcd", "clear")) {
    for (std::size_t i = 0; i < scan.size(); ++i) {
      const bool glass = scan[kCause][i] == static_cast<std::uint8_t>(Reason::ThroughGlass);
      behind += glass ? 1 : 0;
      carBehind += glass && std::abs(scan.position[i].z + 1.8f) < 1.51f && scan[kInstance][i] != 0 ? 1 : 0;
    }
  }
  EXPECT_GT(behind, 500u);
  EXPECT_GT(carBehind, 100u);
  for (const Scan& scan : scans(".pcd", "opaque")) {
    for (const std::uint8_t cause : scan[kCause]) EXPECT_EQ(cause, 1);
  }
  EXPECT_THAT(linesOf(through.modelled),
              Contains("parts that let light through: beams continue behind them (1 in a scene)"));
  EXPECT_THAT(linesOf(opaque.modelled),
              AllOf(Contains("parts that let light through: left out, opaque here (1 in a scene)"),
                    Contains(HasSubstr("light through glass and off mirrors: left out"))));
  EXPECT_THAT(refusal(with("[intensity, light_paths: {}]", "depth_camera")),
              AllOf(HasSubstr("depth_camera ends each ray"), HasSubstr("`method: ray_tracing`")));
}

// A recording of hits holds one ray a beam: sensors' own effects stay usable, and the plan says what is left out.
TEST_F(FootprintRun, IsLeftOutOfRecordings) {
  generate(planOf(with("[intensity]")), {.folder = out("kept"), .keepHits = out("hits"), .quiet = true});
  const Plan plan = makePlan(
      readPipeline(pipeline_, with("[intensity, footprint: {rays: 7}, light_paths: {}]"), recordingIn(out("hits"))));
  EXPECT_THAT(linesOf(modelled(plan, {})), Contains("effect footprint: left out, a recording holds one ray per beam"));
  EXPECT_EQ(plan.pipeline.raysPerFrame(), plan.pipeline.beamsPerFrame());
  EXPECT_THAT(generate(plan, {.folder = out("again"), .quiet = true}).warnings,
              testing::ElementsAre(HasSubstr("one ray per beam")));
  EXPECT_EQ(scans(".pcd", "again").size(), scans(".pcd", "kept").size());
  EXPECT_EQ(scans(".pcd", "again")[0].position, scans(".pcd", "kept")[0].position);
}

TEST_F(FootprintRun, IsRefusedWhereItMeansNothing) {
  EXPECT_THAT(refusal({"effects=[intensity, footprint: {rays: 7}]"}), HasSubstr("divergence_mrad"));
  EXPECT_THAT(refusal(with("[footprint: {rays: 7}]")), AllOf(HasSubstr("intensity"), HasSubstr("detection")));
  EXPECT_THAT(refusal(with("[intensity, range_noise: {over_snr_m: 1}]")), HasSubstr("detection: {noise"));
  EXPECT_THAT(messageOf([&] { planOf(with("[intensity, footprint: {rays: 7}]")).requireOneRay(); }),
              HasSubstr("footprint"));
  EXPECT_EQ(planOf(with("[intensity, footprint: {rays: 7}]")).pipeline.raysPerFrame(), 7u * 16u * 256u);
}

}  // namespace
}  // namespace scanmill
