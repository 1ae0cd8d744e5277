#include "dataset/scan_store.h"

#include "tests/support/message_of.h"
#include "tests/support/temporary_folder.h"

namespace scanmill {
namespace {

using testing::AllOf;
using testing::HasSubstr;

// 210 bytes must not ask for gigabytes.
TEST(ScanStore, BeamsThatNoSensorHasAreRefused) {
  const TemporaryFolder folder;
  const auto refused = [&](const std::string& point) {
    const auto file =
        folder.write("a.pcd",
                     "VERSION 0.7\nFIELDS x y z ring column\nSIZE 4 4 4 2 2\nTYPE F F F U U\nCOUNT 1 1 1 1 "
                     "1\nWIDTH 1\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS 1\nDATA ascii\n1 2 3 " +
                         point + "\n");
    return messageOf([&] { ScanStore store(file); });
  };
  EXPECT_THAT(refused("65535 65535"), AllOf(HasSubstr("a.pcd: has 1 points on beams of 65536 rings and 65536 columns"),
                                            HasSubstr("correct its columns")));
  EXPECT_EQ(refused("127 2047"), "accepted");
  EXPECT_EQ(refused("1023 4095"), "accepted");
}

// A run that has not ended has a plan in its hidden folder, and no manifest.
TEST(ScanStore, AnUnfinishedDatasetIsNamedSo) {
  const TemporaryFolder folder;
  folder.write(".scanmill/plan", "");
  EXPECT_THAT(messageOf([&] { ScanStore store(folder.path()); }),
              AllOf(HasSubstr("unfinished dataset"), HasSubstr("--resume")));
}

}  // namespace
}  // namespace scanmill
