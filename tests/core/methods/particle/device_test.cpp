// Particles that a device launches and flies give the processor's bytes.

#include <memory>
#include <string>
#include <vector>

#include "base/random.h"
#include "methods/gpu/gl_marcher.h"
#include "methods/particle/field_store.h"
#include "methods/particle/particles.h"
#include "tests/core/methods/trace.h"
#include "tests/support/gl.h"
#include "tests/support/message_of.h"
#include "tests/support/same_hits.h"
#include "tests/support/street.h"
#include "tests/support/test_scene.h"

namespace scanmill {
namespace {

void expectTheProcessorsBytes(const Scene& scene, const Shot& shot, const std::string& options) {
  SCOPED_TRACE(options);
  const auto here = methodOf("particle", scene, "{backend: cpu, " + options + "}");
  const auto there = methodOf("particle", scene, "{backend: gl, " + options + "}");
  expectSameHits(traced(*there, shot), traced(*here, shot));
}

TEST(ParticlesOnADevice, GiveTheProcessorsBytes) {
  SKIP_WITHOUT_GL();
  const Scene street = proceduralStreet();
  const Shot shot = streetShot(spinning(16, 500, -25, 5, 60), -20);  // the last columns lack particles
  for (const char* refine : {"none", "triangle"}) {
    expectTheProcessorsBytes(street, shot, std::string("voxel_m: 0.2, voxels: 128, refine: ") + refine);
  }
}

// What a device makes of a shot by itself.
struct Made {
  Hits hits;
  std::vector<UnresolvedRay> undecided;
  StageClock clock;
};

std::unique_ptr<Made> madeOf(const Scene& scene, const Shot& shot, const ParticleOptions& options,
                             const GlMarcherLimits& limits = {}) {
  auto made = std::make_unique<Made>();
  const FieldStore fields(scene, options);
  StageClock ignored;
  const SensorField around = fields.around(shot.worldFromSensor.front().translation, shot.beams->maxRange, ignored);
  const ShotFrame frame = frameOf(shot, around.world->origin);
  made->hits.reset(shot.beams->rings, shot.beams->columns, Channels::all());
  GlMarcher marcher(limits);
  EXPECT_FALSE(marcher.device().empty());
  marcher.march({shot, frame, around, options.steps}, made->hits, made->undecided, made->clock);
  return made;
}

// How many of a shot's particles end so on the device.
std::size_t endsOf(const Scene& scene, const Shot& shot, const ParticleOptions& options, UnresolvedReason reason) {
  const auto made = madeOf(scene, shot, options);
  return static_cast<std::size_t>(std::count_if(made->undecided.begin(), made->undecided.end(),
                                                [&](const UnresolvedRay& ray) { return ray.reason == reason; }));
}

ParticleOptions smallOptions(ParticleOptions::Refine refine) {
  ParticleOptions options;
  options.voxel = 0.2;
  options.voxels = 128;
  options.refine = refine;
  return options;
}

// However many march at once; beams that do not fit are refused.
TEST(ParticlesOnADevice, SlicesDoNotMatter) {
  SKIP_WITHOUT_GL();
  const auto fill = [](Mesh& mesh) {
    appendPlane(mesh, 0, at(0, 0, -2), 100, 100, 9);
    appendSphere(mesh, 0, at(6, 1, -1), 1, 16);
  };
  const Scene scene = oneMeshScene("ground", fill);
  const Shot shot = shotAt(spinning(6, 50, -25, 5, 60));
  using enum ParticleOptions::Refine;
  for (const auto refine : {None, ByTriangle}) {
    const auto whole = madeOf(scene, shot, smallOptions(refine));
    for (const char* stage : {"upload", "march", "read_back"}) EXPECT_GT(whole->clock.seconds().at(stage), 0) << stage;
    for (const std::size_t slice : {1u, 37u, 384u}) {
      const auto some = madeOf(scene, shot, smallOptions(refine), {.particles = slice});
      ASSERT_EQ(some->undecided.size(), whole->undecided.size());
      for (const UnresolvedRay& ray : whole->undecided) {  // their other columns mean nothing
        for (Hits* hits : {&some->hits, &whole->hits}) hits->range[ray.ray] = kMiss;
      }
      EXPECT_EQ(some->hits.range, whole->hits.range);
      EXPECT_EQ(some->hits.instance, whole->hits.instance);
    }
  }
  EXPECT_THAT(messageOf<Error>([&] {
                madeOf(scene, shotAt(spinning(1000, 1000, -20, 20)), smallOptions(None),
                       {.device = {.bufferBytes = 30'000'000}});
              }),
              testing::HasSubstr("the sensor has too many beams for a buffer"));
}

// Rounding of quotients rarely decides anything: markings that lie as high as layers may be are the most of it.
TEST(ParticlesOnADevice, LeaveLittleToTheProcessor) {
  SKIP_WITHOUT_GL();
  const Scene street = proceduralStreet();
  const Shot shot = streetShot(spinning(64, 1024, -25, 5, 60), -20);
  using enum ParticleOptions::Refine;
  for (const auto refine : {None, ByTriangle}) {
    EXPECT_LT(endsOf(street, shot, smallOptions(refine), UnresolvedReason::Rounding), shot.beams->size() / 500)
        << static_cast<int>(refine);
  }
  ParticleOptions options = smallOptions(ByTriangle);
  options.steps = 5;
  EXPECT_GT(endsOf(street, shot, options, UnresolvedReason::StepsUsedUp), shot.beams->size() / 2);
}

// Beams that leave the field, poses that change, beams with origins of their own, a sensor that looks along an axis.
TEST(ParticlesOnADevice, WhereverTheyStart) {
  SKIP_WITHOUT_GL();
  const Scene street = proceduralStreet();
  auto beams = std::make_shared<BeamTable>(*spinning(9, 100, -20, 20, 80));
  for (std::size_t i = 0; i < beams->size(); ++i) {
    beams->origin.push_back({0.1f, 0.01f * static_cast<float>(i % 50), -0.2f});
  }
  beams->direction[0] = {1, 0, 0};
  beams->direction[1] = {0, 0, -1};
  Shot shot = streetShot(beams, 10);
  for (int step = 1; step < 7; ++step) {
    shot.worldFromSensor.push_back({fromYawPitchRoll(0.02 * step, 0.01, 0), {10 + 0.3 * step, -1.75, 1.9}});
  }
  for (const char* refine : {"none", "triangle"}) {
    expectTheProcessorsBytes(street, shot, std::string("voxel_m: 0.2, voxels: 128, levels: 2, refine: ") + refine);
  }
}

TEST(ParticlesOnADevice, PassTheSameHoles) {
  SKIP_WITHOUT_GL();
  SceneBuilder builder = testBuilder();
  Material leaf;
  leaf.name = "leaf";
  leaf.alphaTested = true;
  auto texture = std::make_shared<Texture>();
  texture->width = 31;
  texture->height = 17;
  texture->hasAlpha = true;
  for (std::uint32_t i = 0; i < texture->width * texture->height; ++i) {
    const auto alpha = static_cast<std::uint8_t>(randomBlock({.beam = i, .purpose = Purpose::Test})[0] & 255u);
    texture->rgba.insert(texture->rgba.end(), {10, 200, 30, alpha});
  }
  leaf.texture = texture;
  Mesh curtain;
  curtain.surfaces.push_back({builder.addMaterial(leaf), 2, 1, "", "", {}});
  appendQuad(curtain, 0, {0, 5, -5}, {0, -5, -5}, {0, -5, 5}, {0, 5, 5});
  curtain.uvs = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  const std::uint32_t mesh = builder.addMesh(std::move(curtain));
  for (int i = 0; i < 3; ++i) builder.place(mesh, at(4.0 + i, 0.3 * i, 0), "curtain");
  Mesh wall = meshOf(builder, "ground");
  appendQuad(wall, 0, {9, 20, -20}, {9, -20, -20}, {9, -20, 20}, {9, 20, 20});
  builder.place(builder.addMesh(wall), {}, "wall");
  const Scene scene = builder.finish();
  const Shot shot = shotAt(spinning(48, 500, -30, 30, 40));
  expectTheProcessorsBytes(scene, shot, "refine: triangle");
  const Hits hits = traced(*methodOf("particle", scene, "{backend: gl}"), shot);
  EXPECT_GT(std::count(hits.semantic.begin(), hits.semantic.end(), 1), 100) << "some pass all three";
  EXPECT_GT(std::count(hits.semantic.begin(), hits.semantic.end(), 2), 1000);
}

// Those in one field may fly together.
TEST(ParticlesOnADevice, ShotsOfManyThreadsShareIt) {
  SKIP_WITHOUT_GL();
  const Scene street = proceduralStreet();
  auto beams = std::make_shared<BeamTable>(*spinning(12, 250, -25, 5, 60));
  beams->origin.assign(beams->size(), {0.1f, 0, -0.05f});
  const auto other = spinning(8, 160, -20, 5, 60);
  const auto shotOf = [&](std::size_t i) {
    Shot shot = streetShot(i % 4 == 3 ? other : beams, -20);
    for (int step = 1; step < 4; ++step) {  // from the same place, turned
      shot.worldFromSensor.push_back({fromYawPitchRoll(0.3 * static_cast<double>(i) + 0.02 * step, 0.01, 0),
                                      shot.worldFromSensor.front().translation});
    }
    return shot;
  };
  for (const char* refine : {"none", "triangle"}) {
    const std::string options = std::string("voxel_m: 0.2, voxels: 128, refine: ") + refine;
    const auto here = methodOf("particle", street, "{backend: cpu, " + options + "}");
    const auto there = methodOf("particle", street, "{backend: gl, " + options + "}");
    const std::vector<Hits> made = tracedByThreads(*there, 32, shotOf);
    for (std::size_t i = 0; i < made.size(); ++i) expectSameHits(made[i], traced(*here, shotOf(i)));
  }
}

}  // namespace
}  // namespace scanmill
