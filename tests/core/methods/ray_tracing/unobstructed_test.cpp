#include "methods/ray_tracing/unobstructed.h"

#include "methods/ray_tracing/filter.h"
#include "tests/core/methods/trace.h"
#include "tests/support/street.h"
#include "tests/support/test_scene.h"

namespace scanmill {
namespace {

struct Counter {
  explicit Counter(const Scene& counted)
      : method(rayTracing(counted)),
        boxes(counted),
        worlds(counted, Instancing::Auto, {.occlusionFilter = thingFilter}),
        unobstructed(worlds, boxes) {}

  std::uint32_t beamsOn(std::size_t thing, const Shot& shot) const {
    const BeamGrid grid(*shot.beams);
    const std::uint32_t beams = unobstructed.viewOf(thing, unobstructed.sightOf(shot, grid)).beams;
    // Known hits spare rays, and change nothing but beams that graze an edge.
    Hits met;
    method->trace(shot, Channels(Channel::Range) | Channel::Instance, met);
    EXPECT_NEAR(unobstructed.viewOf(thing, unobstructed.sightOf(shot, grid, &met)).beams, beams, 1 + beams / 500);
    return beams;
  }

  std::unique_ptr<Method> method;
  ThingBoxes boxes;
  Worlds worlds;
  Unobstructed unobstructed;
};

std::uint32_t hitsOn(const Scene& scene, const Shot& shot, std::uint32_t id) {
  Hits hits;
  rayTracing(scene)->trace(shot, Channels(Channel::Range) | Channel::Instance, hits);
  return static_cast<std::uint32_t>(std::count(hits.instance.begin(), hits.instance.end(), id));
}

// The scene with nothing but one thing, which keeps its id.
Scene alone(const Scene& scene, std::uint32_t id) {
  Scene only = scene;
  std::erase_if(only.instances, [&](const Instance& instance) {
    const Mesh& mesh = scene.meshes[instance.mesh];
    return id < instance.firstInstanceId || id >= instance.firstInstanceId + mesh.objects;
  });
  for (Mesh& mesh : only.meshes) {
    Mesh kept = mesh;
    kept.triangles.clear();
    kept.surfaceOf.clear();
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
      const bool own = std::any_of(only.instances.begin(), only.instances.end(), [&](const Instance& instance) {
        return instanceId(instance, mesh.surfaces[mesh.surfaceOf[t]]) == id;
      });
      if (!own) continue;
      kept.triangles.push_back(mesh.triangles[t]);
      kept.surfaceOf.push_back(mesh.surfaceOf[t]);
    }
    mesh = std::move(kept);
  }
  return only;
}

void expectSame(const Scene& scene, const Shot& shot, std::size_t thing, const Counter& counter) {
  const std::uint32_t id = counter.boxes.things()[thing].id;
  const std::uint32_t expected = hitsOn(alone(scene, id), shot, id);
  // Beams that graze an edge are decided by the last digits of float32, which differ with the world's origin.
  EXPECT_NEAR(counter.beamsOn(thing, shot), expected, 2 + expected / 200) << counter.boxes.things()[thing].name;
}

TEST(Unobstructed, SeesThroughWhatStandsBefore) {
  SceneBuilder builder = testBuilder();
  Mesh box = meshOf(builder, "thing");
  appendBox(box, 0, {}, {2, 2, 2});
  const std::uint32_t thing = builder.addMesh(box);
  builder.place(thing, at(10, 0, 0), "hidden");
  builder.place(thing, at(-10, 0, 0), "free");
  builder.place(thing, at(0, 2000, 0), "too far");
  builder.place(thing, at(0, 0, 30), "overhead");
  Mesh wall = meshOf(builder, "ground");
  appendBox(wall, 0, at(5, 0, 0), {0.1, 20, 20});
  builder.place(builder.addMesh(wall), {}, "wall");
  const Scene scene = builder.finish();
  const Counter counter(scene);
  const Shot shot = shotAt(spinning(32, 1024, -20, 20, 100));
  EXPECT_EQ(hitsOn(scene, shot, 1), 0u);
  EXPECT_GT(counter.beamsOn(0, shot), 300u);
  EXPECT_EQ(counter.beamsOn(1, shot), hitsOn(scene, shot, 2));
  EXPECT_EQ(counter.beamsOn(2, shot), 0u) << "beyond the range";
  EXPECT_EQ(counter.beamsOn(3, shot), 0u) << "beside the field";
  for (const std::size_t i : {0u, 1u}) expectSame(scene, shot, i, counter);
}

TEST(Unobstructed, CountsNoBeamsThatWhatIsTooNearHides) {
  const auto fill = [](Mesh& mesh) {
    appendBox(mesh, 0, at(0.5, 0, 0), {0.01, 0.2, 0.2});
    appendBox(mesh, 0, at(5, 0, 0), {1, 10, 10});
  };
  const Scene scene = oneMeshScene("thing", fill);
  auto beams = std::make_shared<BeamTable>(*spinning(32, 1024, -20, 20, 100));
  beams->minRange = 1;
  const Counter counter(scene);
  expectSame(scene, shotAt(beams), 0, counter);
  EXPECT_GT(counter.beamsOn(0, shotAt(beams)), 100u);
}

TEST(Unobstructed, MeetsWhatMovesWhereItIs) {
  SceneBuilder builder = testBuilder();
  Mesh box = meshOf(builder, "thing");
  appendBox(box, 0, {}, {2, 2, 2});
  const std::uint32_t thing = builder.addMesh(box);
  builder.place(thing, at(8, 0, 0), "crossing", {}, std::make_shared<const Movement>(Vec3d{0, 30, 0}));
  builder.place(thing, at(-8, 3, 0), "standing");
  const Scene scene = builder.finish();
  const Counter counter(scene);
  const auto beams = spinning(32, 1024, -20, 20, 100);
  Shot shot = shotAt(beams);
  shot.time = 0.1;
  shot.duration = 0.1;
  for (const std::size_t i : {0u, 1u}) expectSame(scene, shot, i, counter);
  // The sensor moves, too.
  shot.worldFromSensor.clear();
  for (int step = 0; step < 64; ++step) {
    shot.worldFromSensor.push_back({fromYawPitchRoll(0.002 * step, 0, 0), {0.03 * step, 0, 0}});
  }
  for (const std::size_t i : {0u, 1u}) expectSame(scene, shot, i, counter);
}

TEST(Unobstructed, OfTheStreetIsWhatEachThingAloneWouldGive) {
  const Scene scene = proceduralStreet();
  const Counter counter(scene);
  const Shot shot = streetShot(presetBeams("vlp_16"), 0);
  Hits hits;
  rayTracing(scene)->trace(shot, Channels(Channel::Range) | Channel::Instance, hits);
  std::size_t compared = 0;
  for (std::size_t thing = 0; thing < counter.boxes.things().size(); ++thing) {
    const auto seen = static_cast<std::uint32_t>(
        std::count(hits.instance.begin(), hits.instance.end(), counter.boxes.things()[thing].id));
    const std::uint32_t free = counter.beamsOn(thing, shot);
    EXPECT_LE(seen, free + 2 + free / 200) << counter.boxes.things()[thing].name;
    if (free > 20 && compared < 12) {
      ++compared;
      expectSame(scene, shot, thing, counter);
    }
  }
  EXPECT_EQ(compared, 12u);
}

}  // namespace
}  // namespace scanmill
