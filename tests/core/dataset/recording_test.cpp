#include "dataset/recording.h"

#include "base/file.h"
#include "tests/support/message_of.h"
#include "tests/support/temporary_folder.h"

namespace scanmill {
namespace {

Recording example() {
  Recording r;
  r.kind = RecordingKind::Passes;
  r.programVersion = "0.1.0";
  r.method = "depth_camera";
  r.ontology.name = "two";
  r.ontology.classes = {{0, "unlabeled", {0, 0, 0}, false, {}}, {7, "car", {1, 2, 3}, true, {"auto"}}};
  r.sensors = {{"top", 4, 16, std::string(64, 'a'), Pose{{0.6, 0, 0.8, 0}, {1.0 / 3, 0, 1e-9}}}};
  r.sequences = {{"street", 5, "Lane A", 2, 0}, {"yard", 1, "t0", 1, 1}};
  Material shiny;
  shiny.name = "chrome";
  shiny.roughness = 0.1f;
  shiny.metallic = 1;
  shiny.retroreflectance = 0.25f;
  r.materials = {{shiny}, {Material{}, shiny}};
  r.modelled = {{"geometry", "as the camera sees it"}};
  return r;
}

TEST(Recording, ComesBackAsItWent) {
  const TemporaryFolder folder;
  RecordingWriter writer(folder.path() / "r", false);
  RecordedShot shot{"street-s5-lane_a-000001", "top", 0.1, {{{1, 0, 0, 0}, {1e7 + 0.1, -2, 1.0 / 3}}}, "", {}};
  shot.steps = {{0, 10, {{0.6, 0, 0.8, 0}, {1, 2, 3}}, {"a.exr", "b.exr"}},
                {10, 16, {{1, 0, 0, 0}, {0.1, 0.2, 0.3}}, {"c.exr"}}};
  writer.add(shot);
  writer.finish(example());
  const Recording r = readRecording(folder.path() / "r", RecordingKind::Passes);
  EXPECT_EQ(r.method, "depth_camera");
  EXPECT_EQ(r.sensors[0].beams, std::string(64, 'a'));
  EXPECT_EQ(r.sensors[0].vehicleFromSensor, example().sensors[0].vehicleFromSensor);
  ASSERT_EQ(r.ontology.classes.size(), 2u);
  EXPECT_EQ(r.ontology.classes[1].name, "car");
  ASSERT_EQ(r.sequences.size(), 2u);
  EXPECT_EQ(r.sequences[0].trajectory, "Lane A");
  EXPECT_EQ(r.sequences[1].materials, 1u);
  ASSERT_EQ(r.materials[1].size(), 2u);
  EXPECT_EQ(r.materials[1][1].roughness, 0.1f);
  EXPECT_EQ(r.materials[1][1].retroreflectance, 0.25f);
  EXPECT_EQ(r.modelled, example().modelled);
  const RecordedShot back = r.shot(shot.sample, "top");
  EXPECT_EQ(back.time, 0.1);
  EXPECT_EQ(back.worldFromSensor, shot.worldFromSensor);  // to the last bit
  ASSERT_EQ(back.steps.size(), 2u);
  EXPECT_EQ(back.steps[0].worldFromRig, shot.steps[0].worldFromRig);
  EXPECT_EQ(back.steps[1].firstColumn, 10u);
  EXPECT_EQ(back.steps[0].images, shot.steps[0].images);
}

// The least that is needed.
const std::string kHead = R"({"what": "scanmill recording", "schema_version": 1, "kind": "passes", )";
const std::string kSensors = R"("sensors": [{"name": "top", "rings": 2, "columns": 8}], "sequences": )";
const std::string kSequence = R"({"scene": "a", "trajectory": "t", "frames": 1})";

// What somebody writes whose renderer is not ours.
TEST(Recording, TheLeastThatIsNeeded) {
  const TemporaryFolder folder;
  folder.write("recording.json", kHead + kSensors + "[" + kSequence + "]}");
  folder.write("a-s1-t-000000.top.json", R"({"time": 0, "world_from_sensor": [[1, 0, 0, 0, 5, 6, 7]],
    "steps": [{"columns": [0, 8], "images": ["front.exr"]}]})");
  const Recording r = readRecording(folder.path(), RecordingKind::Passes);
  EXPECT_EQ(r.method, "depth_camera");
  EXPECT_TRUE(r.ontology.classes.empty());
  EXPECT_EQ(r.materials.size(), 1u);
  const RecordedShot shot = r.shot("a-s1-t-000000", "top");
  EXPECT_EQ(shot.steps[0].worldFromRig.translation, (Vec3d{5, 6, 7}));
}

TEST(Recording, BadIndexesAreNamed) {
  const TemporaryFolder folder;
  const auto refused = [&](const std::string& text, const std::vector<std::string>& words) {
    folder.write("recording.json", text);
    expectInputError([&] { readRecording(folder.path(), RecordingKind::Passes); }, words);
  };
  refused("", {"recording.json", "not complete JSON"});
  refused("[]", {"is not a recording"});
  refused(R"({"what": "else"})", {"is not a recording"});
  refused(kHead + R"("sequences": []})", {"'sensors' is missing"});
  refused(kHead + R"("sensor": []})", {"'sensor' is unknown", "sensors"});
  refused(kHead + kSensors + "[]}", {"/sequences", "nothing was recorded"});
  refused(kHead + kSensors + R"([{"scene": "A/b", "trajectory": "t", "frames": 1}]})", {"/sequences/0/scene", "'A/b'"});
  refused(kHead + kSensors + R"([{"scene": "a", "trajectory": "t", "frames": 0}]})", {"/sequences/0/frames"});
  refused(kHead + kSensors + R"([{"scene": "a", "trajectory": "t", "frames": 1, "materials": 1}]})",
          {"/sequences/0/materials", "0 tables"});
  refused(kHead + kSensors + "[" + kSequence + "," + kSequence + "]}", {"/sequences/1", "twice"});
  refused(kHead + R"("sensors": [{"name": "top", "rings": 2, "columns": 8}, {"name": "top", "rings": 2, "columns": 8}],
                  "sequences": []})",
          {"/sensors/1/name", "\"top\""});
  refused(R"({"what": "scanmill recording", "schema_version": 1, "kind": "pases", "sensors": [], "sequences": []})",
          {"/kind", "'pases'"});
  std::string newer = kHead + kSensors + "[" + kSequence + "]}";
  newer.replace(newer.find("version\": 1"), 11, "version\": 9");
  refused(newer, {"/schema_version", "newer"});
}

TEST(Recording, HashesTellBeamsApart) {
  BeamTable beams;
  beams.direction = {{1, 0, 0}, {0, 1, 0}};
  beams.maxRange = 100;
  const std::string hash = beamsHash(beams);
  EXPECT_EQ(beamsHash(beams), hash);
  BeamTable other = beams;
  other.time = {0, 1};  // what was met does not depend on it
  EXPECT_EQ(beamsHash(other), hash);
  other.direction[1].x = 1e-17;
  EXPECT_NE(beamsHash(other), hash);
  other = beams;
  other.origin = {{0, 0, 0}, {0, 0, 0.1f}};
  EXPECT_NE(beamsHash(other), hash);
  other = beams;
  other.maxRange = 101;
  EXPECT_NE(beamsHash(other), hash);
}

TEST(Recording, StepsFollowEachOther) {
  const TemporaryFolder folder;
  folder.write("recording.json", kHead + kSensors + "[" + kSequence + "]}");
  const Recording r = readRecording(folder.path(), RecordingKind::Passes);
  const auto refused = [&](const std::string& steps, const std::vector<std::string>& words) {
    folder.write("k.top.json",
                 R"({"time": 0, "world_from_sensor": [[1, 0, 0, 0, 0, 0, 0]], "steps": [)" + steps + "]}");
    expectInputError([&] { r.shot("k", "top"); }, words);
  };
  refused(R"({"columns": [1, 8], "images": ["a.exr"]})", {"/steps/0/columns", "first = 0"});
  refused(R"({"columns": [0, 0], "images": ["a.exr"]})", {"/steps/0/columns"});
  refused(R"({"columns": [0, 2.5], "images": ["a.exr"]})", {"/steps/0/columns"});
  refused(R"({"columns": [0, 4], "images": ["a.exr"]})", {"/steps", "end at column 4", "has 8"});
  refused(R"({"columns": [0, 8], "images": []})", {"/steps/0/images", "no file"});
  refused(R"({"columns": [0, 8], "images": ["/etc/a.exr"]})", {"/steps/0/images/0"});
}

}  // namespace
}  // namespace scanmill
