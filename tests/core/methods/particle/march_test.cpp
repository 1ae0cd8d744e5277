#include <hwy/targets.h>

#include <memory>
#include <numeric>

#include "methods/field/distance_field.h"
#include "methods/particle/particles.h"
#include "tests/core/methods/particle/fields.h"
#include "tests/support/test_scene.h"

namespace scanmill {
namespace {

constexpr std::uint32_t kSteps = 4096;

// A field and what it names.
struct Place {
  DistanceField field;
  TriangleBlock triangles;
};

Place placeOf(const FieldShape& shape, const DistanceFunction& distance, const LooseTriangles& triangles) {
  return {fieldOf(shape, distance, triangles), blockOfTriangles(triangles)};
}

// normal . p = offset, and two triangles of it that reach so far around the point nearest to `middle`.
struct Plane {
  Vec3d normal;
  double offset;

  double height(const Vec3d& p) const { return dot(normal, p) - offset; }
  LooseTriangles triangles(const Vec3d& middle, double reach) const {
    const Vec3d u = normalized(cross(normal, std::fabs(normal.x) < 0.7 ? Vec3d{1, 0, 0} : Vec3d{0, 1, 0})) * reach;
    const Vec3d v = cross(normal, u);
    const Vec3d m = middle + normal * -height(middle);
    return {{m - u - v, m + u - v, m + u + v}, {m - u - v, m + u + v, m - u + v}};
  }
};

Place planePlace(const FieldShape& shape, const Plane& plane, double reach = 100) {
  return placeOf(
      shape, [=](const Vec3d& p) { return std::fabs(plane.height(p)); }, plane.triangles(shape.centre, reach));
}

// A world of scattered triangles, large and small, around the origin.
std::unique_ptr<World> scatteredWorld() {
  SceneBuilder builder = testBuilder();
  Mesh mesh = meshOf(builder, "thing");
  for (std::uint32_t t = 0; t < 300; ++t) {
    const Vec3d middle = anyPoint(1, t) * (t % 3 == 0 ? 3.0 : 12.0);
    const double size = t % 10 == 0 ? 3 : 0.2;
    const auto corner = [&](std::uint32_t k) { return middle + anyPoint(2 + k, t) * size; };
    appendQuad(mesh, 0, corner(0), corner(1), corner(2), corner(3));
  }
  builder.place(builder.addMesh(mesh), {}, "triangles");
  const Scene scene = builder.finish();
  const DeviceHandle device = makeDevice();
  const std::vector<bool> instanced(scene.meshes.size(), false);
  const SharedMeshes shared(device.get(), scene, instanced, {});
  return buildWorld(device.get(), scene, {}, instanced, shared, {});
}

// From anywhere, and from where borders of voxels, bricks and levels meet; in any direction, and along axes; some with
// a way that begins later, or has no length.
Particles assortedParticles(const DistanceField& field, std::uint32_t count) {
  Particles particles;
  const double voxel = field.shape.voxel;
  const Box box = marchBox(field.shape);
  for (std::uint32_t i = 0; i < count; ++i) {
    const RandomBlock r = randomBlock({.seed = 33, .beam = i});
    const double reach = std::min(8.0, (box.high.x - box.low.x) / 2);
    const Vec3d p = anyPoint(10, i);
    Vec3d origin = box.center() + p * (i % 2 == 0 ? reach : 0.2 * reach);
    if (i % 5 == 1) {  // a voxel's corner, an edge of a brick or of what a level serves
      const double steps[] = {1, 8, field.shape.reach, 2 * field.shape.reach};
      const double step = steps[r[0] % 4] * voxel;
      const Vec3d off = origin - field.shape.centre;
      origin = field.shape.centre + Vec3d{std::round(off.x / step) * step, std::round(off.y / step) * step,
                                          i % 2 == 0 ? std::round(off.z / step) * step : off.z};
    }
    Vec3d direction = anyDirection(11, i);
    if (i % 4 == 1) {
      const double turn = r[1] % 2 == 0 ? 1 : -1;
      const double tiny = i % 3 == 0 ? -1e-17 : 0;
      const Vec3d axes[] = {{turn, tiny, 0}, {0, turn, tiny}, {tiny, 0, turn}};
      direction = axes[r[2] % 3];
    }
    const double begin = i % 7 == 0 ? 3 * uniform(r[3]) : 0;
    const double end = i % 11 == 0 ? begin : i % 13 == 0 ? begin + 5 * uniform(r[2]) : 1e9;
    addParticle(field, origin, direction, begin, end, particles);
  }
  return particles;
}

std::size_t countOf(const HitRecords& records, Outcome outcome) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < records.size(); ++i) count += records.outcomeOf(i) == outcome;
  return count;
}

void expectSame(const HitRecords& a, const HitRecords& b) {
  EXPECT_EQ(a.travelled, b.travelled);
  EXPECT_EQ(a.triangle, b.triangle);
  EXPECT_EQ(a.outcome, b.outcome);
}

// Restores the choice of instructions.
struct AnyTarget {
  ~AnyTarget() { take(0); }
  static void take(std::int64_t target) {
    hwy::SetSupportedTargetsForTest(target);
    hwy::GetChosenTarget().DeInit();
  }
};

TEST(MarchCpu, AllInstructionSetsTakeTheSameSteps) {
  const std::unique_ptr<World> world = scatteredWorld();
  const AnyTarget restored;
  for (const bool lists : {false, true}) {
    for (const std::uint32_t levels : {1u, 3u, 7u}) {
      SCOPED_TRACE(testing::Message() << levels << " levels, lists " << lists);
      const auto field = buildField(*world, levelsAround({0.3, -0.2, 0.1}, 0.11, 64, levels, lists));
      const Particles particles = assortedParticles(*field, 20011);
      AnyTarget::take(0);
      const HitRecords best = flown(*field, world->baked, 512, particles);
      EXPECT_GT(countOf(best, Outcome::Hit), 2000u);
      EXPECT_GT(countOf(best, Outcome::Miss), 2000u);
      EXPECT_GT(countOf(flown(*field, world->baked, 7, particles), Outcome::Exhausted), 1000u);
      EXPECT_EQ(countOf(flown(*field, world->baked, 0, particles), Outcome::Exhausted), particles.size());
      for (std::int64_t left = hwy::SupportedTargets(); left != 0; left &= left - 1) {
        AnyTarget::take(left & -left);
        expectSame(flown(*field, world->baked, 512, particles), best);
      }
    }
  }
}

// Alone, with a few others, and with more than there are lanes.
TEST(MarchCpu, ParticlesDoNotMindTheOthers) {
  for (const bool lists : {false, true}) {
    const Place place = planePlace(levelsAround({}, 0.1, 64, 2, lists), {normalized(Vec3d{1, 2, 3}), 0.7});
    for (const std::uint32_t count : {0u, 1u, 2u, 15u, 16u, 17u, 69u, 191u, 192u, 193u, 1000u}) {
      const Particles particles = assortedParticles(place.field, count);
      const HitRecords records = flown(place.field, place.triangles, kSteps, particles);
      for (std::size_t i = 0; i < count; ++i) {
        ASSERT_EQ(recordOf(records, i), flownAlone(place.field, place.triangles, kSteps, particles, i)) << i;
      }
    }
  }
}

TEST(MarchCpu, NothingIsMetInAnEmptyField) {
  for (const bool lists : {false, true}) {
    const Place place = placeOf(levelsAround({}, 0.1, 64, 3, lists), [](const Vec3d&) { return 1e6; }, {});
    EXPECT_TRUE(place.field.distance.empty());
    const HitRecords records = flown(place.field, place.triangles, kSteps, assortedParticles(place.field, 1000));
    EXPECT_EQ(countOf(records, Outcome::Miss), 1000u);
  }
}

TEST(MarchCpu, OnlyWhatIsAskedForIsTouched) {
  const std::unique_ptr<World> world = scatteredWorld();
  for (const bool lists : {false, true}) {
    const auto field = buildField(*world, levelsAround({}, 0.11, 64, 3, lists));
    const Particles particles = assortedParticles(*field, 5003);
    const HitRecords whole = flown(*field, world->baked, kSteps, particles);
    HitRecords some;
    some.reset(particles.size());
    some.travelled.assign(particles.size(), -7);
    std::vector<std::uint32_t> which;
    for (std::uint32_t i = 4999; i > 7; i -= i % 7 + 1) which.push_back(i);
    marchCpu(*field, world->baked, kSteps, particles, which, some);
    std::vector<bool> asked(particles.size());
    for (const std::uint32_t i : which) asked[i] = true;
    for (std::size_t i = 0; i < particles.size(); ++i) {
      ASSERT_EQ(recordOf(some, i), asked[i] ? recordOf(whole, i) : (HitRecord{-7, 0, Outcome::Hit, 0})) << i;
    }
  }
}

// Steps that were taken before count.
TEST(MarchCpu, ParticlesGoOn) {
  const std::unique_ptr<World> world = scatteredWorld();
  for (const bool lists : {false, true}) {
    const auto field = buildField(*world, levelsAround({}, 0.11, 64, 3, lists));
    const Particles particles = assortedParticles(*field, 3000);
    const HitRecords whole = flown(*field, world->baked, 512, particles);
    HitRecords again;
    again.reset(particles.size());
    again.outcome.assign(particles.size(), 4 * 100);
    std::vector<std::uint32_t> all(particles.size());
    std::iota(all.begin(), all.end(), 0u);
    marchCpu(*field, world->baked, 612, particles, all, again);
    EXPECT_EQ(again.travelled, whole.travelled);
    for (std::size_t i = 0; i < particles.size(); ++i) EXPECT_EQ(again.outcome[i], whole.outcome[i] + 4 * 100);
    marchCpu(*field, world->baked, 100, particles, all, again);
    EXPECT_EQ(countOf(again, Outcome::Exhausted), particles.size());
  }
}

// Planes through a field of two levels, by particles from both sides that look towards them.
void forPlanes(bool lists, const std::function<void(const Place&, const Plane&, Particles&)>& check) {
  for (std::uint32_t i = 0; i < 40; ++i) {
    const Vec3d axes[] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    const Plane plane{i < 9 ? axes[i % 3] : anyDirection(20, i), i < 3 ? 0.05 : anyPoint(21, i).x * 0.8};
    const Place place = planePlace(levelsAround({}, 0.1, 64, 2, lists), plane, 9);
    Particles particles;
    for (std::uint32_t k = 0; k < 3000; ++k) {
      const Vec3d origin = anyPoint(22, 3000 * i + k) * 2.5;
      Vec3d direction = k % 50 == 0 ? axes[k / 50 % 3] : anyDirection(23, 3000 * i + k);
      const double towards = dot(direction, plane.normal);
      if (std::fabs(towards) < 0.03) continue;
      if (towards * plane.height(origin) > 0) direction = -direction;
      const double distance = -plane.height(origin) / dot(direction, plane.normal);
      const Vec3d end = origin + direction * (distance + 1);
      if (std::max({std::fabs(end.x), std::fabs(end.y), std::fabs(end.z)}) > 4.5) continue;
      addParticle(place.field, origin, direction, 0, 1e9, particles);
    }
    check(place, plane, particles);
  }
}

Vec3d pointAt(const DistanceField& field, const Particles& p, std::size_t i, double travelled) {
  return field.shape.centre + (Vec3d{p.origin[0][i], p.origin[1][i], p.origin[2][i]} +
                               Vec3d{p.direction[0][i], p.direction[1][i], p.direction[2][i]} * travelled) *
                                  field.shape.voxel;
}

// But for one beam of ten thousand, that a stride takes through.
TEST(March, PlanesAreMetWithinHalfAVoxel) {
  std::size_t all = 0;
  std::size_t met = 0;
  forPlanes(false, [&](const Place& place, const Plane& plane, const Particles& particles) {
    const HitRecords records = flown(place.field, place.triangles, kSteps, particles);
    all += particles.size();
    for (std::size_t i = 0; i < particles.size(); ++i) {
      if (records.outcomeOf(i) != Outcome::Hit) continue;
      ++met;
      const Vec3d point = pointAt(place.field, particles, i, records.travelled[i]);
      const double voxel = voxelSizeAt(place.field, Vec3f((point - place.field.shape.centre) * 10.0));
      ASSERT_LE(std::fabs(plane.height(point)), 0.502 * voxel) << plane.normal.x << ' ' << plane.normal.y;
      ASSERT_LT(records.triangle[i], 2u);
    }
  });
  EXPECT_GT(all, 50000u);
  EXPECT_LE(all - met, all / 10000);
}

TEST(March, PlanesAreMetExactlyByTheirTriangles) {
  forPlanes(true, [](const Place& place, const Plane& plane, const Particles& particles) {
    const HitRecords records = flown(place.field, place.triangles, kSteps, particles);
    for (std::size_t i = 0; i < particles.size(); ++i) {
      ASSERT_EQ(records.outcomeOf(i), Outcome::Hit);
      const double towards =
          dot(plane.normal, Vec3d{particles.direction[0][i], particles.direction[1][i], particles.direction[2][i]});
      const double exact = -plane.height(pointAt(place.field, particles, i, 0)) / towards;
      ASSERT_NEAR(records.travelled[i] * place.field.shape.voxel, exact, 1e-4);
    }
  });
}

TEST(March, SpheresAreMetWhereTheyAre) {
  for (std::uint32_t s = 0; s < 6; ++s) {
    const Vec3d middle = anyPoint(40, s) * 0.3;
    const double radius = 0.5 + 0.3 * s;
    const Place place = placeOf(levelsAround({}, 0.1, 96, 1, false),
                                [&](const Vec3d& p) { return std::fabs(length(p - middle) - radius); }, {});
    Particles particles;
    std::vector<double> passing;  // m, of the line and the sphere's middle
    for (std::uint32_t i = 0; i < 10000; ++i) {
      const Vec3d origin = middle + anyDirection(41, i) * (i % 2 == 0 ? 4.2 : 0.5 * radius);
      const Vec3d direction = normalized(middle + anyDirection(42, i) * (1.2 * radius) - origin);
      addParticle(place.field, origin, direction, 0, 1e9, particles);
      passing.push_back(i % 2 == 0 ? length(cross(middle - origin, direction)) : 0);
    }
    HitRecords records = flown(place.field, place.triangles, kSteps, particles);
    std::size_t hits = 0;
    for (std::size_t i = 0; i < particles.size(); ++i) {
      const double depth = radius - passing[i];
      const Vec3d point = pointAt(place.field, particles, i, records.travelled[i]);
      switch (records.outcomeOf(i)) {
        case Outcome::Miss:
          ASSERT_LT(depth, 0.0) << "particle " << i;
          break;
        case Outcome::Exhausted:
          FAIL() << "particle " << i;
          break;
        case Outcome::Hit:
          ++hits;
          ASSERT_LE(std::fabs(length(point - middle) - radius), 0.07);
          break;
      }
    }
    EXPECT_GT(hits, 7000u);
  }
}

// Sphere tracing towards a plane at an angle a goes from height h to h (1 - sin a) in a step, and rests after
// log(h / rest) / -log(1 - sin a) of them. Our strides are not as long as the height but as a free ball around another
// point. In an empty brick that is at most 4 voxels off along each axis and R >= 8, so that h >= R - 4 and the
// particle, which flies along x, leaves the ball after at most 4 + sqrt(R^2 - (R - h)^2) <= 2.74 h. On the other side,
// half of the height a step on the whole.
TEST(March, GrazingStepsAreBetweenTheClosedForms) {
  constexpr double kHeight = 12;  // voxels
  for (const double plane : {0.0, 0.3, 0.5}) {
    for (const bool lists : {false, true}) {
      FieldShape shape;
      shape.voxel = 0.1;
      shape.reach = 20000;
      shape.lists = lists;
      shape.levels = {{{-1, -1, -1}, {2300, 2, 4}}};
      const Place place = planePlace(shape, {{0, 0, 1}, plane * 0.1}, 2000);
      for (const double angle : {0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0}) {
        const double a = radians(angle);
        for (std::uint32_t i = 0; i < 50; ++i) {
          const Vec3d start = Vec3d{0.3, 0, kHeight * 0.1} + anyPoint(50, i) * 0.1;
          Particles particles;
          addParticle(place.field, start, {std::cos(a), 0, -std::sin(a)}, 0, 1e9, particles);
          const HitRecord record = flownAlone(place.field, place.triangles, 20000, particles, 0);
          ASSERT_EQ(record.outcome, Outcome::Hit) << angle;
          const double logarithm = std::log((start.z * 10 - plane) / kHitDistance);
          const auto closedForm = [&](double heights) {
            return logarithm / -std::log(1 - std::min(heights * std::sin(a), 0.99));
          };
          EXPECT_GE(record.steps, std::floor(closedForm(2.74))) << angle << " degrees";
          EXPECT_LE(record.steps, closedForm(0.5) + 2) << angle << " degrees";
        }
      }
    }
  }
}

TEST(March, AnExhaustedBudgetIsNoMiss) {
  const std::unique_ptr<World> world = scatteredWorld();
  for (const bool lists : {false, true}) {
    const auto field = buildField(*world, levelsAround({}, 0.11, 64, 3, lists));
    const Particles particles = assortedParticles(*field, 3000);
    for (std::size_t i = 0; i < particles.size(); ++i) {
      const HitRecord whole = flownAlone(*field, world->baked, kSteps, particles, i);
      ASSERT_NE(whole.outcome, Outcome::Exhausted);
      for (const std::uint32_t steps : {0u, 1u, whole.steps / 2, whole.steps, whole.steps + 1}) {
        const HitRecord record = flownAlone(*field, world->baked, steps, particles, i);
        // A miss is known only where the next step would begin.
        const bool enough = steps > whole.steps || (steps == whole.steps && whole.outcome != Outcome::Miss);
        ASSERT_EQ(record.outcome, enough ? whole.outcome : Outcome::Exhausted);
        ASSERT_EQ(record.steps, enough ? whole.steps : steps);
        ASSERT_EQ(record.travelled, enough ? whole.travelled : 0);
      }
    }
  }
}

TEST(March, NothingIsMetOutsideOfTheWay) {
  for (const bool lists : {false, true}) {
    const Place place = planePlace(levelsAround({}, 0.1, 64, 2, lists), {{0, 0, 1}, -1.03});
    const Vec3d direction = normalized(Vec3d{0.3, 0.2, -1});
    const double distance = -1.03 / direction.z;
    const auto fly = [&](double begin, double end) {
      Particles particles;
      addParticle(place.field, {}, direction, begin, end, particles);
      return flownAlone(place.field, place.triangles, kSteps, particles, 0);
    };
    for (double begin = 0; begin < distance - 0.06; begin += 0.05) {
      const HitRecord record = fly(begin, 3);
      EXPECT_EQ(record.outcome, Outcome::Hit);
      EXPECT_GE(record.travelled * 0.1f, static_cast<float>(begin));
      EXPECT_NEAR(record.travelled * 0.1, distance, lists ? 1e-4 : 0.06);
    }
    for (double begin = distance + 0.06; begin < 3; begin += 0.05) EXPECT_EQ(fly(begin, 3).outcome, Outcome::Miss);
    for (double end = 0; end < distance - 0.2; end += 0.05) EXPECT_EQ(fly(0, end).outcome, Outcome::Miss);
    for (double end = distance + 0.01; end < 3; end += 0.05) EXPECT_EQ(fly(0, end).outcome, Outcome::Hit);
    EXPECT_EQ(fly(1, 1).outcome, Outcome::Miss);
    EXPECT_EQ(fly(2, 1).outcome, Outcome::Miss);
    EXPECT_EQ(fly(2, 1).steps, 0u);
  }
}

// What starts so near to a surface that it is at rest has landed; with lists it goes on to the surface.
TEST(March, ParticlesMayStartInsideTheHitDistance) {
  for (const bool lists : {false, true}) {
    const Place place = planePlace(levelsAround({}, 0.1, 64, 1, lists), {{0, 0, 1}, 0.02});
    for (const double turn : {-1.0, 1.0}) {
      Particles particles;
      addParticle(place.field, {0.31, -0.2, 0.02 - 0.03 * turn}, {0, 0, turn}, 0, 3, particles);
      const HitRecord record = flownAlone(place.field, place.triangles, kSteps, particles, 0);
      EXPECT_EQ(record.outcome, Outcome::Hit);
      EXPECT_NEAR(record.travelled * 0.1, lists ? 0.03 : 0.0, 1e-5);
    }
  }
}

// A direction that is along an axis but for rounding must not creep along a voxel's face.
TEST(March, NearlyAxisParallelDirectionsTakeNoMoreSteps) {
  for (const bool lists : {false, true}) {
    const Place place = planePlace(levelsAround({}, 0.1, 64, 1, lists), {{0, 0, 1}, 0.03});
    for (const double tiny : {-1e-10, -1e-13, -1e-17, 0.0, 1e-17, 1e-13}) {
      Particles particles;
      addParticle(place.field, {0.15, -1.05, 0.13}, {tiny, 1, 0}, 0, 2, particles);
      const HitRecord record = flownAlone(place.field, place.triangles, kSteps, particles, 0);
      EXPECT_EQ(record.outcome, Outcome::Miss);
      EXPECT_LT(record.steps, 60u) << tiny;
    }
  }
}

}  // namespace
}  // namespace scanmill
