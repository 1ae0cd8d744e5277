#include "pipeline/run/verify_recording.h"

#include <fmt/core.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/file.h"
#include "base/parallel.h"
#include "passes/exr/hits_exr.h"
#include "passes/exr/pass_exr.h"
#include "tests/support/message_of.h"
#include "tests/support/temporary_folder.h"

namespace scanmill {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;
using testing::StartsWith;

constexpr const char* kClasses =
    R"({"name": "two", "source": "a test", "classes": [{"id": 0, "name": "unlabeled", "color": [0, 0, 0], "thing": false},
        {"id": 3, "name": "wall", "color": [1, 2, 3], "thing": false}]})";
constexpr const char* kMaterials =
    R"([[{"name": "brick", "roughness": 1, "metallic": 0, "retroreflectance": 0},
         {"name": "steel", "roughness": 0.2, "metallic": 1, "retroreflectance": 0}]])";

// Recordings of one sensor of 2 x 4 beams and 3 frames.
class VerifyRecording : public testing::Test {
 protected:
  void index(const std::string& kind, std::uint32_t frames = 3, bool tables = true) const {
    write("recording.json",
          fmt::format(R"({{"what": "scanmill recording", "schema_version": 1, "kind": "{}",
            "sensors": [{{"name": "top", "rings": 2, "columns": 4}}],
            "sequences": [{{"scene": "studio", "trajectory": "walk", "frames": {}}}]{}}})",
                      kind, frames,
                      tables ? fmt::format(R"(, "ontology": {}, "materials": {})", kClasses, kMaterials) : ""));
  }

  void write(const std::string& name, const std::string& text) const { folder_.write(name, text); }

  static std::string scan(int frame) { return fmt::format("studio-s1-walk-{:06}.top.json", frame); }

  void scan(int frame, const std::string& rest) const {
    write(scan(frame),
          fmt::format(R"({{"time": {}, "world_from_sensor": [[1, 0, 0, 0, 0, 0, 1.9]], {}}})", frame, rest));
  }

  static PassImage image(PassChoice choice = {Channel::Normal | Channel::Semantic | Channel::Material, false}) {
    PassImage made{squareCamera(6, 5, 1.2), {}};
    made.planes.reset(made.camera.pixels(), choice);
    std::fill(made.planes.depth.begin(), made.planes.depth.end(), 7.0f);
    std::fill(made.planes.normal.begin(), made.planes.normal.end(), Vec3f{0, 0, -1});
    std::fill(made.planes.semantic.begin(), made.planes.semantic.end(), std::uint16_t{3});
    std::fill(made.planes.material.begin(), made.planes.material.end(), std::uint16_t{1});
    for (auto* plane : {&made.planes.roughness, &made.planes.metallic, &made.planes.retroreflectance}) {
      std::fill(plane->begin(), plane->end(), 0.5f);
    }
    return made;
  }

  void put(const std::string& name, const PassImage& made) const { writePasses(folder_.path() / name, made); }

  // A sound one: two steps a scan, one image for the last half of all scans.
  void passes() const {
    index("passes");
    for (int frame = 0; frame < 3; ++frame) {
      const std::string front = fmt::format("front{}.exr", frame);
      scan(frame, fmt::format(R"("steps": [{{"columns": [0, 2], "images": ["{}"]}},
                                           {{"columns": [2, 4], "images": ["back.exr"]}}])",
                              front));
      put(front, image());
    }
    put("back.exr", image());
  }

  static Hits beams(std::uint32_t rings = 2, std::uint32_t columns = 4) {
    Hits hits;
    hits.reset(rings, columns, Channel::Range | Channel::Semantic | Channel::Material);
    std::fill(hits.range.begin(), hits.range.end(), 5.0f);
    std::fill(hits.semantic.begin(), hits.semantic.end(), std::uint16_t{3});
    std::fill(hits.material.begin(), hits.material.end(), std::uint16_t{0});
    return hits;
  }

  void hits() const {
    index("hits");
    for (int frame = 0; frame < 3; ++frame) {
      scan(frame, fmt::format(R"("hits": "{}.exr")", frame));
      writeHits(folder_.path() / fmt::format("{}.exr", frame), beams());
    }
  }

  RecordingVerification verify() const { return verifyRecording(folder_.path()); }
  std::vector<std::string> problems() const { return verify().problems; }

  TemporaryFolder folder_;
};

TEST_F(VerifyRecording, SoundOnesHaveNoProblems) {
  passes();
  std::uint64_t calls = 0;
  std::uint64_t last = 0;
  RecordingVerification v = verifyRecording(folder_.path(), [&](std::uint64_t done, std::uint64_t total) {
    EXPECT_EQ(done, ++calls);
    last = total;
  });
  EXPECT_THAT(v.problems, IsEmpty());
  EXPECT_THAT(v.warnings, IsEmpty());
  EXPECT_EQ(v.scans, 3u);
  EXPECT_EQ(v.images, 4u);  // an image that many name is read once
  EXPECT_EQ(v.pixels, 4u * 30u);
  EXPECT_EQ(calls, 4u);
  EXPECT_EQ(last, 4u);
}

TEST_F(VerifyRecording, SoundHitsHaveNoProblems) {
  hits();
  const RecordingVerification v = verify();
  EXPECT_THAT(v.problems, IsEmpty());
  EXPECT_THAT(v.warnings, IsEmpty());
  EXPECT_EQ(v.scans, 3u);
  EXPECT_EQ(v.images, 3u);
  EXPECT_EQ(v.pixels, 3u * 8u);
}

TEST_F(VerifyRecording, AllProblemsAreListedWhateverTheThreads) {
  passes();
  std::filesystem::remove(folder_.path() / scan(1));
  write("front0.exr", readFile(folder_.path() / "front0.exr").substr(0, 400));
  std::filesystem::remove(folder_.path() / "front2.exr");
  PassImage odd = image();
  odd.planes.semantic[4] = 77;
  odd.planes.semantic[5] = 4;
  odd.planes.material[9] = 2;
  put("back.exr", odd);
  const auto expected = ElementsAre(
      scan(1) + ": is missing",
      AllOf(StartsWith("back.exr: channel 'semantic'"), HasSubstr("'two'"), HasSubstr("no class 4, 77")),
      AllOf(StartsWith("back.exr: channel 'material'"), HasSubstr("2, but /materials/0"), HasSubstr("has 2")),
      StartsWith("front0.exr: is damaged or truncated"), "front2.exr: is missing, but " + scan(2) + " names it");
  for (const int threads : {1, 8}) {
    const ThreadLimit limit(threads);
    EXPECT_THAT(problems(), expected);
  }
}

TEST_F(VerifyRecording, MissingFramesInARowAreOneProblem) {
  index("passes", 10'000);
  scan(5000, R"("steps": [{"columns": [0, 4], "images": ["a.exr"]}])");
  put("a.exr", image());
  EXPECT_THAT(problems(), ElementsAre(scan(0) + ": is missing, and 4999 frames after it",
                                      scan(5001) + ": is missing, and 4998 frames after it"));
}

TEST_F(VerifyRecording, ScansThatDoNotFitTheirSensorAreProblems) {
  passes();
  const auto problem = [&] {
    const std::vector<std::string> found = problems();
    EXPECT_THAT(found, SizeIs(1));
    return found.empty() ? "" : found.front();
  };
  const auto steps = [&](const std::string& list) { scan(1, R"("steps": [)" + list + "]"); };
  steps(R"({"columns": [0, 3], "images": ["back.exr"]})");
  EXPECT_THAT(problem(), AllOf(StartsWith(scan(1)), HasSubstr("/steps"), HasSubstr("'top' has 4")));
  steps(R"({"columns": [0, 1], "images": ["back.exr"]}, {"columns": [2, 4], "images": ["back.exr"]})");
  EXPECT_THAT(problem(), AllOf(StartsWith(scan(1)), HasSubstr("/steps/1/columns"), HasSubstr("first = 1")));
  steps(R"({"columns": [0, 4], "images": ["../back.exr"]})");
  EXPECT_THAT(problem(), AllOf(StartsWith(scan(1)), HasSubstr("'../back.exr'")));
  write(scan(1), R"({"time": 0, "world_from_sensor": [[1,0,0,0,0,0,0], [1,0,0,0,0,0,0], [1,0,0,0,0,0,0],
    [1,0,0,0,0,0,0], [1,0,0,0,0,0,0]], "steps": [{"columns": [0, 4], "images": ["back.exr"]}]})");
  EXPECT_THAT(problem(), AllOf(StartsWith(scan(1)), HasSubstr("5 poses"), HasSubstr("4 columns")));
  write(scan(1), "{");
  EXPECT_THAT(problem(), AllOf(StartsWith(scan(1)), HasSubstr("not complete JSON")));
}

TEST_F(VerifyRecording, HitsOfAnotherSensorAreAProblem) {
  hits();
  writeHits(folder_.path() / "1.exr", beams(4, 2));
  Hits odd = beams();
  odd.semantic[0] = 9;
  odd.material[7] = 300;
  writeHits(folder_.path() / "2.exr", odd);
  EXPECT_THAT(problems(), ElementsAre(AllOf(StartsWith("1.exr"), HasSubstr("4 x 2"), HasSubstr("'top' has 2 x 4")),
                                      AllOf(StartsWith("2.exr"), HasSubstr("no class 9")),
                                      AllOf(StartsWith("2.exr"), HasSubstr("has the index 300"))));
}

TEST_F(VerifyRecording, AnImageOfTheOtherKindIsAProblem) {
  hits();
  put("0.exr", image());
  EXPECT_THAT(problems(), ElementsAre(AllOf(StartsWith("0.exr"), HasSubstr("'range'"))));
  passes();
  writeHits(folder_.path() / "back.exr", beams());
  EXPECT_THAT(problems(), ElementsAre(AllOf(StartsWith("back.exr"), HasSubstr("cameraMatrix"))));
}

// Ids are whatever the pipeline's ontology makes of them, and what an image tells of its materials needs no table.
TEST_F(VerifyRecording, OnlyTheRecordingsOwnTablesCount) {
  passes();
  PassImage odd = image();
  odd.planes.semantic[4] = 77;
  odd.planes.material[9] = 2;
  put("back.exr", odd);
  EXPECT_THAT(problems(), SizeIs(2));
  index("passes", 3, false);
  EXPECT_THAT(problems(), IsEmpty());
  index("passes");
  PassImage described = image({Channel::Semantic | Channel::Material, true});
  described.planes.material[9] = 2;
  put("back.exr", described);
  EXPECT_THAT(problems(), IsEmpty());
}

TEST_F(VerifyRecording, CameraAxesOfOthersAreFound) {
  passes();
  PassImage flipped = image();
  flipped.camera.worldFromCamera.rotation = {0, 1, 0, 0};  // half a turn about x: y up, z backward
  put("front1.exr", flipped);
  EXPECT_THAT(problems(), ElementsAre(AllOf(StartsWith("front1.exr"), HasSubstr("negate its second and third"))));
}

TEST_F(VerifyRecording, FilesThatNothingNamesAreAWarning) {
  passes();
  write("notes.txt", "studio");
  put("spare.exr", image());
  const RecordingVerification v = verify();
  EXPECT_THAT(v.problems, IsEmpty());
  EXPECT_THAT(v.warnings, ElementsAre(AllOf(HasSubstr("2 in all"), HasSubstr("notes.txt, spare.exr"))));
}

TEST_F(VerifyRecording, AnUnreadableIndexIsRefused) {
  passes();
  write("recording.json", R"({"what": "scanmill recording", "kind": "passes"})");
  expectInputError([&] { verify(); }, {"recording.json", "schema_version"});
  write("recording.json", "{");
  expectInputError([&] { verify(); }, {"recording.json"});
  std::filesystem::remove(folder_.path() / "recording.json");
  expectInputError([&] { verify(); }, {"no recording.json"});
}

}  // namespace
}  // namespace scanmill
