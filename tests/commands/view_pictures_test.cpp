// Pictures of a dataset, as a user asks for them.

#include "base/file.h"
#include "tests/commands/program.h"

namespace scanmill {
namespace {

using testing::AllOf;
using testing::HasSubstr;

class Pictures : public SmallWorld {
 protected:
  Pictures() {
    const Outcome made = scanmill({"generate", pipeline_, "-o", at("a"), "-q"});
    EXPECT_EQ(made.code, 0) << made.error;
  }

  std::vector<std::string> of(const std::vector<std::string>& more) const {
    std::vector<std::string> arguments{"view", at("a"), "--screenshot", at("p.png")};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return arguments;
  }
};

// The range image alone: whole pixels for each beam of the sensor.
TEST_F(Pictures, OfARangeImageAlone) {
  const Outcome made = scanmill(of({"--range-image-alone", "--color", "range"}));
  ASSERT_EQ(made.code, 0) << made.error;
  const std::string png = readFile(at("p.png"));
  const auto byte = [&](std::size_t i) { return static_cast<unsigned>(static_cast<unsigned char>(png.at(i))); };
  const unsigned width = byte(16) << 24 | byte(17) << 16 | byte(18) << 8 | byte(19);  // of the PNG's first chunk
  EXPECT_GE(width, 1600u);
  EXPECT_EQ(width % 64, 0u) << "the sensor has 64 columns, and each beam whole pixels";
  expectRefused(scanmill(of({"--range-image-alone", "--mesh"})), "takes no --mesh");
  expectRefused(scanmill({"view", at("a"), "--range-image-alone"}), "add --screenshot");
}

TEST_F(Pictures, TheOldCommandIsNamed) {
  expectRefused(scanmill({"picture", at("a"), "-o", at("p.png")}), "scanmill view INPUT --screenshot FILE.png");
}

TEST_F(Pictures, CloseUps) {
  for (const std::string place : {"0,0,0", "-1.5,2,-1e-1"}) {
    const Outcome alone = scanmill(of({"--at", place, "--within", "60", "--size", "320x200"}));
    EXPECT_EQ(alone.code, 0) << alone.error;
    EXPECT_THAT(readFile(at("p.png")), testing::StartsWith("\x89PNG"));
    const Outcome over = scanmill(of({"--at", place, "--within=60", "--over", at("a"), "--camera", "above"}));
    EXPECT_EQ(over.code, 0) << over.error;
  }
  EXPECT_THAT(scanmill({"view", "--help"}).out,
              AllOf(HasSubstr("--at X,Y,Z"), HasSubstr("--within R"), HasSubstr("--at 6.5,-2.7,-1 --within 2.5")));
}

// Colours by a column go by the column's name too.
TEST_F(Pictures, ColoursByLabelAreThoseByClass) {
  ASSERT_EQ(scanmill(of({"--color", "class"})).code, 0);
  const std::string byClass = readFile(at("p.png"));
  ASSERT_EQ(scanmill(of({"--color", "label"})).code, 0);
  EXPECT_EQ(readFile(at("p.png")), byClass);
}

TEST_F(Pictures, WrongCloseUpsAreRefusedWithAdvice) {
  const std::pair<std::vector<std::string>, std::string> cases[] = {
      {{"--at", "1,2,3"}, "both --at X,Y,Z"},
      {{"--within", "3"}, "both --at X,Y,Z"},
      {{"--at", "1,2", "--within", "3"}, "not '1,2'"},
      {{"--at", "1,2,3,4", "--within", "3"}, "such as 8,-3.5,-1"},
      {{"--at", "1,2,", "--within", "3"}, "not '1,2,'"},
      {{"--at", "1,nan,3", "--within", "3"}, "--at is X,Y,Z"},
      {{"--at", "1,2,1e9", "--within", "3"}, "at most"},
      {{"--at", "", "--within", "3"}, "--at is X,Y,Z"},
      {{"--at", "1,2,3", "--within", "0"}, "--within must be a number from 0.01"},
      {{"--at", "1,2,3", "--within", "-2"}, "--within must be a number from 0.01"},
      {{"--at", "1,2,3", "--within", "nan"}, "nan"},
      {{"--at", "1,2,3", "--within", "near"}, "near"},
      {{"--at", "1,2,3", "--within", "1,5"}, "not '1,5' (write a point"},
      {{"--at", "1,2,3", "--within", "3", "--range-image-alone"}, "takes no --at"},
      {{"--at", "1,2,3", "--within", "3", "--camera", "30,20,25,1,2,3"}, "leave X,Y,Z out"},
      {{"--at", "0,0,9999", "--within", "3"}, "the nearest is"},
  };
  std::vector<std::vector<std::string>> all;
  for (const auto& [arguments, says] : cases) all.push_back(of(arguments));
  all.push_back({"view", at("absent.exr"), "--screenshot", at("p.png"), "--at", "1,2,3", "--within", "3"});
  const std::vector<Outcome> outcomes = scanmillEach(all);
  for (std::size_t i = 0; i + 1 < outcomes.size(); ++i) {
    SCOPED_TRACE(testing::PrintToString(all[i]));
    expectRefused(outcomes[i], cases[i].second);
  }
  expectRefused(outcomes.back(), "takes no --at");
  EXPECT_FALSE(std::filesystem::exists(at("p.png")));
}

}  // namespace
}  // namespace scanmill
