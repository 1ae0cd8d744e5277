#include "base/input_budget.h"

#include <thread>

#include "base/file.h"
#include "base/hash.h"
#include "base/memory.h"
#include "tests/support/message_of.h"
#include "tests/support/temporary_folder.h"

namespace scanmill {
namespace {

using testing::AllOf;
using testing::HasSubstr;

constexpr double kGiB = 1073741824;

TEST(InputBudget, CountsNothingWithoutABudget) {
  for (int i = 0; i < 3; ++i) {
    EXPECT_NO_THROW(chargeCopies(9'000'000, {"a.gltf"}, 0));
    EXPECT_NO_THROW(chargePixels(2 * kGiB, {"a.png"}));
  }
}

TEST(InputBudget, SumsWhatBelongsTogether) {
  const InputBudget budget;
  chargeBytes(kGiB, {"a.npz"});
  EXPECT_NO_THROW(chargeBytes(kGiB, {"b.npz"}));
  EXPECT_THAT(messageOf<InputLimitError>([] {
                chargeBytes(1, {"c.npz", 7});
              }),
              AllOf(HasSubstr("c.npz:7: "), HasSubstr("more than 2.0 GiB"), HasSubstr("--input-limit")));
  EXPECT_NO_THROW(chargePixels(kGiB, {"c.png"})) << "each kind has a sum of its own";
}

TEST(InputBudget, IsOfOneThreadAndOneScope) {
  const InputBudget outer;
  chargePixels(2 * kGiB, {"a.png"});
  {
    const InputBudget inner;
    EXPECT_THROW(chargePixels(1, {"a.png"}), InputLimitError) << "the inner one joins the outer one";
  }
  EXPECT_THROW(chargePixels(1, {"a.png"}), InputLimitError) << "the outer one goes on";
  std::thread([] {
    const InputBudget other;
    EXPECT_NO_THROW(chargePixels(2 * kGiB, {"a.png"}));
  }).join();
}

TEST(InputBudget, BeginsAnew) {
  for (int i = 0; i < 3; ++i) {
    const InputBudget budget;
    EXPECT_NO_THROW(chargePixels(2 * kGiB, {"a.png"}));
  }
}

TEST(InputBudget, TheSizeOfEachFileRaisesTheLimitOnce) {
  const TemporaryFolder folder;
  const auto file = folder.path() / "a.bin";
  writeFile(file, std::string(1000, 'x'));
  const InputBudget budget;
  chargePixels(2 * kGiB, {"a.png"});
  EXPECT_EQ(readFile(file).size(), 1000u);
  EXPECT_NO_THROW(chargePixels(64'000, {"a.png"}));
  std::filesystem::create_hard_link(file, folder.path() / "b.bin");
  EXPECT_EQ(readFile(file).size() + readFile(folder.path() / "b.bin").size(), 2000u);
  EXPECT_THROW(chargePixels(1, {"a.png"}), InputLimitError);
}

TEST(InputBudget, CountsFilesThatAreOpenedAgain) {
  const TemporaryFolder folder;
  const auto file = folder.path() / "a.json";
  writeFile(file, "{}");
  const InputBudget budget;
  for (int i = 0; i < 100'000; ++i) chargeFile(file);
  EXPECT_THAT(messageOf<InputLimitError>([&] { readFile(file); }),
              AllOf(HasSubstr("a.json: "), HasSubstr("100000 are opened")));
}

TEST(InputBudget, CountsTheTimeOfItsThread) {
  const InputLimitFactor factor(1e-4);  // 60 ms
  const InputBudget budget;
  EXPECT_THAT(messageOf<InputLimitError>([] {
                for (;;) chargeTime({"map.osm"});
              }),
              HasSubstr("map.osm: "));
}

TEST(InputBudget, AFactorRaisesAllLimits) {
  const InputBudget budget;
  {
    const InputLimitFactor factor(10);
    EXPECT_NO_THROW(chargePixels(20 * kGiB, {"a.png"}));
    EXPECT_NO_THROW(chargeCopies(100'000'000, {"a.gltf"}, 0));
    EXPECT_THROW(chargeCopies(1, {"a.gltf"}, 0), InputLimitError);
  }
  EXPECT_THROW(chargePixels(1, {"a.png"}), InputLimitError);
}

TEST(InputBudget, NothingIsLargerThanTheMemory) {
  const MemoryLimit limit(100'000'000);
  EXPECT_THAT(messageOf<InputLimitError>([] { chargeBytes(100'000'001, {"a.npz"}); }),
              AllOf(HasSubstr("a.npz: "), HasSubstr("--memory-limit")));
}

// Files that this program reads, that libraries read, and that are missing; none while another object takes them.
TEST(FilesRead, CollectsWhatTheThreadReads) {
  const TemporaryFolder folder;
  const auto read = folder.write("read.obj", "v 0 0 0");
  const auto noted = folder.write("noted.tif", "II*");
  const auto temporary = folder.write("temporary.glb", "glTF");
  const FilesRead files;
  readFile(folder.path() / "." / "read.obj");
  recordFile(noted);
  recordFile(folder.path() / "missing.png");
  {
    const FilesRead inner;
    readFile(temporary);
    EXPECT_EQ(inner.hashes().count(temporary), 1u);
  }
  const std::map<std::filesystem::path, std::string> expected{{read, xxh3("v 0 0 0")}, {noted, xxh3("II*")}};
  EXPECT_EQ(files.hashes(), expected);
}

}  // namespace
}  // namespace scanmill
