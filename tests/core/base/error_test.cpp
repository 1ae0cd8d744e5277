#include "base/error.h"

#include <new>

#include "tests/support/on_threads.h"

namespace scanmill {
namespace {

TEST(Location, ShowsWhatIsKnown) {
  EXPECT_EQ((Location{"a.yaml", 3, 7}.text()), "a.yaml:3:7");
  EXPECT_EQ((Location{"a.yaml", 3, 0}.text()), "a.yaml:3");
  EXPECT_EQ((Location{"a.yaml", 0, 0}.text()), "a.yaml");
  EXPECT_EQ(Location{}.text(), "");
}

TEST(InputError, StartsWithItsPlace) {
  EXPECT_STREQ(InputError({"a.yaml", 3, 7}, "is odd").what(), "a.yaml:3:7: is odd");
  EXPECT_STREQ(InputError({}, "is odd").what(), "is odd");
  EXPECT_STREQ(InputError("is odd").what(), "is odd");
  EXPECT_THROW(throw InputError("x"), Error);
}

TEST(ReasonOf, IsInWordsOfUsers) {
  EXPECT_EQ(reasonOf(std::runtime_error("[json.exception.type_error.302] type must be string, but is null")),
            "type must be string, but is null");
  EXPECT_EQ(reasonOf(InputError("a.yaml: [json.exception] is odd")), "a.yaml: [json.exception] is odd");
  EXPECT_EQ(reasonOf(std::runtime_error("[json.exception.")), "[json.exception.");
  EXPECT_EQ(reasonOf(std::bad_alloc()), "the memory ran out");
  EXPECT_EQ(reasonOf(std::bad_array_new_length()), "the memory ran out");
  EXPECT_EQ(reasonOf(std::length_error("vector::_M_default_append")), "the memory ran out");
}

TEST(Warn, SaysEachTextOnce) {
  const std::size_t before = warningCount();
  testing::internal::CaptureStderr();
  onThreads(8, [](std::size_t) {
    warn("the texture leaf.png is missing");
    warn("the texture bark.png is missing");
  });
  const std::string shown = testing::internal::GetCapturedStderr();
  EXPECT_EQ(warningCount(), before + 2);
  const std::string leaf = "warning: the texture leaf.png is missing\n";
  const std::string bark = "warning: the texture bark.png is missing\n";
  EXPECT_TRUE(shown == leaf + bark || shown == bark + leaf) << shown;
}

}  // namespace
}  // namespace scanmill
