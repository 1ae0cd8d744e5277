// scanmill verify of a recording, as a user runs it.

#include "base/file.h"
#include "tests/commands/program.h"

namespace scanmill {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

class VerifyCommand : public SmallWorld {};

TEST_F(VerifyCommand, ReadsRecordingsWhole) {
  ASSERT_EQ(scanmill({"generate", pipeline_, "-q", "-o", at("a"), "--keep-hits", at("hits")}).code, 0);
  const Outcome sound = scanmill({"verify", at("hits")});
  EXPECT_EQ(sound.code, 0) << sound.error;
  EXPECT_EQ(sound.out, "4 scans, 4 images, 2,048 pixels: sound\n");
  EXPECT_THAT(sound.error, AllOf(HasSubstr("verify 4/4 images"), Not(HasSubstr("warning"))));

  folder_.write("hits/notes.txt", "mine");
  const Outcome noted = scanmill({"verify", "-q", at("hits/")});
  EXPECT_EQ(noted.code, 0);
  EXPECT_THAT(noted.error, AllOf(HasSubstr("warning: "),
                                 HasSubstr("files that do not belong to the recording, 1 in all: notes.txt")));

  const auto images = filesEndingIn(".hits.exr", at("hits"));
  folder_.write("hits/" + images[0].filename().string(), readFile(images[0]).substr(0, 500));
  std::filesystem::remove(images[1]);
  const Outcome bad = scanmill({"verify", "-q", at("hits")});
  EXPECT_EQ(bad.code, 1);
  EXPECT_EQ(bad.out, "4 scans, 4 images, 1,024 pixels: 2 problems\n");
  EXPECT_THAT(bad.error, AllOf(HasSubstr(images[0].filename().string() + ": is damaged"),
                               HasSubstr(images[1].filename().string() + ": is missing")));
  std::filesystem::remove(at("hits/recording.json"));
  expectRefused(scanmill({"verify", at("hits")}), "manifest.json");
  folder_.write("hits/recording.json", "{");
  expectRefused(scanmill({"verify", at("hits")}), "recording.json");
}

}  // namespace
}  // namespace scanmill
