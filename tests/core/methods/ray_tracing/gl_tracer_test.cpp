// Ray tracing on a device gives the processor's bytes: what the shader says it knows, Embree would have found too.

#include "methods/ray_tracing/gl_tracer.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "base/random.h"
#include "methods/ray_tracing/filter.h"
#include "methods/ray_tracing/packet.h"
#include "methods/ray_tracing/unobstructed.h"
#include "methods/world/worlds.h"
#include "scene/movement.h"
#include "tests/core/methods/trace.h"
#include "tests/support/directions.h"
#include "tests/support/gl.h"
#include "tests/support/message_of.h"
#include "tests/support/same_hits.h"
#include "tests/support/shared_data.h"
#include "tests/support/street.h"
#include "tests/support/test_scene.h"

namespace scanmill {
namespace {

using testing::HasSubstr;

double between(std::uint32_t bits, double low, double high) {
  return low + (high - low) * uniform(bits);
}

// Things that turn, are stretched and mirrored, about a sensor at `shift`, on a ground that coincides with a lawn.
Scene crowd(double shift, std::uint32_t things) {
  SceneBuilder builder = testBuilder();
  Mesh ground = meshOf(builder, "ground");
  appendPlane(ground, 0, {}, 200, 200, 40);
  builder.place(builder.addMesh(ground), at(shift, shift, -2), "ground");
  Mesh lawn = meshOf(builder, "other");
  appendPlane(lawn, 0, {}, 30, 30, 3);
  builder.place(builder.addMesh(lawn), at(shift, shift, -2), "lawn");
  Mesh box = meshOf(builder, "thing");
  appendBox(box, 0, {}, {1, 2, 3});
  const std::uint32_t boxes = builder.addMesh(box);
  Mesh ball = meshOf(builder, "other", "dark");
  appendSphere(ball, 0, {}, 1.0, 48);
  const std::uint32_t balls = builder.addMesh(ball);
  for (std::uint32_t i = 0; i < things; ++i) {
    const RandomBlock b = randomBlock({.beam = i, .purpose = Purpose::Test});
    const double r = 4 + 40 * uniform(b[0]);
    const double a = 2 * kPi * uniform(b[1]);
    const Vec3d size{i % 5 == 0 ? -1.0 : 1.0, between(b[3], 0.1, 2), 1};
    builder.place(i % 2 == 0 ? boxes : balls,
                  {toMatrix(fromYawPitchRoll(6 * uniform(b[2]), 0.3, 0.1)) * Mat3::scale(size),
                   {shift + r * std::cos(a), shift + r * std::sin(a), -1}},
                  "thing");
  }
  return builder.finish();
}

void expectTheProcessorsBytes(const Scene& scene, const Shot& shot, const std::string& more = "") {
  const Hits here = traced(scene, shot, "{backend: cpu" + more + "}");
  expectSameHits(traced(scene, shot, "{backend: gl" + more + "}"), here);
}

// What a tracer makes of a shot; undecided rays are misses.
struct Made {
  Hits hits;
  std::vector<std::uint32_t> undecided;
};

Made madeBy(GlTracer& tracer, const std::shared_ptr<const World>& world, const Shot& shot) {
  Made made;
  made.hits.reset(shot.beams->rings, shot.beams->columns, Channels::all());
  std::vector<UndecidedRay> undecided;
  StageClock clock;
  tracer.trace(world, shot, frameOf(shot, world->origin), 1000, 1e-5f, made.hits, undecided, clock);
  for (const UndecidedRay& open : undecided) {
    EXPECT_EQ(open.verdict, RayVerdict::Open);
    made.undecided.push_back(open.ray);
    made.hits.range[open.ray] = kMiss;
    made.hits.normal[open.ray] = {};
    for (auto* column : {&made.hits.reflectance, &made.hits.incidence}) (*column)[open.ray] = 0;
    for (auto* column : {&made.hits.instance, &made.hits.primitive}) (*column)[open.ray] = 0;
    for (auto* column : {&made.hits.semantic, &made.hits.material}) (*column)[open.ray] = 0;
  }
  return made;
}

void expectSameWork(const Made& a, const Made& b) {
  expectSameHits(a.hits, b.hits);
  EXPECT_EQ(a.undecided, b.undecided);
}

// What share of the rays the shader leaves to Embree.
double unsureShare(const Scene& scene, const Shot& shot, Instancing instancing, const GlTracerLimits& limits = {}) {
  const Worlds worlds(scene, instancing, {true, HierarchyQuality::Medium, tieFilter, alphaTieFilter, thingFilter});
  const auto world = worlds.near(shot.worldFromSensor.front().translation, shot.time, shot.duration);
  const ShotFrame frame = frameOf(shot, world->origin);
  GlTracer tracer(limits);
  Hits hits;
  hits.reset(shot.beams->rings, shot.beams->columns, Channels::all());
  std::vector<UndecidedRay> undecided;
  StageClock clock;
  tracer.trace(world, shot, frame, searchDistance(*shot.beams),
               coplanarFloor(static_cast<float>(length(frame.position.front()))), hits, undecided, clock);
  return static_cast<double>(undecided.size()) / static_cast<double>(hits.rays());
}

TEST(GlTracer, GivesTheProcessorsBytes) {
  SKIP_WITHOUT_GL();
  for (const double shift : {0.0, 1e7}) {
    const Scene scene = crowd(shift, 60);
    const Shot shot = shotAt(spinning(64, 1024, -25, 5), {fromYawPitchRoll(0.7, 0.02, -0.03), {shift, shift, 0}});
    for (const char* instancing : {", instancing: never", ", instancing: always"}) {
      SCOPED_TRACE(instancing + std::to_string(shift));
      expectTheProcessorsBytes(scene, shot, instancing);
    }
  }
}

// The lawn coincides with the ground: the tie rule is Embree's to apply. Elsewhere few rays are left to it.
TEST(GlTracer, LeavesTiesToEmbreeAndLittleElse) {
  SKIP_WITHOUT_GL();
  const Shot down = shotAt(beamsOf(std::vector<Vec3d>(100, {0.3, 0.2, -1})));
  EXPECT_EQ(unsureShare(crowd(0, 0), down, Instancing::Never), 1);
  const Scene street = proceduralStreet();
  const Shot shot = streetShot(presetBeams("paper_64"), -20);
  EXPECT_LT(unsureShare(street, shot, Instancing::Auto), 0.01);
}

TEST(GlTracer, TheProceduralStreet) {
  SKIP_WITHOUT_GL();
  const Scene street = proceduralStreet(3);
  for (const double x : {-20.0, 35.0}) expectTheProcessorsBytes(street, streetShot(presetBeams("paper_64"), x));
}

TEST(GlTracer, ClosedRoomsHaveNoEscapes) {
  SKIP_WITHOUT_GL();
  SceneBuilder builder = testBuilder();
  Mesh room = meshOf(builder, "ground");
  appendSphere(room, 0, {}, 5.0, 96);
  builder.place(builder.addMesh(room), {toMatrix(fromYawPitchRoll(0.3, 0.2, 0.1)), {0, 0, 0}}, "room");
  const Scene scene = builder.finish();
  const std::vector<Vec3d> all = randomDirections(60'000);
  for (const char* instancing : {"{backend: gl, instancing: never}", "{backend: gl, instancing: always}"}) {
    const Hits hits = traced(scene, shotAt(beamsOf(all)), instancing);
    EXPECT_EQ(std::count(hits.range.begin(), hits.range.end(), kMiss), 0) << instancing;
  }
  // Through corners and the middles of edges, where either triangle may be met.
  std::vector<Vec3d> directions;
  const Mesh& mesh = scene.meshes[0];
  for (std::size_t t = 0; t < mesh.triangles.size(); t += 3) {
    const auto corner = [&](int k) {
      return scene.instances[0].worldFromMesh * Vec3d(mesh.positions[mesh.triangles[t][k]]);
    };
    directions.push_back(corner(0));
    directions.push_back(corner(1) + corner(2));
  }
  for (const char* instancing : {", instancing: never", ", instancing: always"}) {
    SCOPED_TRACE(instancing);
    expectTheProcessorsBytes(scene, shotAt(beamsOf(directions)), instancing);
  }
}

// Leaves whose holes are as fine as the beams' spacing, on textures that repeat.
TEST(GlTracer, CutOutsLetTheSameBeamsPass) {
  SKIP_WITHOUT_GL();
  SceneBuilder builder = testBuilder();
  Material leaf;
  leaf.name = "leaf";
  leaf.alphaTested = true;
  auto texture = std::make_shared<Texture>();
  texture->width = 37;
  texture->height = 23;
  texture->hasAlpha = true;
  for (std::uint32_t i = 0; i < texture->width * texture->height; ++i) {
    const auto alpha = static_cast<std::uint8_t>(randomBlock({.beam = i, .purpose = Purpose::Test})[0] & 255u);
    texture->rgba.insert(texture->rgba.end(), {10, 200, 30, alpha});
  }
  leaf.texture = texture;
  Mesh curtain;
  curtain.surfaces.push_back({builder.addMaterial(leaf), 2, 1, "", "", {}});
  appendQuad(curtain, 0, {0, 5, -5}, {0, -5, -5}, {0, -5, 5}, {0, 5, 5});
  curtain.uvs = {{-0.3f, 0.1f}, {2.9f, 0}, {3, 2.2f}, {0, 1.9f}};
  const std::uint32_t mesh = builder.addMesh(std::move(curtain));
  for (int i = 0; i < 4; ++i) {
    builder.place(mesh, {toMatrix(fromYawPitchRoll(0.2 * i, 0, 0.1 * i)), {5.0 + 2 * i, 0.3 * i, 0}}, "curtain");
  }
  Mesh wall = meshOf(builder, "ground");
  appendQuad(wall, 0, {20, 50, -50}, {20, -50, -50}, {20, -50, 50}, {20, 50, 50});
  builder.place(builder.addMesh(wall), {}, "wall");
  const Scene scene = builder.finish();
  const Shot shot = shotAt(spinning(64, 1024, -30, 30));
  for (const char* instancing : {", instancing: never", ", instancing: always"}) {
    SCOPED_TRACE(instancing);
    expectTheProcessorsBytes(scene, shot, instancing);
  }
  EXPECT_LT(unsureShare(scene, shot, Instancing::Always), 0.02);
}

TEST(GlTracer, WhatMovesIsMetWhereItIsWhenTheBeamFires) {
  SKIP_WITHOUT_GL();
  SceneBuilder builder = testBuilder();
  Mesh ground = meshOf(builder, "ground");
  appendPlane(ground, 0, {}, 200, 200, 4);
  builder.place(builder.addMesh(ground), at(0, 0, -2), "ground");
  Mesh ball = meshOf(builder, "thing");
  appendSphere(ball, 0, {}, 1.5, 32);
  const std::uint32_t balls = builder.addMesh(ball);
  for (int i = 0; i < 8; ++i) {
    const double angle = 2 * kPi * i / 8;
    builder.place(balls, at(12 * std::cos(angle), 12 * std::sin(angle), -0.5), "ball", {},
                  std::make_shared<Movement>(Vec3d{30 * std::sin(2 * angle), 15, 3}));
  }
  Mesh box = meshOf(builder, "thing");
  appendBox(box, 0, {}, {1, 2, 3});
  const std::uint32_t boxes = builder.addMesh(box);
  for (const Vec3d& size : {Vec3d{-1, 1, 1}, Vec3d{1, -0.5, 2}, Vec3d{-1, -1, -1}}) {  // normals with zeros
    builder.place(boxes, {Mat3::scale(size), {6 * size.x, 7 * size.y, 0}}, "box", {},
                  std::make_shared<Movement>(Vec3d{0, 4, 0}));
  }
  const Scene scene = builder.finish();
  const auto beams = spinning(32, 1024, -25, 15);
  const auto cpu = rayTracing(scene, "{backend: cpu}");
  const auto gl = rayTracing(scene, "{backend: gl}");
  for (const double time : {0.0, 0.4, 0.8}) {  // meshes stay on the device, places change
    Shot shot = shotAt(beams);
    shot.time = time;
    shot.duration = 0.1;
    shot.worldFromSensor.clear();
    for (int step = 0; step < 100; ++step)
      shot.worldFromSensor.push_back({fromYawPitchRoll(0.001 * step, 0, 0), {0.02 * step, 0, 0}});
    SCOPED_TRACE(time);
    expectSameHits(traced(*gl, shot), traced(*cpu, shot));
  }
}

// A wall whose texture repeats, of texels of any colour.
Scene papered(const std::shared_ptr<const Movement>& movement) {
  SceneBuilder builder = testBuilder();
  Material paper;
  paper.name = "paper";
  paper.reflectance = 0.4f;
  paper.textured = true;
  paper.textureMean = 0.3f;
  auto texture = std::make_shared<Texture>();
  texture->width = 61;
  texture->height = 17;
  for (std::uint32_t i = 0; i < texture->width * texture->height; ++i) {
    const RandomBlock b = randomBlock({.beam = i, .purpose = Purpose::Test});
    for (const std::uint32_t word : {b[0], b[1], b[2]}) texture->rgba.push_back(static_cast<std::uint8_t>(word & 255u));
    texture->rgba.push_back(255);
  }
  paper.texture = texture;
  Mesh wall;
  wall.surfaces.push_back({builder.addMaterial(paper), 2, 1, "", "", {}});
  appendQuad(wall, 0, {0, 5, -5}, {0, -5, -5}, {0, -5, 5}, {0, 5, 5});
  wall.uvs = {{-1.3f, 0.1f}, {2.9f, 0}, {3, 2.2f}, {0, 1.9f}};
  const std::uint32_t mesh = builder.addMesh(std::move(wall));
  for (int i = 0; i < 5; ++i) {
    const double angle = 0.2 + 1.3 * i;
    builder.place(mesh,
                  {toMatrix(fromYawPitchRoll(angle, 0.1 * i, 0.2 * i)) * Mat3::scale({1, 1 - 0.3 * i, 0.7}),
                   {7 * std::cos(angle), 7 * std::sin(angle), 0}},
                  "wall", {}, movement);
  }
  return builder.finish();
}

TEST(GlTracer, TexturesGiveTheSameReflectance) {
  SKIP_WITHOUT_GL();
  const Scene scene = papered(nullptr);
  const Shot shot = shotAt(spinning(64, 1024, -30, 30), {fromYawPitchRoll(0.3, 0.02, 0.1), {0.2, 0.1, 0}});
  for (const char* instancing : {", instancing: never", ", instancing: always"}) {
    SCOPED_TRACE(instancing);
    expectTheProcessorsBytes(scene, shot, instancing);
  }
  EXPECT_LT(unsureShare(scene, shot, Instancing::Always), 0.02);
  EXPECT_LT(unsureShare(scene, shot, Instancing::Never), 0.02);
  const Scene moving = papered(std::make_shared<Movement>(Vec3d{3, 15, 1}));
  Shot turning = shot;
  turning.duration = 0.1;
  expectTheProcessorsBytes(moving, turning);
  EXPECT_LT(unsureShare(moving, turning, Instancing::Always), 0.02);
}

// Only what is asked for is made and comes back.
TEST(GlTracer, AnyChannelsAreThoseOfAll) {
  SKIP_WITHOUT_GL();
  const Scene scene = crowd(0, 40);
  const auto cpu = rayTracing(scene, "{backend: cpu}");
  const auto gl = rayTracing(scene, "{backend: gl}");
  const Shot shot = shotAt(spinning(16, 500, -25, 5));
  for (const Channels channels :
       {Channels(Channel::Range), Channel::Range | Channel::Normal, Channel::Material | Channel::Range,
        Channel::Semantic | Channel::Incidence, Channels(Channel::Primitive) | Channel::Normal | Channel::Instance,
        Channels(Channel::Reflectance)}) {
    expectSameHits(traced(*gl, shot, channels), traced(*cpu, shot, channels));
  }
}

// Hits nearer or farther than the sensor reports are misses on both.
TEST(GlTracer, RangeLimitsAreTheSame) {
  SKIP_WITHOUT_GL();
  const Scene scene = crowd(0, 60);
  auto beams = spinning(32, 1024, -25, 5);
  beams->minRange = 6;
  beams->maxRange = 21.5;
  expectTheProcessorsBytes(scene, shotAt(beams));
}

TEST(GlTracer, ShotsOfManyThreadsShareTheDevice) {
  SKIP_WITHOUT_GL();
  const Scene scene = crowd(0, 40);
  const auto cpu = rayTracing(scene, "{backend: cpu}");
  const auto gl = rayTracing(scene, "{backend: gl}");
  const auto beams = spinning(16, 500, -25, 5);
  const auto other = spinning(8, 300, -15, 15);
  const auto shot = [&](std::size_t i) {
    return shotAt(i % 3 == 0 ? other : beams, {fromYawPitchRoll(0.1 * static_cast<double>(i), 0, 0), {0, 0, 0}});
  };
  const std::vector<Hits> made = tracedByThreads(*gl, 24, shot);
  for (std::size_t i = 0; i < made.size(); ++i) expectSameHits(made[i], traced(*cpu, shot(i)));
}

// Each thread says where the meshes of its revolution stand.
TEST(GlTracer, RevolutionsOfManyThreadsShareMeshes) {
  SKIP_WITHOUT_GL();
  const Scene moving = papered(std::make_shared<Movement>(Vec3d{3, 15, 1}));
  const auto cpu = rayTracing(moving, "{backend: cpu}");
  const auto gl = rayTracing(moving, "{backend: gl}");
  const auto beams = spinning(16, 500, -30, 30);
  const auto revolution = [&](std::size_t i) {
    Shot shot = shotAt(beams, {fromYawPitchRoll(0.3, 0.02, 0.1), {0.2, 0.1, 0}});
    shot.time = 0.05 * static_cast<double>(i / 2);  // two sensors of a vehicle
    shot.duration = 0.1;
    return shot;
  };
  const std::vector<Hits> made = tracedByThreads(*gl, 24, revolution);
  for (std::size_t i = 0; i < made.size(); ++i) expectSameHits(made[i], traced(*cpu, revolution(i)));
}

TEST(GlTracer, BeamsWithOriginsAndSeveralRays) {
  SKIP_WITHOUT_GL();
  const Scene scene = crowd(0, 40);
  auto beams = spinning(17, 333, -25, 5);
  for (std::size_t i = 0; i < beams->size(); ++i)
    beams->origin.push_back({0.1f, 0.001f * static_cast<float>(i % 50), 0.2f});
  Shot shot = shotAt(beams);
  for (int step = 1; step < 7; ++step) shot.worldFromSensor.push_back({{}, {0.5 * step, 0, 0}});
  expectTheProcessorsBytes(scene, shot);
}

// Rings go one slice after the other where a buffer holds less; other sensors and places follow on the same device.
TEST(GlTracer, SlicesAndChangesDoNotMatter) {
  SKIP_WITHOUT_GL();
  const Scene scene = crowd(0, 40);
  const Worlds worlds(scene, Instancing::Always,
                      {true, HierarchyQuality::Medium, tieFilter, alphaTieFilter, thingFilter});
  GlTracer whole;
  GlTracer sliced({.bytes = 1 << 20});
  for (const auto& [rings, x] : {std::pair(64u, 0.0), {16u, 0.0}, {64u, 5.0}, {64u, 3000.0}}) {
    const Shot shot = shotAt(spinning(rings, 1024, -25, 5), {{}, {x, 0, 0}});
    const auto world = worlds.near(shot.worldFromSensor.front().translation, 0, 0);
    expectSameWork(madeBy(whole, world, shot), madeBy(sliced, world, shot));
  }
}

// Scenes take turns on one device; the memory of one that is gone may be the next one's.
TEST(GlTracer, ScenesTakeTurns) {
  SKIP_WITHOUT_GL();
  GlTracer one;
  for (int round = 0; round < 6; ++round) {
    SceneBuilder builder = testBuilder();
    Mesh box = meshOf(builder, "thing");
    appendBox(box, 0, {}, {4.0 + round, 4.0 + round % 2, 4});
    builder.place(builder.addMesh(std::move(box)), at(8, 0, 0), "box");
    const Scene scene = builder.finish();
    const Worlds worlds(scene, Instancing::Always,
                        {true, HierarchyQuality::Medium, tieFilter, alphaTieFilter, thingFilter});
    const Shot shot = shotAt(spinning(16, 256, -20, 20));
    const auto world = worlds.near({});
    GlTracer fresh;
    SCOPED_TRACE(round);
    expectSameWork(madeBy(one, world, shot), madeBy(fresh, world, shot));
  }
}

// What `plan` says of the device's memory.
TEST(GlTracer, TrianglesTakeAsMuchMemoryAsIsSaid) {
  const Scene street = proceduralStreet();
  const DeviceHandle device = makeDevice();
  for (const Instancing instancing : {Instancing::Never, Instancing::Auto}) {
    const Worlds worlds(street, instancing, {});
    const auto world = worlds.near({});
    const DeviceMeshes meshes = deviceMeshes(device.get(), *world);
    const DevicePlaces places = devicePlaces(device.get(), *world, meshes.blocks);
    const auto bytesOf = [](const auto& array) { return static_cast<double>(std::span(array).size_bytes()); };
    const double bytes = bytesOf(meshes.nodes) + bytesOf(meshes.triangles) + bytesOf(meshes.cutouts) +
                         bytesOf(meshes.holes) + bytesOf(places.nodes) + bytesOf(places.places);
    EXPECT_NEAR(bytes, static_cast<double>(worlds.triangles() * kDeviceBytesPerTriangle), 0.15 * bytes);
  }
}

TEST(GlTracer, SaysWhatDoesNotFit) {
  SKIP_WITHOUT_GL();
  const Scene scene = crowd(0, 4);
  EXPECT_THAT(messageOf<Error>(
                  [&] { unsureShare(scene, shotAt(spinning(16, 256, -25, 5)), Instancing::Never, {.bytes = 10'000}); }),
              testing::AllOf(HasSubstr("rays cannot be traced by OpenGL: the scene's "), HasSubstr("MiB"),
                             HasSubstr("'backend: cpu' does without it")));
}

TEST(GlTracer, RefusesWhatItCannotDo) {
  const Scene scene = crowd(0, 1);
  EXPECT_THAT(messageOf([&] { rayTracing(scene, "{backend: gl, robust: false}"); }), HasSubstr("robust"));
  SKIP_WITHOUT_GL();
  ::setenv("SCANMILL_GL_DEVICE", "77", 1);
  const std::string message = messageOf<Error>([&] { rayTracing(scene, "{backend: gl}"); });
  ::unsetenv("SCANMILL_GL_DEVICE");
  EXPECT_THAT(message, HasSubstr("rays cannot be traced by OpenGL"));
}

TEST(GlTracer, ARealPlace) {
  SKIP_WITHOUT_GL();
  SKIP_WITHOUT_SHARED_DATA("scenes");
  ::setenv("SCANMILL_ASSETS", sharedData().c_str(), 0);
  const Scene scene = readScene(std::string(SCANMILL_SOURCE_DIR) + "/scenes/truck_town.yaml", {});
  expectTheProcessorsBytes(scene, shotAt(presetBeams("paper_64"), {{}, {10, 2, 1.9}}));
}

}  // namespace
}  // namespace scanmill
