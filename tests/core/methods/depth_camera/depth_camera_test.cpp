#include "methods/depth_camera/depth_camera.h"

#include <fmt/core.h>

#include "sensors/sensor.h"
#include "tests/core/methods/depth_camera/worlds.h"
#include "tests/support/blender.h"
#include "tests/support/lines_of.h"
#include "tests/support/message_of.h"
#include "tests/support/ray_scenes.h"
#include "tests/support/temporary_folder.h"

namespace scanmill {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

std::shared_ptr<const BeamTable> shipped(const std::string& name) {
  const Value value = readYaml(std::filesystem::path(SCANMILL_SOURCE_DIR "/pipelines/sensors") / (name + ".yaml"));
  return makeBeams(value);
}

TEST(DepthCamera, IsExactInAClosedRoom) {
  const Scene scene = room();
  const auto beams = spinning(32, 512, -60, 70);
  for (const char* layout : {"auto", "cube_6"}) {
    SCOPED_TRACE(layout);
    const Shot shot = shotAt(beams, {fromYawPitchRoll(0.2, 0.1, -0.3), {1, 0.5, 0.2}});
    const Hits truth = traced(scene, shot);
    const Hits hits = photographed(scene, shot, "{resolution: 512, layout: " + std::string(layout) + "}");
    for (std::size_t i = 0; i < hits.size(); ++i) ASSERT_TRUE(hits.hit(i)) << i;
    const std::vector<double> errors = relativeErrors(truth, hits);
    EXPECT_GT(errors.size(), hits.size() * 97 / 100);
    EXPECT_LT(largest(errors), 1e-5);
  }
}

TEST(DepthCamera, GrazesTheGroundTo200Metres) {
  const Scene scene = flatGround({0, 0, -1.7}, 2000, 5);
  std::vector<Vec3d> directions;
  for (int i = 0; i < 200; ++i) {
    const double distance = 3 + i * 0.985;
    for (int k = 0; k < 12; ++k) {
      const double azimuth = 0.5236 * k + 0.001 * i;
      directions.push_back({distance * std::cos(azimuth), distance * std::sin(azimuth), -1.7});
    }
  }
  const Shot shot = shotAt(beamsOf(directions, 0, 400));
  const Hits hits = photographed(scene, shot, "{resolution: 1024}");
  for (std::size_t i = 0; i < directions.size(); ++i) {
    const double expected = length(directions[i]);
    ASSERT_NEAR(hits.range[i], expected, 1e-5 * expected) << expected;
  }
}

TEST(DepthCamera, SeesTheMaterialsThatRayTracingSees) {
  const Scene scene = room();
  const Shot shot = shotAt(spinning(32, 512, -40, 40));
  const Hits truth = traced(scene, shot);
  const Hits hits = photographed(scene, shot, "{resolution: 512}");
  std::size_t same = 0;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    if (truth.primitive[i] != hits.primitive[i] || truth.instance[i] != hits.instance[i]) continue;
    ++same;
    EXPECT_EQ(hits.reflectance[i], truth.reflectance[i]);
    EXPECT_EQ(hits.material[i], truth.material[i]);
    EXPECT_EQ(hits.semantic[i], truth.semantic[i]);
    EXPECT_NEAR(hits.incidence[i], truth.incidence[i], 1e-6);
    EXPECT_NEAR(hits.normal[i].x, truth.normal[i].x, 1e-6);
  }
  EXPECT_GT(same, truth.size() * 96 / 100);
}

TEST(DepthCamera, DrawnAndSampledLaterGivesTheSameBytes) {
  const Scene scene = yard();
  const auto beams = spinning(24, 360, -25, 5, 120);
  const Value none = parseYaml("{}", "options");
  for (const char* options :
       {"{resolution: 256}", "{resolution: 256, layout: three_120, sampling: nearest, depth: half_500}",
        "{resolution: 256, renders_per_turn: 5}"}) {
    SCOPED_TRACE(options);
    for (const Shot& shot : {shotAt(beams, {fromYawPitchRoll(0.3, 0, 0), {1, 2, 0}}), moving(beams, 12, 1, 4)}) {
      const auto camera = depthCamera(scene, options);
      const Hits direct = traced(*camera, shot);
      const Value value = parseYaml(options, "options");
      Fields fields = depthFields(value);
      const auto sampler = makePassSampler(fields);
      Hits later;
      later.reset(beams->rings, beams->columns, Channels::all());
      Hits elsewhere = later;
      std::uint32_t next = 0;
      camera->draw(shot, camera->passes(Channels::all()), [&](PassStep&& step) {
        EXPECT_EQ(step.firstColumn, next);
        next = step.endColumn;
        camera->sample(shot, step, later);
        sampler->sample(shot, step, elsewhere);
      });
      EXPECT_EQ(next, beams->columns);
      expectSameHits(later, direct);
      expectSameHits(elsewhere, direct);
    }
  }
}

TEST(DepthCamera, MovingSensorsStayExactOnFlatSurfaces) {
  const Scene scene = room();
  const auto beams = spinning(24, 512, -40, 40);
  for (const char* renders : {"auto", "1", "7"}) {
    SCOPED_TRACE(renders);
    const Shot shot = moving(beams, 512, 1.5, 8);
    const Hits truth = traced(scene, shot);
    const Hits hits = photographed(scene, shot, "{resolution: 512, renders_per_turn: " + std::string(renders) + "}");
    const std::vector<double> errors = relativeErrors(truth, hits);
    // One render for all: 0.75 m from the farthest columns, the box hides some of the room.
    EXPECT_GT(errors.size(), truth.size() * (renders[0] == '1' ? 93 : 97) / 100);
    EXPECT_LT(largest(errors), 1e-5);
  }
}

TEST(DepthCamera, RendersFollowTheMotion) {
  const Scene scene = yard();
  const auto beams = spinning(4, 360, -20, 0, 120);
  const auto renders = [&](const Shot& shot, const std::string& options) {
    EmbreePasses* renderer = nullptr;
    const auto camera = depthCamera(scene, "{resolution: 128, renders_per_turn: " + options + "}", &renderer);
    traced(*camera, shot, Channel::Range);
    return renderer->draws();
  };
  EXPECT_EQ(renders(shotAt(beams), "auto"), 1u);
  EXPECT_EQ(renders(shotAt(beams), "40"), 1u) << "a sensor that stands still needs one";
  EXPECT_EQ(renders(moving(beams, 10, 0), "auto"), 10u) << "as many as motion has steps";
  EXPECT_EQ(renders(moving(beams, 10, 5), "4"), 4u);
  EXPECT_EQ(renders(moving(beams, 10, 5), "50"), 10u) << "at most one per pose";
  EXPECT_EQ(renders(moving(beams, 360, 0.498), "auto"), 10u) << "one for each 5 cm";
  EXPECT_EQ(renders(moving(beams, 360, 0, 12), "auto"), 12u) << "or degree";
}

TEST(DepthCamera, StepsDrawOnlyWhatTheirColumnsSee) {
  const Scene scene = yard();
  EmbreePasses* renderer = nullptr;
  const auto camera = depthCamera(scene, "{resolution: 512}", &renderer);
  const auto beams = spinning(32, 720, -25, 5, 120);
  traced(*camera, shotAt(beams), Channel::Range);
  const std::size_t whole = renderer->drawnPixels();
  traced(*camera, moving(beams, 36, 0.5), Channel::Range);
  EXPECT_LT(renderer->drawnPixels(), whole / 12) << "a 36th of the revolution and the margins";
}

TEST(DepthCamera, FollowsOriginsOffTheAxis) {
  const Scene scene = room();
  const auto beams = shipped("os1_128");
  ASSERT_FALSE(beams->origin.empty());
  const Shot shot = shotAt(beams, {{}, {0, 0.3, 0.4}});
  const Hits truth = traced(scene, shot);
  const auto camera = depthCamera(scene, "{resolution: 1024}");
  Hits hits;
  EXPECT_TRUE(camera->trace(shot, Channels::all(), hits).warnings.empty());
  const std::vector<double> errors = relativeErrors(truth, hits);
  EXPECT_GT(errors.size(), truth.size() * 98 / 100);
  EXPECT_LT(largest(errors), 1e-5);
}

TEST(DepthCamera, CountsBeamsThatNoImageSees) {
  const Scene scene = room();
  const auto beams = spinning(3, 360, -60, 60);  // -60, 0 and 60 degrees
  const Shot shot = shotAt(beams);
  // At 60 degrees up, a 120 degree image is left at once, off its axis: tan(60) cos(a) < tan(60).
  const auto three = depthCamera(scene, "{resolution: 256, layout: three_120}");
  Hits hits;
  TraceAccount account = three->trace(shot, Channels::all(), hits);
  std::size_t misses = 0;
  for (std::size_t i = 0; i < hits.size(); ++i) misses += hits.hit(i) ? 0 : 1;
  EXPECT_NEAR(static_cast<double>(misses), 2 * 360, 6);
  account += three->trace(shot, Channels::all(), hits);
  EXPECT_THAT(account.warningTexts(),
              ElementsAre(fmt::format("{} of 1080 beams of 'lidar' are outside all images of layout three_120 and "
                                      "count as misses: take `layout: auto`",
                                      misses)));
  const auto cameras = depthCamera(scene, "{resolution: 256}");
  EXPECT_TRUE(cameras->trace(shot, Channels::all(), hits).warnings.empty());
  for (std::size_t i = 0; i < hits.size(); ++i) EXPECT_TRUE(hits.hit(i));
  // A layout none of whose images sees any beam.
  const Hits none = photographed(scene, shotAt(beamsOf({{0, 0, 1}})), "{layout: four_90, resolution: 128}");
  EXPECT_EQ(none.range[0], kMiss);
}

TEST(DepthCamera, NearAndFarBoundWhatIsDrawn) {
  const Scene scene = wallsAhead({0.5, 50});
  const auto range = [&](const std::string& options, double minRange = 0) {
    return photographed(scene, shotAt(beamsOf({{1, 0, 0}}, minRange, 100)), options).range[0];
  };
  EXPECT_NEAR(range("{}"), 0.5, 1e-6);
  EXPECT_NEAR(range("{near_m: 0.001}"), 0.5, 1e-6);
  EXPECT_EQ(range("{}", 1), kMiss) << "the near wall blocks";
  EXPECT_NEAR(range("{near_m: 0.8}"), 50, 1e-4) << "not drawn, it does not block";
  EXPECT_EQ(range("{near_m: 0.8, far_m: 49}"), kMiss);
  EXPECT_NEAR(range("{near_m: 0.8, far_m: 10000}"), 50, 1e-4);
  EXPECT_NEAR(range("{near_m: 1, depth: uint16, far_m: 60}"), 50, 50 * 50 / 65536.0);
}

TEST(DepthCamera, PlanningMakesNoRenderer) {
  const Scene scene = yard();
  const Value value = parseYaml("{depth: uint16, layout: cube_6}", "options");
  Fields fields = depthFields(value);
  const auto camera = makeDepthCamera(scene, fields, []() -> std::unique_ptr<PassRenderer> { throw Error("no GPU"); });
  const std::vector<std::string> lines = linesOf(camera->modelled());
  EXPECT_THAT(lines, testing::Contains(HasSubstr("layout cube_6")));
  EXPECT_THAT(lines, testing::Contains(HasSubstr("depth uint16")));
  EXPECT_GT(camera->memoryBytes(), 2048u * 2048 * 6);
  EXPECT_THAT(lines, testing::Not(testing::Contains(HasSubstr("were drawn by"))));
  Hits hits;
  EXPECT_EQ(messageOf<Error>([&] { camera->trace(shotAt(beamsOf({{1, 0, 0}})), Channel::Range, hits); }), "no GPU");
}

TEST(DepthCamera, PlansSayWhetherBlenderIsThere) {
  const Scene scene = yard();
  const auto planned = [&](const std::string& options) {
    const Value value = parseYaml(options, "options");
    Fields fields = depthFields(value);
    return linesOf(makeDepthCamera(scene, fields)->modelled());
  };
  const TemporaryFolder folder;
  const std::string program = folder.write("blender", "#!/bin/sh\n").string();
  const ScopedVariable absent("SCANMILL_BLENDER", program);
  EXPECT_THAT(planned("{renderer: blender}"), testing::Contains(HasSubstr("Blender: not found: SCANMILL_BLENDER")));
  EXPECT_THAT(planned("{renderer: vtk}"), testing::Not(testing::Contains(HasSubstr("Blender"))));
  std::filesystem::permissions(program, std::filesystem::perms::owner_all);
  EXPECT_THAT(planned("{renderer: blender}"), testing::Contains("Blender: " + program));
}

TEST(DepthCamera, StagesAreTimedApart) {
  const Scene scene = yard();
  const auto camera = depthCamera(scene, "{resolution: 256}");
  Hits hits;
  const StageSeconds seconds = camera->trace(shotAt(spinning(16, 512, -25, 5)), Channels::all(), hits).seconds;
  for (const char* stage : {"render", "read_back", "sample"}) EXPECT_GT(seconds.at(stage), 0) << stage;
}

TEST(DepthCamera, RefusesSenselessOptions) {
  const Scene scene = yard();
  const auto refused = [&](const std::string& options, const std::vector<std::string>& words) {
    SCOPED_TRACE(options);
    expectInputError([&] { depthCamera(scene, options); }, words);
  };
  refused("{resolution: 64}", {"resolution", "128"});
  refused("{resolution: 5000}", {"resolution", "4096"});
  refused("{sampling: planes}", {"sampling", "did you mean 'plane'"});
  refused("{layout: three}", {"layout"});
  refused("{depth: float16}", {"depth"});
  refused("{near_m: 2}", {"near_m"});
  refused("{near_m: 0}", {"near_m"});
  refused("{far_m: 5}", {"far_m"});
  refused("{renders_per_turn: 0}", {"renders_per_turn"});
  refused("{renders_per_turn: often}", {"renders_per_turn"});
  refused("{renderer: opengl}", {"renderer"});
  refused("{fov: 90}", {"unknown key", "fov"});
  EXPECT_EQ(requireMethod("depth_camera", {}).name, "depth_camera");
}

TEST(DepthCamera, PassesOfOtherColumnsAreRefused) {
  const Value value = parseYaml("{}", "options");
  Fields fields = depthFields(value);
  const auto sampler = makePassSampler(fields);
  Hits hits;
  const Shot shot = shotAt(spinning(2, 8, -5, 5));
  hits.reset(2, 8, Channel::Range);
  sampler->prepare(shot);
  expectInputError([&] { sampler->sample(shot, {0, 9, {}, {}}, hits); }, {"0 to 9", "8 columns", "lidar"});
  EXPECT_THAT(messageOf<Error>([&] { sampler->trace(shot, Channel::Range, hits); }), HasSubstr("from files"));
}

}  // namespace
}  // namespace scanmill
