#include <bit>
#include <cstdlib>
#include <vector>

#include "base/random.h"
#include "methods/field/distance_field.h"
#include "methods/gpu/gl_marcher.h"
#include "methods/particle/options.h"
#include "methods/particle/particles.h"
#include "methods/world/world.h"
#include "tests/core/methods/gpu/gl_march.h"
#include "tests/core/methods/particle/fields.h"
#include "tests/support/gl.h"
#include "tests/support/message_of.h"
#include "tests/support/test_scene.h"

namespace scanmill {
namespace {

using testing::HasSubstr;

// Levels of 64^3 voxels around the middle of a scene, and what particles need of it.
struct Surroundings {
  std::shared_ptr<const World> world;
  std::shared_ptr<const DistanceField> field;
};

ParticleOptions optionsOf(bool lists, double voxel = 0.25) {
  ParticleOptions options;
  options.voxel = voxel;
  options.voxels = 64;
  options.levels = 3;
  options.refine = lists ? ParticleOptions::Refine::ByTriangle : ParticleOptions::Refine::None;
  return options;
}

Surroundings surroundingsOf(const Scene& scene, bool lists, double voxel = 0.25) {
  const DeviceHandle device = makeDevice();
  const std::vector<bool> instanced(scene.meshes.size(), false);
  const SharedMeshes shared(device.get(), scene, instanced, {});
  const ParticleOptions options = optionsOf(lists, voxel);
  Surroundings made{buildWorld(device.get(), scene, {}, instanced, shared, {}), nullptr};
  made.field = buildField(*made.world, shapeOf(options, {}, scene.bounds(), 30));
  return made;
}

// A room with furniture whose triangles are large and small, and a loose sheet.
Scene furnished() {
  const auto fill = [](Mesh& mesh) {
    appendBox(mesh, 0, {}, {24, 16, 8});
    appendSphere(mesh, 0, at(3, 2, -1), 1.5, 24);
    appendBox(mesh, 0, at(-4, -2, 0), {0.04, 0.04, 5});
    appendCylinder(mesh, 0, at(5, -4, 1), 0.6, 0, 2, 16);
    appendQuad(mesh, 0, {-6, 3, -2}, {-5, 5, -2}, {-5, 5, 2}, {-6, 3, 2});
  };
  return oneMeshScene("thing", fill, {toMatrix(fromYawPitchRoll(0.3, 0.1, -0.2)), {0.1, 0.2, 0.05}});
}

Scene openGround() {
  const auto fill = [](Mesh& mesh) {
    appendPlane(mesh, 0, at(0, 0, -2), 100, 100, 9);
    appendSphere(mesh, 0, at(6, 1, -1), 1, 16);
  };
  return oneMeshScene("ground", fill);
}

Scene nothing() {
  Scene scene;
  scene.materials.resize(1);
  return scene;
}

// From all over the field, in all directions; every ninth along an axis, some that have no way to go.
Particles particlesIn(const DistanceField& field, std::size_t count, std::uint32_t stream = 0) {
  Particles particles;
  const Box box = marchBox(field.shape);
  for (std::size_t i = 0; i < count; ++i) {
    const auto beam = static_cast<std::uint32_t>(i);
    const RandomBlock p = randomBlock({5, stream, 0, 0, beam, 0, Purpose::Test});
    const RandomBlock d = randomBlock({5, stream, 1, 0, beam, 0, Purpose::Test});
    const double reach = i % 4 == 0 ? 1 : 0.2;  // most from the middle, where the levels are fine
    const auto within = [&](double low, double high, std::uint32_t bits) {
      return (low + high) / 2 + reach * (high - low) * (uniform(bits) - 0.5);
    };
    const Vec3d origin{within(box.low.x, box.high.x, p[0]), within(box.low.y, box.high.y, p[1]),
                       within(box.low.z, box.high.z, p[2])};
    const double z = 2 * uniform(d[0]) - 1;
    const double s = std::sqrt(1 - z * z);
    const double azimuth = 2 * kPi * uniform(d[1]);
    Vec3d direction{s * std::cos(azimuth), s * std::sin(azimuth), z};
    if (i % 9 == 0) {
      const double turn = d[2] % 2 == 0 ? 1 : -1;
      const Vec3d axes[] = {{turn, 0, 0}, {0, turn, 0}, {0, 0, turn}};
      direction = axes[d[3] % 3];
    }
    addParticle(field, origin, direction, i % 5 == 0 ? 4 * uniform(p[3]) * field.shape.voxel : 0, INFINITY, particles);
    if (i % 31 == 0) particles.end[i] = particles.begin[i];
    if (i % 37 == 0) particles.end[i] = -1;
  }
  return particles;
}

struct Counts {
  std::size_t hits = 0, misses = 0, exhausted = 0, wrong = 0;
};

// Bit by bit what the processor finds.
Counts compared(const Surroundings& place, std::uint32_t steps, const Particles& particles, const HitRecords& records) {
  Counts counts;
  EXPECT_EQ(records.size(), particles.size());
  const HitRecords there = flown(*place.field, place.world->baked, steps, particles);
  for (std::size_t i = 0; i < records.size(); ++i) {
    const HitRecord expected = recordOf(there, i);
    const Outcome outcome = records.outcomeOf(i);
    counts.hits += outcome == Outcome::Hit;
    counts.misses += outcome == Outcome::Miss;
    counts.exhausted += outcome == Outcome::Exhausted;
    const bool right =
        outcome == expected.outcome && records.stepsOf(i) == expected.steps &&
        std::bit_cast<std::uint32_t>(records.travelled[i]) == std::bit_cast<std::uint32_t>(expected.travelled) &&
        records.triangle[i] == expected.triangle;
    if (!right && counts.wrong++ == 0) {
      ADD_FAILURE() << "particle " << i << ": outcome " << records.outcome[i] % 4 << " after " << records.stepsOf(i)
                    << " steps, travelled " << records.travelled[i] << ", triangle " << records.triangle[i]
                    << " and not " << static_cast<int>(expected.outcome) << " after " << expected.steps
                    << ", travelled " << expected.travelled << ", triangle " << expected.triangle;
    }
  }
  EXPECT_EQ(counts.wrong, 0u);
  return counts;
}

Counts flown(GlMarch& marcher, const Surroundings& place, std::uint32_t steps, const Particles& particles) {
  return compared(place, steps, particles, marcher.march(place.field, place.world, steps, particles));
}

constexpr std::uint32_t kUsual = 512;

TEST(GlMarcher, TakesTheStepsOfTheProcessorBitByBit) {
  SKIP_WITHOUT_GL();
  GlMarch marcher;
  for (const bool lists : {false, true}) {
    for (const Scene& scene : {furnished(), openGround()}) {
      const Surroundings place = surroundingsOf(scene, lists);
      const Particles particles = particlesIn(*place.field, 5000);
      const Counts usual = flown(marcher, place, kUsual, particles);
      EXPECT_GT(usual.hits, 500u);
      EXPECT_GT(usual.misses, 100u);
      const Counts few = flown(marcher, place, 4, particles);
      EXPECT_GT(few.exhausted, 500u);
      EXPECT_EQ(flown(marcher, place, 0, particles).exhausted, particles.size());
    }
  }
}

TEST(GlMarcher, NothingIsMetInAnEmptyField) {
  SKIP_WITHOUT_GL();
  GlMarch marcher;
  const Scene scene = nothing();
  for (const bool lists : {false, true}) {
    const Surroundings place = surroundingsOf(scene, lists);
    EXPECT_TRUE(place.field->distance.empty());
    EXPECT_EQ(flown(marcher, place, kUsual, particlesIn(*place.field, 300)).misses, 300u);
  }
}

TEST(GlMarcher, FieldsAndWorldsTakeTurns) {
  SKIP_WITHOUT_GL();
  GlMarch marcher;
  const Scene room = furnished();
  const Scene ground = openGround();
  const std::vector<Surroundings> places{surroundingsOf(room, true), surroundingsOf(ground, true),
                                         surroundingsOf(room, false), surroundingsOf(room, true, 0.4)};
  for (const std::size_t k : {0u, 0u, 1u, 0u, 2u, 1u, 3u, 0u, 2u, 3u}) {
    flown(marcher, places[k], kUsual, particlesIn(*places[k].field, 500));
  }
}

// A copy whose distances are other ones: shorter than they are, so that particles stop early.
std::shared_ptr<DistanceField> spoilt(const DistanceField& field, std::size_t bricks) {
  auto made = std::make_shared<DistanceField>(field);
  const auto pool = std::make_shared<BrickPool>(0);
  pool->distance.assign(field.distance.begin(), field.distance.end());
  std::fill_n(pool->distance.begin(), bricks * kBrickStride, 0);
  made->distance = pool->distance;
  pool->triangleOrList.assign(field.triangleOrList.begin(), field.triangleOrList.end());
  made->triangleOrList = pool->triangleOrList;
  pool->lists.assign(field.lists.begin(), field.lists.end());
  made->lists = pool->lists;
  made->pool = pool;
  return made;
}

TEST(GlMarcher, BricksAreUploadedOnce) {
  SKIP_WITHOUT_GL();
  const Scene scene = furnished();
  for (const bool lists : {false, true}) {
    Surroundings place = surroundingsOf(scene, lists);
    // The second has room for more.
    for (const double x : {0.5, 4.5}) {
      const FieldShape shape = shapeOf(optionsOf(lists), {x, 1, 0}, scene.bounds(), 30);
      place.field = buildField(*place.world, shape, {place.field});
    }
    GlMarch marcher;
    flown(marcher, place, kUsual, particlesIn(*place.field, 10));
    const std::size_t bricks = place.field->distance.size() / kBrickStride;
    const auto before = place.field;
    const FieldShape shape = shapeOf(optionsOf(lists), {6.5, 1, 0}, scene.bounds(), 30);
    place.field = buildField(*place.world, shape, {before});
    ASSERT_EQ(place.field->pool, before->pool);
    ASSERT_GT(place.field->distance.size(), before->distance.size());
    const Particles particles = particlesIn(*place.field, 2000);
    // Were the bricks before looked at again, it would be seen that they are others now.
    const auto other = spoilt(*place.field, bricks);
    const auto keeps = other->pool;
    other->pool = place.field->pool;
    const HitRecords records = marcher.march(other, place.world, kUsual, particles);
    compared(place, kUsual, particles, records);
    // Those of another pool are looked at.
    other->pool = keeps;
    const HitRecords differ = marcher.march(std::make_shared<DistanceField>(*other), place.world, kUsual, particles);
    EXPECT_NE(records.travelled, differ.travelled);
  }
}

// Of a field that has moved the device gets the new bricks alone.
TEST(GlMarcher, AFieldMovesOnTheDevice) {
  SKIP_WITHOUT_GL();
  const Scene scene = furnished();
  for (const bool lists : {false, true}) {
    const Surroundings start = surroundingsOf(scene, lists);
    const auto shape = [&](double x) { return shapeOf(optionsOf(lists), {x, 0.3 * x, 0}, scene.bounds(), 30); };
    GlMarch marcher;
    Surroundings place = start;
    for (const double x : {0.0, 2.0, 4.5, 4.5, 9.0, -3.0, 400.0, 2.0}) {  // there is nothing at 400 m
      place.field = buildField(*start.world, shape(x), {place.field});
      flown(marcher, place, kUsual, particlesIn(*place.field, 3000));
    }
    // A device whose tables hold the bricks, but not the room for more.
    std::vector<std::shared_ptr<const DistanceField>> fields{buildField(*start.world, shape(400))};
    std::uint64_t most = 0;
    std::uint64_t room = 0;
    for (const double x : {2.0, 2.0, -3.0}) {
      fields.push_back(buildField(*start.world, shape(x), {fields.back()}));
      most = std::max<std::uint64_t>({most, fields.back()->triangleOrList.size(), fields.back()->lists.size()});
      room = std::max<std::uint64_t>(room, fields.back()->pool->triangleOrList.size());
    }
    ASSERT_GT(room, most);
    GlMarch small(most);
    for (const auto& field : fields) {
      place.field = field;
      flown(small, place, kUsual, particlesIn(*place.field, 1000));
    }
    // Back to one that it had, and on from one that it has not seen.
    const auto had = place.field;
    const auto skipped = buildField(*start.world, shape(1), {had});
    place.field = buildField(*start.world, shape(3), {skipped});
    for (const auto& field : {place.field, had, skipped}) {
      place.field = field;
      flown(marcher, place, kUsual, particlesIn(*place.field, 3000));
    }
  }
}

// Threads that work on drives of their own take turns: the bricks of each stay.
TEST(GlMarcher, FieldsOfSeveralDrivesStay) {
  SKIP_WITHOUT_GL();
  const Scene scene = furnished();
  GlMarch marcher;
  std::vector<Surroundings> drives;
  for (const bool lists : {false, true}) {
    drives.push_back(surroundingsOf(scene, lists));
    drives.push_back(surroundingsOf(scene, lists, 0.4));
    flown(marcher, drives[drives.size() - 2], kUsual, particlesIn(*drives[drives.size() - 2].field, 100));
    flown(marcher, drives.back(), kUsual, particlesIn(*drives.back().field, 100));
  }
  for (const Surroundings& place : drives) {
    // Were it uploaded again, it would be seen that it is another one now.
    const auto other = spoilt(*place.field, place.field->distance.size() / kBrickStride);
    other->pool = place.field->pool;
    const Particles particles = particlesIn(*place.field, 500);
    const HitRecords records = marcher.march(other, place.world, kUsual, particles);
    compared(place, kUsual, particles, records);
  }
}

TEST(GlMarcher, FieldsLargerThanTheDeviceTakesAreRefused) {
  SKIP_WITHOUT_GL();
  const Scene scene = furnished();
  const Surroundings place = surroundingsOf(scene, true);
  const Particles particles = particlesIn(*place.field, 10);
  const auto refusal = [&](std::uint64_t texels) {
    GlMarch marcher(texels);
    return messageOf<Error>([&] { marcher.march(place.field, place.world, kUsual, particles); });
  };
  const std::uint64_t largest = place.field->triangleOrList.size();
  const std::string message = refusal(largest - 1);
  EXPECT_THAT(message, HasSubstr("particles cannot march by OpenGL: the "));
  EXPECT_THAT(message, HasSubstr("voxel_m"));
  EXPECT_THAT(message, HasSubstr("levels"));
  EXPECT_THAT(message, HasSubstr("backend: cpu"));
  EXPECT_EQ(refusal(std::uint64_t{1} << 30), "accepted");
  // After a refusal the marcher takes what it can.
  GlMarch marcher(largest / 2);
  EXPECT_THAT(messageOf<Error>([&] { marcher.march(place.field, place.world, kUsual, particles); }),
              HasSubstr("particles cannot march by OpenGL"));
  const Scene empty = nothing();
  const Surroundings little = surroundingsOf(empty, true);
  EXPECT_EQ(flown(marcher, little, kUsual, particlesIn(*little.field, 10)).misses, 10u);
}

TEST(GlMarcher, SaysWhatToDoWithoutADevice) {
  SKIP_WITHOUT_GL();
  ::setenv("SCANMILL_GL_DEVICE", "77", 1);
  const std::string message = messageOf<Error>([] { GlMarcher marcher; });
  ::unsetenv("SCANMILL_GL_DEVICE");
  EXPECT_THAT(message, HasSubstr("particles cannot march by OpenGL: SCANMILL_GL_DEVICE: there is no device '77'"));
  EXPECT_THAT(message, HasSubstr("backend: cpu"));
}

}  // namespace
}  // namespace scanmill
