#include "base/format_support.h"

namespace scanmill {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

TEST(LeftOut, ManyFilesAreToldInFewLines) {
  LeftOut leftOut;
  leftOut.add("things of this test", 2);
  testing::internal::CaptureStderr();
  for (int i = 1; i <= 9; ++i) leftOut.warn("file" + std::to_string(i));
  LeftOut other;
  other.add("other things of this test", 1);
  other.warn("file9");
  EXPECT_THAT(testing::internal::GetCapturedStderr(),
              AllOf(HasSubstr("file1: left out: 2 things of this test\n"), HasSubstr("file3: left out: 2 things"),
                    HasSubstr("file4 and other files, not named one by one: left out in each: 2 things"),
                    Not(HasSubstr("file5")), HasSubstr("file9: left out: 1 other things of this test\n")));
}

}  // namespace
}  // namespace scanmill
