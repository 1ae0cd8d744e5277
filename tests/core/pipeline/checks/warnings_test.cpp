#include "pipeline/checks/warnings.h"

#include <fmt/format.h>

#include "pipeline/read/pipeline.h"
#include "scenefile/scene_file.h"
#include "sensors/trajectory.h"
#include "tests/support/temporary_folder.h"

namespace scanmill {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

TEST(UnlabeledWarnings, TellHowMuchHasNoClass) {
  Scene scene;
  EXPECT_THAT(unlabeledWarnings(scene), IsEmpty());
  scene.name = "yard";
  scene.unlabeled = {{{"bus.obj", "glass", "", "pane"}, 1200}, {{"bus.obj", "paint", "", "body"}, 34}};
  EXPECT_THAT(unlabeledWarnings(scene),
              ElementsAre(AllOf(HasSubstr("scene yard"), HasSubstr("1,234 triangles of bus.obj:"))));
  scene.unlabeled[{"mast.obj", "", "", ""}] = 1;
  EXPECT_THAT(unlabeledWarnings(scene), ElementsAre(HasSubstr("1,235 triangles of bus.obj and 1 more:")));
}

TEST(DamageWarnings, TellOfCornersThatAreNoPlaces) {
  Scene scene;
  scene.name = "yard";
  scene.dropped.degenerate = 7;  // as most files have
  EXPECT_THAT(damageWarnings(scene), IsEmpty());
  scene.dropped.nonFinite = 1;
  scene.dropped.outOfRange = 2000;
  EXPECT_THAT(
      damageWarnings(scene),
      ElementsAre("scene yard: 1 triangle is left out because of corners that are NaN or infinite: is a file damaged?",
                  "scene yard: 2,000 triangles are left out because of corner indices that are out of range: is a file "
                  "damaged?"));
}

TEST(RuleWarnings, NameRulesThatDecideNothing) {
  Scene scene;
  const auto add = [&](int line, const char* match, std::uint64_t matched, std::uint64_t decided) {
    RuleUse use;
    use.where = Location{"s.yaml", line, 5};
    use.match = match;
    use.matched = matched;
    use.decided = decided;
    scene.rules.push_back(use);
  };
  add(3, "node: Wall*", 10, 4);
  add(4, "node: Wal", 0, 0);
  add(5, "material: brick", 7, 0);
  EXPECT_THAT(ruleWarnings(scene),
              ElementsAre(AllOf(HasSubstr("s.yaml:4"), HasSubstr("node: Wal"), HasSubstr("matches nothing")),
                          AllOf(HasSubstr("s.yaml:5"), HasSubstr("material: brick"), HasSubstr("7"))));
  for (int line = 6; line < 40; ++line) add(line, "node: Wal", 0, 0);
  ASSERT_EQ(ruleWarnings(scene).size(), 6u);
  EXPECT_THAT(ruleWarnings(scene).back(), HasSubstr("31 more rules match nothing or have no effect"));
}

// A town without a side road is no mistake of the user, unless all towns are such.
TEST(DriveWarnings, TellIfNoDriveTurns) {
  const auto drives = [](const std::string& seeds) {
    return readPipeline(SCANMILL_SOURCE_DIR "/pipelines/training.yaml", {"scenes.0.seeds=" + seeds, "splits=null"});
  };
  const Pipeline several = drives("[1, 2, 3, 4]");
  EXPECT_THAT(driveWarnings(several), IsEmpty());
  const auto straight = std::find_if(several.sequences.begin(), several.sequences.end(),
                                     [](const Sequence& s) { return s.trajectory->turns() == 0; });
  ASSERT_NE(straight, several.sequences.end());
  EXPECT_THAT(driveWarnings(drives(fmt::format("[{}]", straight->sceneSeed))),
              ElementsAre(HasSubstr("no drive with `along: turns` turns")));
}

TEST(SizeWarnings, TellOfWrongUnits) {
  Scene scene;
  scene.name = "depot";
  const auto add = [&](const char* name, float longest, std::uint32_t object) {
    Mesh mesh;
    mesh.positions = {{0, 0, 0}, {longest, 0, 0}, {0, longest / 3, 0}};
    mesh.triangles = {{0, 1, 2}};
    mesh.surfaceOf = {0};
    mesh.surfaces.resize(1);
    mesh.surfaces[0].object = mesh.objects = object;
    scene.instances.push_back({static_cast<std::uint32_t>(scene.meshes.size()), {}, 0, name});
    scene.meshes.push_back(mesh);
  };
  add("car", 4.5f, 1);
  add("terrain", 4000, 0);
  EXPECT_THAT(sizeWarnings(scene), IsEmpty());
  add("toy", 0.005f, 1);
  add("bus", 1200, 1);
  add("plain", 6000, 0);
  EXPECT_THAT(sizeWarnings(scene), ElementsAre(HasSubstr("scene depot: the object 'toy' measures 0.005 m"),
                                               HasSubstr("'bus' measures 1.2 km"), HasSubstr("'plain' measures 6 km")));
  for (int i = 0; i < 20; ++i) add("mite", 1e-4f, 0);
  EXPECT_THAT(sizeWarnings(scene).back(), HasSubstr("18 more"));
}

// Three cars in a file of 100 m, of which `instances: node` makes three things.
TEST(RuleWarnings, TellOfTownsWhoseCarsAreOne) {
  Scene scene;
  scene.name = "depot";
  scene.ontology.classes = {{0, "unlabeled", {0, 0, 0}, false, {}}, {1, "car", {0, 0, 255}, true, {}}};
  Mesh mesh;
  mesh.name = "town.glb";
  mesh.positions = {{0, 0, 0}, {100, 0, 0}, {0, 1, 0}};
  mesh.triangles = {{0, 1, 2}};
  mesh.surfaceOf = {0};
  for (const char* const node : {"car_1", "car_2", "car_3"}) {
    Surface s;
    s.semantic = 1;
    s.object = 1;
    s.node = node;
    mesh.surfaces.push_back(s);
  }
  mesh.objects = 1;
  scene.meshes = {mesh};
  EXPECT_THAT(ruleWarnings(scene), ElementsAre(AllOf(HasSubstr("depot"), HasSubstr("3 nodes of the class car"),
                                                     HasSubstr("town.glb"), HasSubstr("instances: node"))));
  for (std::uint32_t i = 0; i < 3; ++i) scene.meshes[0].surfaces[i].object = i + 1;
  scene.meshes[0].objects = 3;
  EXPECT_THAT(ruleWarnings(scene), IsEmpty());
  scene.meshes[0] = mesh;
  scene.meshes[0].positions[1] = {5, 0, 0};
  EXPECT_THAT(ruleWarnings(scene), IsEmpty()) << "one car of several nodes";
}

}  // namespace
}  // namespace scanmill
