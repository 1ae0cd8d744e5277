// The viewer as scripts and people without a display use it.

#include <cstdlib>
#include <fstream>

#include "base/file.h"
#include "tests/commands/program.h"
#include "viewer/window/session.h"

namespace scanmill {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;

constexpr const char* kPngStart = "\x89PNG";

class View : public SmallWorld {
 protected:
  View() {
    const Outcome made = scanmill({"generate", pipeline_, "-o", at("a"), "-q"});
    EXPECT_EQ(made.code, 0) << made.error;
  }

  // False where this machine has no OpenGL.
  static bool canDraw(const Outcome& outcome) { return outcome.error.find("no OpenGL") == std::string::npos; }

  void expectPicture(const std::vector<std::string>& arguments) {
    std::vector<std::string> all{"view"};
    all.insert(all.end(), arguments.begin(), arguments.end());
    for (const char* more : {"--screenshot", "", "--size", "320x200"}) {
      all.push_back(*more == '\0' ? at("p.png") : std::string(more));
    }
    std::filesystem::remove(at("p.png"));
    const Outcome outcome = scanmill(all, {"DISPLAY="});
    EXPECT_EQ(outcome.code, 0) << testing::PrintToString(all) << outcome.error;
    EXPECT_THAT(readFile(at("p.png")), StartsWith(kPngStart));
    EXPECT_THAT(outcome.out, HasSubstr("320 x 200"));
  }

  std::vector<std::string> of(const std::vector<std::string>& more) const {
    std::vector<std::string> arguments{"view", at("a"), "--screenshot", at("p.png")};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return arguments;
  }

  std::string only(const std::string& suffix, const std::string& folder) const {
    const auto files = filesEndingIn(suffix, at(folder));
    return files.empty() ? "" : files.front().string();
  }
};

#define SKIP_WITHOUT_CANVAS()                                                                \
  if (const Outcome tried = scanmill({"view", at("a"), "--pick", "1,1"}); !canDraw(tried)) { \
    GTEST_SKIP() << tried.error;                                                             \
  }

TEST_F(View, PicturesOfDatasets) {
  SKIP_WITHOUT_CANVAS();
  expectPicture({at("a")});
  expectPicture({at("a"), "--sample", "2", "--camera", "above", "--rings", "--range-image", "--mesh"});
  expectPicture({at("a"), "--map", "--color", "height"});
  expectPicture({at("a"), "--color", "class", "--color", "range"});
  expectPicture({at("a"), "--color", "class", "--color", "range", "--scale", "0,20"});
  expectPicture({"vehicle", "--ontology", "semantic_kitti"});
  expectPicture({"scenes/vehicle.yaml"});
  expectPicture({at("a"), "--ontology", "semantic_kitti", "--hide", "other-ground"});
  expectPicture({at("a"), "--over", at("a"), "--layout", "overlay"});
  expectPicture({at("a"), "--over", at("a"), "--layout", "split", "--color", "height"});
  expectPicture({at("a"), "--reference", at("a"), "--color", "error"});
  expectPicture({at("a"), "--twin", at("a"), "--color", "error"});  // its former name
  expectPicture({at("a"), "--hide", "ground", "--hide", "wall", "--bare", "--flat"});
  expectPicture({at("a"), "--only", "car", "--camera", "30,20,25,1,2,0", "--point-size", "4"});
}

TEST_F(View, PicturesOfFiles) {
  SKIP_WITHOUT_CANVAS();
  const std::string shard = only(".tar", "a");
  ASSERT_EQ(std::system(("tar xf " + shard + " -C " + at("")).c_str()), 0);
  expectPicture({shard});
  for (const char* suffix : {".pcd", ".drc", ".csv"}) {
    std::string scan;
    for (const auto& entry : std::filesystem::directory_iterator(at(""))) {
      if (entry.path().extension() == suffix) scan = entry.path().string();
    }
    ASSERT_FALSE(scan.empty()) << suffix;
    expectPicture({scan});
  }
  expectPicture({at("scene.yaml")});
  const Outcome rendered = scanmill({"render", pipeline_, "-o", at("passes"), "-q", "--set", "method=depth_camera"});
  ASSERT_EQ(rendered.code, 0) << rendered.error;
  const std::string exr = only(".exr", "passes");
  const auto drawn = [&](std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), "view");
    arguments.insert(arguments.end(), {"--screenshot", at("p.png")});
    const Outcome outcome = scanmill(arguments, {"DISPLAY="});
    EXPECT_EQ(outcome.code, 0) << outcome.error;
    return readFile(at("p.png"));
  };
  const std::string all = drawn({exr});
  EXPECT_THAT(all, StartsWith(kPngStart));
  EXPECT_EQ(drawn({exr, "--plane", "all"}), all);
  EXPECT_NE(drawn({exr, "--plane", "semantic"}), all);
  expectRefused(scanmill({"view", exr, "--plane", "colour", "--screenshot", at("x.png")}), "semantic");
  expectRefused(scanmill({"view", exr, "--color", "class", "--screenshot", at("x.png")}), "takes no --color");
  expectRefused(scanmill({"view", exr}), "add --screenshot");
  EXPECT_NE(drawn({at("passes"), "--sample", "0"}), drawn({at("passes")}));
  expectRefused(scanmill({"view", at("passes"), "--sample", "nowhere", "--screenshot", at("x.png")}), "nowhere");
}

TEST_F(View, OfARangeImageAlone) {
  const Outcome made = scanmill(of({"--range-image-alone", "--color", "range"}));
  ASSERT_EQ(made.code, 0) << made.error;
  EXPECT_THAT(readFile(at("p.png")), StartsWith(kPngStart));
  expectRefused(scanmill(of({"--range-image-alone", "--mesh"})), "takes no --mesh");
  expectRefused(scanmill({"view", at("a"), "--range-image-alone"}), "add --screenshot");
}

TEST_F(View, PrintsWhatLiesAtAPixel) {
  SKIP_WITHOUT_CANVAS();
  // The driver's view of the wall, straight ahead.
  bool seen = false;
  for (int y = 100; y < 300 && !seen; y += 2) {
    const Outcome o = scanmill({"view", at("a"), "--camera", "driver", "--size", "400x300", "--only", "wall", "--pick",
                                "200," + std::to_string(y)},
                               {"DISPLAY="});
    ASSERT_EQ(o.code, 0) << o.error;
    seen = o.out.find("nothing lies at") == std::string::npos;
    if (!seen) continue;
    EXPECT_THAT(o.out, AllOf(StartsWith("wall"), HasSubstr("range"), HasSubstr(" m\n"), HasSubstr("ring"),
                             HasSubstr("column"), HasSubstr("beam azimuth"), HasSubstr("beam elevation"),
                             HasSubstr("ray_tracing"), HasSubstr("top")));
  }
  EXPECT_TRUE(seen);
}

TEST_F(View, WithoutADisplayItSaysWhatToDo) {
  for (const char* display : {"DISPLAY=", "DISPLAY=:4711"}) {
    const Outcome o = scanmill({"view", at("a")}, {display});
    if (!canDraw(o)) GTEST_SKIP() << o.error;
    EXPECT_EQ(o.code, 1) << o.error;
    EXPECT_THAT(o.error, HasSubstr("--screenshot"));
    EXPECT_EQ(o.out, "");
  }
}

TEST_F(View, BadInputIsRefusedWithAdvice) {
  const std::string png = at("p.png");
  const std::pair<std::vector<std::string>, std::string> cases[] = {
      {{}, "is missing"},
      {{at("absent")}, "absent"},
      {{at("small.yaml")}, "small.yaml"},
      {{at("a"), "--color", "intensty"}, "--color is one of class"},
      {{at("a"), "--color", "colour"}, "no column 'colour'"},
      {{at("a"), "--color", "class", "--color", "range", "--layout", "one"}, "--layout split"},
      {{at("a"), "--layout", "both"}, "one, overlay, split"},
      {{at("a"), "--over", at("a"), "--color", "range"}, "--layout split"},
      {{at("a"), "--color", "range", "--scale", "5"}, "LOW,HIGH"},
      {{at("a"), "--color", "range", "--scale", "5,1"}, "LOW,HIGH"},
      {{at("a"), "--color", "class", "--scale", "0,1"}, "shows numbers"},
      {{at("a"), "--camera", "behind"}, "YAW,PITCH,DISTANCE"},
      {{at("a"), "--size", "9x9"}, "--size"},
      {{at("a"), "--point-size", "0"}, "--point-size"},
      {{at("a"), "--hide", "car", "--only", "car"}, "exclude each other"},
      {{at("a"), "--hide", "lorry"}, "lorry"},
      {{at("a"), "--ontology", "semantic_kit"}, "did you mean 'semantic_kitti'"},
      {{at("a"), "--sample", "17"}, "17"},
      {{at("a"), "--sample", "nowhere"}, "nowhere"},
      {{at("a"), "--sensor", "bottom"}, "bottom"},
      {{at("a"), "--pick", "1600,3"}, "--pick"},
      {{at("a"), "--over", at("absent")}, "absent"},
      {{at("a"), "--reference", at("absent")}, "absent"},
      {{at("a"), "--plane", "depth"}, "--plane"},
      {{at("absent.exr")}, "absent.exr"},
      {{at("absent.exr"), "--at", "1,2,3", "--within", "3"}, "takes no --at"},
      {{at("a"), "--at", "1,2,3"}, "both --at X,Y,Z"},
      {{at("a"), "--within", "3"}, "both --at X,Y,Z"},
      {{at("a"), "--at", "1,2", "--within", "3"}, "not '1,2'"},
      {{at("a"), "--at", "1,nan,3", "--within", "3"}, "--at is X,Y,Z"},
      {{at("a"), "--at", "1,2,1e9", "--within", "3"}, "at most"},
      {{at("a"), "--at", "1,2,3", "--within", "0"}, "--within must be a number from 0.01"},
      {{at("a"), "--at", "1,2,3", "--within", "near"}, "near"},
      {{at("a"), "--at", "1,2,3", "--within", "3", "--range-image-alone"}, "takes no --at"},
      {{at("a"), "--at", "1,2,3", "--within", "3", "--camera", "30,20,25,1,2,3"}, "leave X,Y,Z out"},
      {{at("a"), "--at", "0,0,9999", "--within", "3"}, "the nearest is"},
  };
  std::vector<std::vector<std::string>> all;
  for (const auto& [arguments, says] : cases) {
    std::vector<std::string> words{"view"};
    words.insert(words.end(), arguments.begin(), arguments.end());
    if (!arguments.empty()) words.insert(words.end(), {"--screenshot", png});
    all.push_back(words);
  }
  all.push_back({"view", at("a"), "--screenshot", at("p.jpg")});
  const std::vector<Outcome> outcomes = scanmillEach(all);
  for (std::size_t i = 0; i < std::size(cases); ++i) {
    SCOPED_TRACE(testing::PrintToString(all[i]));
    if (!canDraw(outcomes[i])) continue;
    expectRefused(outcomes[i], cases[i].second);
  }
  expectRefused(outcomes.back(), ".png");
  EXPECT_FALSE(std::filesystem::exists(png));
}

TEST_F(View, DamagedDataIsSaidNotShown) {
  SKIP_WITHOUT_CANVAS();
  // A column that the scans lack.
  expectRefused(scanmill({"view", at("a"), "--color", "error", "--screenshot", at("p.png")}), "noise-free reference");
  // An empty scan is no mistake: the picture says so.
  const std::string empty = folder_.write("empty.csv", "x,y,z\n").string();
  expectPicture({empty});
  // A shard whose contents are gone, and one that is missing.
  const std::string shard = only(".tar", "a");
  const std::string whole = readFile(shard);
  std::string damaged = whole;
  for (std::size_t i = 0; i < damaged.size(); ++i) damaged[i] = static_cast<char>(i * 7);
  std::ofstream(shard, std::ios::binary) << damaged;
  std::filesystem::remove(at("p.png"));
  const std::vector<std::string> picture{"view", at("a"), "--screenshot", at("p.png"), "--size", "320x200"};
  Outcome o = scanmill(picture);
  EXPECT_EQ(o.code, 1) << o.out;
  EXPECT_THAT(o.error, HasSubstr(std::filesystem::path(shard).filename().string()));
  EXPECT_FALSE(std::filesystem::exists(at("p.png")));
  std::filesystem::remove(shard);
  o = scanmill(picture);
  EXPECT_EQ(o.code, 1) << o.out;
  EXPECT_THAT(o.error, HasSubstr(std::filesystem::path(shard).filename().string()));
  EXPECT_FALSE(std::filesystem::exists(at("p.png")));
  // A truncated one shows what is left.
  std::ofstream(shard, std::ios::binary) << whole.substr(0, whole.size() / 2);
  o = scanmill({"view", at("a"), "--sample", "0", "--screenshot", at("p.png"), "--size", "320x200"});
  EXPECT_TRUE(o.code == 0 || o.code == 1) << o.error;
  EXPECT_EQ(o.code == 0, std::filesystem::exists(at("p.png")));
}

TEST(ViewPage, ListsEveryKey) {
  const std::string page = readFile(SCANMILL_SOURCE_DIR "/docs/view.md");
  for (const auto& [key, what] : viewKeys()) {
    EXPECT_THAT(page, HasSubstr("| " + key + " | " + what + " |\n"));
  }
}

}  // namespace
}  // namespace scanmill
