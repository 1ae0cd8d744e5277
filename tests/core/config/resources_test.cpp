// Where paths and names lead.

#include "config/resources.h"

#include <cstdlib>

#include "config/fields.h"
#include "tests/support/message_of.h"
#include "tests/support/temporary_folder.h"

namespace scanmill {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;

// A project and a current folder apart from it, and files that come with the program.
class Resources : public testing::Test {
 protected:
  Resources() {
    folder_.write("share/pipelines/sensors/os1_128.yaml", "columns: 1\n");
    folder_.write("share/labels/semantic_kitti.yaml", "classes: []\n");
    folder_.write("share/labels/materials.yaml", "materials: []\n");
    folder_.write("share/scenes/street.yaml", "objects: []\n");
    folder_.write("secret.yaml", "a: 1\n");
    folder_.write("project/own/yard.yaml", "objects: []\n");
    folder_.write("current/own/town.yaml", "objects: []\n");
    ::setenv("SCANMILL_RESOURCES", (folder_.path() / "share").c_str(), 1);
    std::filesystem::current_path(folder_.path() / "current");
    root_ = parseYaml("first: 1\nfile: x\n", (folder_.path() / "project/p.yaml").string());
  }
  ~Resources() override {
    ::unsetenv("SCANMILL_RESOURCES");
    std::filesystem::current_path(here_);
  }

  // Relative to the test's folder, where it is below.
  std::string found(const std::string& name, const std::string& subfolder) {
    Value root = root_;
    root.entries[1].value.text = name;
    return relative(Fields(root, "test").resource("file", subfolder));
  }
  std::string foundBySet(const std::string& name, const std::string& subfolder) {
    Value root = root_;
    setValue(root, "file=" + name);
    return relative(Fields(root, "test").resource("file", subfolder));
  }
  std::string relative(const std::filesystem::path& path) const {
    return path.is_absolute() ? path.lexically_relative(folder_.path()).string() : "./" + path.string();
  }

  std::filesystem::path here_ = std::filesystem::current_path();
  TemporaryFolder folder_;
  Value root_;
};

TEST_F(Resources, OptionsNameFilesToo) {
  EXPECT_EQ(relative(namedResource("semantic_kitti", "labels")), "share/labels/semantic_kitti.yaml");
  EXPECT_EQ(relative(namedResource("own/town.yaml", "scenes")), "./own/town.yaml");
  EXPECT_THAT(messageOf<InputError>([] { namedResource("semantic_kity", "labels"); }), HasSubstr("semantic_kitti"));
}

TEST_F(Resources, NamesOfTheProgramsFilesAreKnownEverywhere) {
  for (const std::string name : {"os1_128", "os1_128.yaml", "sensors/os1_128", "sensors/os1_128.yaml"}) {
    EXPECT_EQ(found(name, "pipelines/sensors"), "share/pipelines/sensors/os1_128.yaml");
    EXPECT_EQ(foundBySet(name, "pipelines/sensors"), "share/pipelines/sensors/os1_128.yaml");
  }
  EXPECT_EQ(found("semantic_kitti", "labels"), "share/labels/semantic_kitti.yaml");
  EXPECT_EQ(found("materials", "labels"), "share/labels/materials.yaml");
  EXPECT_EQ(found("street", "scenes"), "share/scenes/street.yaml");
  // Who writes a place means that place.
  EXPECT_THAT(messageOf([&] { found("../scenes/street.yaml", "scenes"); }), HasSubstr("there is no file"));
  EXPECT_THAT(messageOf([&] { found("./street.yaml", "scenes"); }), HasSubstr("there is no file"));
  EXPECT_THAT(messageOf([&] { found("../../../secret", "scenes"); }), HasSubstr("there is no file"));
}

// A name without slash and suffix means a file of the program, so that a binary or a folder of that name does no harm.
TEST_F(Resources, PlainNamesMeanTheProgramsFiles) {
  folder_.write("project/street", "\x7F");
  folder_.write("current/street", "\x7F");
  for (const char* name : {"street", "street.yaml"}) {
    EXPECT_EQ(found(name, "scenes"), "share/scenes/street.yaml");
    EXPECT_EQ(foundBySet(name, "scenes"), "share/scenes/street.yaml");
  }
  EXPECT_EQ(relative(namedResource("street", "scenes")), "share/scenes/street.yaml");
  EXPECT_EQ(found("./street", "scenes"), "project/./street");
  folder_.write("project/yard", "objects: []\n");
  EXPECT_THAT(messageOf([&] { found("yard", "scenes"); }),
              AllOf(StartsWith((folder_.path() / "project/p.yaml:2:7: 'yard' is not among").string()),
                    HasSubstr("write ./yard")));
  folder_.write("project/street.yaml", "objects: []\n");
  testing::internal::CaptureStderr();
  EXPECT_EQ(found("street", "scenes"), "share/scenes/street.yaml");
  EXPECT_THAT(testing::internal::GetCapturedStderr(),
              AllOf(HasSubstr("p.yaml:2:7: 'street' is taken from the files "), HasSubstr("write street.yaml")));
}

TEST_F(Resources, OnesOwnFilesComeFirst) {
  folder_.write("project/street.yaml", "objects: []\n");
  folder_.write("project/meadow.yaml", "objects: []\n");
  EXPECT_EQ(found("street.yaml", "scenes"), "project/street.yaml");
  EXPECT_EQ(found("meadow", "scenes"), "project/meadow.yaml");
  EXPECT_EQ(found("own/yard.yaml", "scenes"), "project/own/yard.yaml");
  EXPECT_EQ(found("own/yard", "scenes"), "project/own/yard.yaml");
}

TEST_F(Resources, PathsOfSetStartInTheFolderOfTheFileThenInTheCurrentOne) {
  EXPECT_EQ(foundBySet("own/yard.yaml", "scenes"), "project/own/yard.yaml");
  EXPECT_EQ(foundBySet("own/town.yaml", "scenes"), "./own/town.yaml");
  EXPECT_THAT(messageOf([&] { foundBySet("own/tower.yaml", "scenes"); }),
              AllOf(StartsWith("--set file: there is no file '"), HasSubstr("project/own/tower.yaml'"),
                    HasSubstr("nor 'own/tower.yaml' in the current folder")));
  // Files that are no YAML likewise, also below what --set makes.
  Value root = root_;
  setValue(root, "file={asset: own/town.yaml, other: own/yard.yaml, absent: a.obj}");
  Fields f(*root.find("file"), "test");
  EXPECT_EQ(relative(f.path("asset")), "./own/town.yaml");
  EXPECT_EQ(relative(f.path("other")), "project/own/yard.yaml");
  EXPECT_EQ(relative(f.path("absent")), "project/a.obj");
}

TEST_F(Resources, WhatIsAbsentIsNamedWithPlaceAndTheNearestName) {
  EXPECT_THAT(messageOf([&] { found("own/yrad.yaml", "scenes"); }),
              AllOf(HasSubstr("project/p.yaml:2:7: there is no file '"), HasSubstr("project/own/yrad.yaml'"),
                    HasSubstr("did you mean 'yard'?")));
  EXPECT_THAT(messageOf([&] { found("stret", "scenes"); }), HasSubstr("did you mean 'street'?"));
  // The nearest of all places, not of the first that has one which is near.
  folder_.write("project/lot.yaml", "");
  folder_.write("share/scenes/town.yaml", "");
  EXPECT_THAT(messageOf([&] { found("twon", "scenes"); }), HasSubstr("did you mean 'town'?"));
  EXPECT_THAT(messageOf([&] { found("zzz", "labels"); }), HasSubstr("materials, semantic_kitti"));
  EXPECT_THAT(messageOf([&] { found("own", "labels"); }), HasSubstr("project/own'"));
  // Files of other kinds are not meant.
  folder_.write("project/streets.yaml", "elevation_deg: [0]\n");
  EXPECT_THAT(messageOf([&] { found("streetss", "scenes"); }), HasSubstr("did you mean 'street'?"));
}

// The program's own files are stored by their names in it, other files by their way from the pipeline's folder.
TEST(SavedPath, NamesTheSameFileOnEveryMachine) {
  const std::filesystem::path own = resourceFolder() / "scenes/street.yaml";
  EXPECT_EQ(savedPath(own, "/home/a/project"), "scanmill:scenes/street.yaml");
  EXPECT_EQ(fileOfSavedPath("scanmill:scenes/street.yaml", "/home/b"), own);
  EXPECT_EQ(savedPath("/home/a/assets/../meshes/car.obj", "/home/a/project/"), "../meshes/car.obj");
  EXPECT_EQ(fileOfSavedPath("../meshes/car.obj", "/home/b/project"), "/home/b/meshes/car.obj");
  const std::string here = savedPath(std::filesystem::temp_directory_path() / "a.obj", "");
  EXPECT_TRUE(
      std::filesystem::equivalent(std::filesystem::path(here).parent_path(), std::filesystem::temp_directory_path()));
}

TEST(FileKind, FilesInTheWrongPlaceAreCalledByTheirName) {
  const std::pair<const char*, const char*> cases[] = {{"objects: []", "name it under `scenes:` of a pipeline"},
                                                       {"elevation_deg: [1]", "this is a sensor"},
                                                       {"classes: []", "this is an ontology"},
                                                       {"materials: []", "this is a material table"}};
  for (const auto& [text, says] : cases) {
    EXPECT_THAT(messageOf([&] { expectKind(parseYaml(text, "a.yaml"), FileKind::Pipeline); }),
                AllOf(StartsWith("a.yaml: "), HasSubstr(says)));
  }
  EXPECT_THAT(messageOf([] { expectKind(parseYaml("scenes: []", "a.yaml"), FileKind::Scene); }),
              HasSubstr("this is a pipeline"));
  EXPECT_EQ(messageOf([] { expectKind(parseYaml("scenes: []", "a.yaml"), FileKind::Pipeline); }), "accepted");
  EXPECT_EQ(messageOf([] { expectKind(parseYaml("nothing: 1", "a.yaml"), FileKind::Pipeline); }), "accepted");
}

}  // namespace
}  // namespace scanmill
