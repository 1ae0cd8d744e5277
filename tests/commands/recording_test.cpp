// Recordings as a user makes, looks at and reads them.

#include <map>

#include "base/file.h"
#include "dataset/manifest.h"
#include "tests/commands/program.h"
#include "tests/support/gl.h"
#include "tests/support/message_of.h"

namespace scanmill {
namespace {

using testing::AllOf;
using testing::HasSubstr;

const std::string kCamera = "method={depth_camera: {resolution: 128}}";

class Recordings : public SmallWorld {
 protected:
  static Outcome done(const std::vector<std::string>& arguments, const std::vector<std::string>& variables = {}) {
    Outcome outcome = scanmill(arguments, variables);
    EXPECT_EQ(outcome.code, 0) << outcome.error;
    return outcome;
  }

  std::map<std::string, std::string> shards(const std::string& dataset) const {
    std::map<std::string, std::string> bytes;
    for (const auto& file : filesEndingIn(".tar", at(dataset))) bytes[file.filename().string()] = readFile(file);
    EXPECT_FALSE(bytes.empty());
    return bytes;
  }
};

TEST_F(Recordings, OfHits) {
  EXPECT_THAT(done({"generate", pipeline_, "-o", at("a"), "--keep-hits", at("hits")}).out, HasSubstr("write_hits"));
  EXPECT_THAT(done({"generate", pipeline_, "-o", at("b"), "--from-hits", at("hits")}).out, HasSubstr("read_hits"));
  EXPECT_TRUE(shards("a") == shards("b"));
  EXPECT_THAT(done({"info", at("hits")}).out, AllOf(HasSubstr("recording of hits"), HasSubstr("--from-hits")));
  const std::string image = filesEndingIn(".hits.exr", at("hits")).front().string();
  EXPECT_THAT(done({"info", image}).out, AllOf(HasSubstr("64 x 8 pixels"), HasSubstr("range"), HasSubstr("UINT")));
  done({"view", image, "--screenshot", at("hits.png")});
  EXPECT_THAT(readFile(at("hits.png")), testing::StartsWith("\x89PNG"));
}

TEST_F(Recordings, OfPasses) {
  SKIP_WITHOUT_GL();
  done({"render", pipeline_, "-o", at("passes"), "--set", kCamera});
  done({"generate", pipeline_, "-o", at("a"), "--set", kCamera});
  done({"generate", pipeline_, "-o", at("b"), "--set", kCamera, "--from-passes", at("passes")});
  EXPECT_TRUE(shards("a") == shards("b"));
  EXPECT_THAT(done({"info", at("passes")}).out, AllOf(HasSubstr("recording of passes"), HasSubstr("--from-passes")));
  const std::string image = filesEndingIn(".exr", at("passes")).front().string();
  EXPECT_THAT(done({"info", image}).out, AllOf(HasSubstr("focal length"), HasSubstr("N.X"), HasSubstr("instance")));
  done({"view", image, "--screenshot", at("passes.png"), "--size", "800x600"});
  EXPECT_THAT(readFile(at("passes.png")), testing::StartsWith("\x89PNG"));
  done({"render", pipeline_, "-o", at("depth"), "--set", kCamera, "--passes", "depth,look"});
  const std::string depth = filesEndingIn(".exr", at("depth")).front().string();
  EXPECT_THAT(done({"info", depth}).out, AllOf(HasSubstr("roughness"), testing::Not(HasSubstr("N.X"))));
}

TEST_F(Recordings, WithoutTheDeviceTheErrorSaysWhatToDo) {
  const Outcome gl = scanmill({"generate", pipeline_, "-o", at("b"), "--set", kCamera}, {"SCANMILL_GL_DEVICE=77"});
  EXPECT_NE(gl.code, 0);
  EXPECT_THAT(gl.error, HasSubstr("77"));
  const Outcome blender =
      scanmill({"generate", pipeline_, "-o", at("c"), "--set", "method={depth_camera: {renderer: blender}}"},
               {"SCANMILL_BLENDER=/nowhere/blender"});
  EXPECT_NE(blender.code, 0);
  EXPECT_THAT(blender.error, AllOf(HasSubstr("/nowhere/blender"), HasSubstr("SCANMILL_BLENDER")));
  EXPECT_FALSE(std::filesystem::exists(at("b/manifest.json")));
}

}  // namespace
}  // namespace scanmill
