// Boxes of things and what sensors see of them, from a pipeline to a dataset.

#include "dataset/objects.h"

#include "dataset/scan_store.h"
#include "tests/core/pipeline/small_world.h"

namespace scanmill {
namespace {

const std::string kAsked = "output.objects=true";
const std::string kFine =
    "sensors=[{name: top, columns: 720, rate_hz: 10, elevation_deg: {top: 5, bottom: -25, rings: 32}, range_m: [0.5, "
    "100], mount: {position: [0, 0, 1.8]}, divergence_mrad: 3, pulse_ns: 5}]";

class ObjectsRun : public Yard {
 protected:
  std::vector<SampleObjects> lists(const std::string& name = "out") const {
    const ScanStore store(out(name));
    std::vector<SampleObjects> all;
    for (std::size_t i = 0; i < store.keys().size(); ++i) {
      const std::optional<SampleObjects> objects = store.objects(i);
      EXPECT_TRUE(objects.has_value()) << store.keys()[i];
      if (objects) all.push_back(*objects);
    }
    return all;
  }

  // In place of the two cars.
  void stand(const std::string& objects) {
    std::string scene = yardScene();
    scene.resize(scene.find("  - name: car"));
    folder_.write("scenes/yard.yaml", scene + objects);
  }
};

const ObjectRecord* find(const SampleObjects& sample, const std::string& name) {
  for (const ObjectRecord& object : sample.objects) {
    if (object.name.starts_with(name)) return &object;
  }
  return nullptr;
}

std::string box(const std::string& name, const std::string& more) {
  return "  - {name: " + name + ", primitive: box, size: [4, 2, 1.5], class: car, material: painted_metal, " + more +
         "}\n";
}

TEST_F(ObjectsRun, BoxesAreThoseOfTheSceneWhateverIsSeen) {
  const Manifest m = sound({kAsked, kFine});
  ASSERT_EQ(lists().size(), 4u);
  for (const SampleObjects& sample : lists()) {
    ASSERT_EQ(sample.objects.size(), 2u) << "floor and walls are no things";
    double y = 5;
    for (const ObjectRecord& car : sample.objects) {
      EXPECT_NEAR(length(car.worldFromBox.translation - Vec3d{8, y, 0.75}), 0, 1e-4);
      EXPECT_NEAR(length(car.size - Vec3d{4, 2, 1.5}), 0, 1e-4);
      EXPECT_TRUE(car.headingKnown);
      EXPECT_FALSE(car.moves);
      EXPECT_EQ(car.velocity, Vec3d{});
      EXPECT_EQ(car.semantic, m.ontology.require("car", {}).id);
      ASSERT_EQ(car.views.size(), 1u);
      EXPECT_EQ(car.views[0].visibility(), 1) << "nothing stands before it";
      EXPECT_EQ(car.views[0].beams, car.views[0].points) << "no effect takes or adds any";
      EXPECT_EQ(car.views[0].truncation, 0);
      y = -y;
    }
  }
  const std::uint16_t car = m.ontology.require("car", {}).id;
  ASSERT_TRUE(m.samples[0].objects.has_value());
  EXPECT_EQ(*m.samples[0].objects, (std::map<std::uint16_t, ObjectCount>{{car, {2, 2}}}));
}

TEST_F(ObjectsRun, WhatIsHiddenIsListedAndHalfIsHalf) {
  stand(
      box("hidden", "position: [20, 0, 0.75]") + box("half", "position: [8, 5, 0.75]") +
      "  - {name: screen, primitive: box, size: [0.1, 4, 6], class: wall, material: brick, position: [14, 0, 3]}\n"
      // Seen from the origin, the half's face towards the sensor lies between y = 4 and 6 at x = 6: at x = 3 between
      // 2 and 3.
      "  - {name: post, primitive: box, size: [0.02, 0.5, 8], class: wall, material: brick, position: [3, 2.25, 4]}\n");
  sound({kAsked, kFine, "trajectories=[{name: still, poses: [{position: [0, 0, 0]}]}]"});
  const SampleObjects sample = lists().at(0);
  const ObjectRecord* hidden = find(sample, "hidden");
  ASSERT_NE(hidden, nullptr);
  EXPECT_EQ(hidden->views[0].points, 0u);
  EXPECT_GT(hidden->views[0].beamsAlone, 20u);
  EXPECT_EQ(hidden->views[0].visibility(), 0);
  EXPECT_FALSE(hidden->views[0].nearestRange.has_value());
  const ObjectRecord* half = find(sample, "half");
  ASSERT_NE(half, nullptr);
  EXPECT_GT(*half->views[0].visibility(), 0.4);
  EXPECT_LT(*half->views[0].visibility(), 0.8);
  const auto car = readManifest(out()).ontology.require("car", {}).id;
  EXPECT_EQ(readManifest(out()).samples[0].objects->at(car), (ObjectCount{2, 1}));
}

TEST_F(ObjectsRun, ListRoadUsersUnlessOtherClassesAreNamed) {
  stand(box("car", "position: [8, 5, 0.75]") +
        "  - {name: bench, primitive: box, size: [2, 1, 1], class: object, material: wood, position: [8, -5, 0.5]}\n");
  const auto names = [&](const std::string& key, const std::string& folder) {
    const Manifest manifest = sound({key, kFine}, folder);
    const auto& classes = manifest.objectClasses;
    const std::uint16_t bench = manifest.ontology.require("object", {}).id;
    std::vector<std::string> listed;
    const SampleObjects sample = lists(folder).at(0);
    for (const ObjectRecord& object : sample.objects) listed.push_back(object.name);
    EXPECT_EQ(classes.empty() || std::ranges::find(classes, bench) != classes.end(),
              std::ranges::find(listed, "bench") != listed.end());
    return listed;
  };
  EXPECT_THAT(names(kAsked, "asked"), testing::ElementsAre("car"));
  EXPECT_THAT(names("output.objects={classes: all}", "all"), testing::ElementsAre("car", "bench"));
  EXPECT_THAT(names("output.objects={classes: [other-object]}", "bench"), testing::ElementsAre("bench"));
  EXPECT_THAT(refusal({"output.objects={classes: [bench]}"}), HasSubstr("no class 'bench'"));
  EXPECT_THAT(refusal({"output.objects={classes: [wall]}"}), HasSubstr("has no objects"));
  EXPECT_THAT(refusal({"output.objects=all"}), HasSubstr("{classes: all}"));
}

// Points lie on the box, in the frame that they are given in, while sensor and thing move.
TEST_F(ObjectsRun, BoxesFitThePointsOfWhatMoves) {
  stand(box("ahead", "position: [8, 5, 0.75], moving: {velocity: [5, 0, 0]}") +
        box("aside", "position: [8, -9, 0.75], yaw_deg: 30, moving: {velocity: [0, 3, 0]}"));
  for (const char* motion : {"motion=none", "motion=per_column", "motion={steps: per_column, deskew: true}"}) {
    SCOPED_TRACE(motion);
    const std::string name = std::string("out") + std::to_string(std::string(motion).size());
    sound({kAsked, kFine, motion}, name);
    const std::vector<SampleObjects> samples = lists(name);
    const std::vector<Scan> clouds = scans(".pcd", name);
    ASSERT_EQ(samples.size(), clouds.size());
    std::size_t points = 0;
    for (std::size_t s = 0; s < samples.size(); ++s) {
      for (const ObjectRecord& object : samples[s].objects) {
        EXPECT_TRUE(object.moves);
        EXPECT_NEAR(length(object.velocity), object.name.starts_with("ahead") ? 5 : 3, 1e-3);
        const Pose boxFromSensor = inverse(object.views.at(0).sensorFromBox);
        // What it and the sensor's turn move while the beams pass over it.
        const double slack = std::string(motion) == "motion=none" ? 2e-3 : 0.15;
        for (std::size_t i = 0; i < clouds[s].size(); ++i) {
          if (clouds[s][kInstance][i] != object.id) continue;
          ++points;
          const Vec3d p = boxFromSensor * Vec3d(clouds[s].position[i]);
          ASSERT_LE(std::abs(p.x), object.size.x / 2 + slack);
          ASSERT_LE(std::abs(p.y), object.size.y / 2 + slack);
          ASSERT_LE(std::abs(p.z), object.size.z / 2 + slack);
        }
      }
    }
    EXPECT_GT(points, 200u);
  }
}

TEST_F(ObjectsRun, WhatTheFieldCutsOffIsTruncated) {
  stand(box("across", "position: [10, 10, 0.75], yaw_deg: 45") + box("inside", "position: [20, 0, 0.75]") +
        box("behind", "position: [-20, 0, 0.75]"));
  sound({kAsked, "trajectories=[{name: still, poses: [{position: [0, 0, 0]}]}]",
         "sensors=[{name: front, columns: 360, rate_hz: 10, first_azimuth_deg: -45, field_deg: 90, elevation_deg: "
         "{top: 15, bottom: -25, rings: "
         "128}, range_m: [0.5, 100], mount: {position: [0, 0, 1.8]}}]"});
  const SampleObjects sample = lists().at(0);
  EXPECT_EQ(find(sample, "inside")->views[0].truncation, 0);
  EXPECT_EQ(find(sample, "behind")->views[0].truncation, 1);
  EXPECT_EQ(find(sample, "behind")->views[0].visibility(), std::nullopt);
  EXPECT_NEAR(find(sample, "across")->views[0].truncation, 0.5, 0.15) << "its middle lies on the field's edge";
}

TEST_F(ObjectsRun, AWideBeamCountsByItsAxis) {
  sound({kAsked, kFine, "effects=[intensity, footprint: {rays: 7}]"});
  for (const SampleObjects& sample : lists()) {
    for (const ObjectRecord& car : sample.objects) EXPECT_EQ(car.views[0].visibility(), 1);
  }
}

TEST_F(ObjectsRun, EveryMethodCountsTheSame) {
  sound({kAsked, kFine});
  const std::vector<SampleObjects> exact = lists();
  for (const char* method : {"method={particle: {voxel_m: 0.1}}", "method={ray_tracing: {simplify: 0.9}}"}) {
    SCOPED_TRACE(method);
    const std::string name = std::string("out") + method[8];
    sound({kAsked, kFine, method}, name);
    const std::vector<SampleObjects> other = lists(name);
    for (std::size_t s = 0; s < exact.size(); ++s) {
      ASSERT_EQ(other[s].objects.size(), exact[s].objects.size());
      for (std::size_t i = 0; i < exact[s].objects.size(); ++i) {
        EXPECT_EQ(other[s].objects[i].views[0].beamsAlone, exact[s].objects[i].views[0].beamsAlone);
        EXPECT_NEAR(other[s].objects[i].views[0].beams, exact[s].objects[i].views[0].beams,
                    5 + 0.02 * exact[s].objects[i].views[0].beams);
      }
    }
  }
}

TEST_F(ObjectsRun, CostNothingWhereNobodyAsks) {
  const Manifest m = sound({"output.columns=[label, ring]", "effects=[]"});
  for (const auto& [name, bytes] : members()) EXPECT_FALSE(name.ends_with(".objects.json"));
  EXPECT_FALSE(m.samples[0].objects.has_value());
  EXPECT_EQ(toJson(m).find("\"with_points\""), std::string::npos);
  EXPECT_FALSE(planOf({"output.columns=[label]"}).channels.has(Channel::Instance));
  EXPECT_TRUE(planOf({"output.columns=[label]", kAsked}).channels.has(Channel::Instance));
}

TEST_F(ObjectsRun, WrongListsAreFound) {
  sound({kAsked});
  const Manifest m = readManifest(out());
  const std::string file = (out() / m.shards[0].file).string();
  std::string bytes = readFile(file);
  const std::size_t place = bytes.find("\"points\": ", bytes.find("\"objects\": ")) + 10;
  bytes[place] = bytes[place] == '9' ? '8' : '9';
  folder_.write("out/" + m.shards[0].file, bytes);
  EXPECT_THAT(testing::PrintToString(verifyDataset(out()).problems), HasSubstr("points of the object"));
}

}  // namespace
}  // namespace scanmill
