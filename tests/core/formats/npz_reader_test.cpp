// Archives are made by numpy itself, where there is one.

#include <cstdlib>

#include "base/error.h"
#include "base/file.h"
#include "formats/readers.h"
#include "tests/support/message_of.h"
#include "tests/support/temporary_folder.h"

namespace scanmill {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

class Npz : public testing::Test {
 protected:
  // Runs `code`, which knows np and saves to `file`. Gives the file's bytes; empty where there is no numpy.
  std::string saved(const std::string& code) const {
    const auto file = folder_.path() / "a.npz";
    const auto script = folder_.write("save.py", "import numpy as np\nfile = '" + file.string() + "'\n" + code + "\n");
    if (std::system(("/usr/bin/python3 " + script.string()).c_str()) != 0) return {};
    return readFile(file);
  }
  TemporaryFolder folder_;
};

TEST_F(Npz, ColumnsAreReadInTheirTypes) {
  for (const std::string save : {"savez", "savez_compressed"}) {
    const std::string bytes = saved("np." + save + R"((file, xyz=np.array([[1, 2, 3], [4, 5, 6.5]], np.float64),
      intensity=np.array([7, 8], np.uint8), labels=np.array([40, 252], np.int64), near_ir=np.array([1, 2], np.uint16),
      boxes=np.zeros((3, 7), np.float32), key=np.array('text'), ring=np.array([3, 1], '<u4')))");
    if (bytes.empty()) GTEST_SKIP() << "numpy is missing: apt-get install python3-numpy";
    const Scan scan = readNpz(bytes, "a.npz").scan;
    ASSERT_EQ(scan.size(), 2u);
    EXPECT_EQ(scan.position[1], (Vec3f{4, 5, 6.5f}));
    EXPECT_THAT(scan[kIntensity], ElementsAre(7.0f, 8.0f));
    EXPECT_THAT(scan[kLabel], ElementsAre(40, 252));
    EXPECT_THAT(scan[kRing], ElementsAre(3, 1));
    EXPECT_EQ(scan.rings, 4u);
    ASSERT_EQ(scan.foreign.size(), 1u);
    EXPECT_EQ(scan.foreign[0].name, "near_ir");
  }
}

TEST_F(Npz, FourNumbersAPointHaveAnIntensityAndImagesKeepTheirRows) {
  std::string bytes = saved("np.savez(file, points=np.arange(8, dtype='f4').reshape(2, 4))");
  if (bytes.empty()) GTEST_SKIP() << "numpy is missing: apt-get install python3-numpy";
  EXPECT_THAT(readNpz(bytes, "a.npz").scan[kIntensity], ElementsAre(3.0f, 7.0f));
  bytes = saved("np.savez(file, xyz=np.full((2, 5, 3), np.nan, 'f4'), label=np.ones((2, 5), 'u1'))");
  const Scan scan = readNpz(bytes, "a.npz").scan;
  EXPECT_TRUE(scan.organised);
  EXPECT_EQ(scan.rings, 2u);
  EXPECT_EQ(scan.columns, 5u);
  EXPECT_EQ(scan[kLabel].size(), 10u);
}

TEST_F(Npz, WhatIsNoneIsRefusedWithTheArray) {
  const auto refused = [&](const std::string& bytes) { return messageOf([&] { readNpz(bytes, "a.npz"); }); };
  EXPECT_THAT(refused("no archive"), HasSubstr("a.npz: is no sound archive .npz"));
  std::string bytes = saved("np.savez(file, pos=np.zeros((2, 3)), image=np.zeros(4))");
  if (bytes.empty()) GTEST_SKIP() << "numpy is missing: apt-get install python3-numpy";
  EXPECT_THAT(refused(bytes), testing::AllOf(HasSubstr("no array `xyz` or `points`"), HasSubstr("pos, image")));
  EXPECT_THAT(refused(saved("np.savez(file, xyz=np.zeros((2, 3), '>f4'))")), HasSubstr("xyz.npy: is of the type"));
  EXPECT_THAT(refused(saved("np.savez(file, xyz=np.asfortranarray(np.zeros((2, 3))))")), HasSubstr("Fortran"));
  EXPECT_THAT(refused(saved("np.savez(file, xyz=np.zeros((2, 3)), label=np.array([1, -2]))")),
              HasSubstr("label of point 1 is -2"));
  EXPECT_THAT(refused(saved("np.savez(file, xyz=np.zeros((2, 3), complex))")), HasSubstr("xyz"));
  // Cut short, or changed, anywhere: an error or a scan, never more.
  bytes = saved("np.savez_compressed(file, xyz=np.random.rand(20, 3), label=np.arange(20))");
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::string damaged = bytes.substr(0, i);
    messageOf([&] { readNpz(damaged, "a.npz"); });
    damaged = bytes;
    damaged[i] = static_cast<char>(damaged[i] ^ 0x41);
    messageOf([&] { readNpz(damaged, "a.npz"); });
  }
}

}  // namespace
}  // namespace scanmill
