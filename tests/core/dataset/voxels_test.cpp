#include "dataset/voxels.h"

#include <fmt/core.h>

#include <cstdlib>

#include "base/error.h"
#include "base/file.h"
#include "formats/npy.h"
#include "tests/support/message_of.h"
#include "tests/support/temporary_folder.h"

namespace scanmill {
namespace {

using testing::HasSubstr;

ScanVoxels someVoxels() {
  ScanVoxels voxels;
  voxels.grid = {0.25, {-1, -2.5, -3}, {3, 4, 5}};
  for (std::size_t i = 0; i < voxels.grid.voxels(); ++i) {
    voxels.label.push_back(static_cast<std::uint16_t>(i * 1021));
    voxels.input.push_back(i % 2);
    voxels.invalid.push_back(i % 3 == 0 ? 1 : 0);
    voxels.unseen.push_back(i % 7 == 0 ? 1 : 0);
  }
  return voxels;
}

TEST(ScanVoxels, ComeBackAsTheyWere) {
  const ScanVoxels voxels = someVoxels();
  const std::string bytes = encodeVoxels(voxels);
  EXPECT_EQ(bytes, encodeVoxels(voxels));
  EXPECT_LE(bytes.size(), mostVoxelsBytes(voxels.grid));
  const ScanVoxels read = decodeVoxels(bytes, "a");
  EXPECT_EQ(read.grid, voxels.grid);
  EXPECT_EQ(read.label, voxels.label);
  EXPECT_EQ(read.input, voxels.input);
  EXPECT_EQ(read.invalid, voxels.invalid);
  EXPECT_EQ(read.unseen, voxels.unseen);
}

TEST(ScanVoxels, OfAnyContentAreNoLargerThanStated) {
  ScanVoxels voxels;
  voxels.grid.counts = {64, 64, 32};
  std::uint32_t state = 1;
  const auto draw = [&] { return state = state * 1664525 + 1013904223; };
  for (std::size_t i = 0; i < voxels.grid.voxels(); ++i) {
    voxels.label.push_back(static_cast<std::uint16_t>(draw() >> 16));
    for (auto* flags : {&voxels.input, &voxels.invalid, &voxels.unseen}) {
      flags->push_back(static_cast<std::uint8_t>(draw() >> 31));
    }
  }
  EXPECT_LE(encodeVoxels(voxels).size(), mostVoxelsBytes(voxels.grid));
}

TEST(ScanVoxels, AreReadByNumPy) {
  if (std::system("/usr/bin/python3 -c 'import numpy' >/dev/null 2>&1") != 0) GTEST_SKIP() << "numpy is absent";
  const TemporaryFolder folder;
  const ScanVoxels voxels = someVoxels();
  folder.write("voxels.npz", encodeVoxels(voxels));
  const std::filesystem::path script = folder.write("read.py", R"(
import os, sys
import numpy as np
os.chdir(sys.argv[1])
i = np.arange(60)
with np.load('voxels.npz') as z:
    assert sorted(z.files) == ['input', 'invalid', 'label', 'low', 'size', 'unseen'], z.files
    assert z['label'].dtype == np.uint16 and z['label'].shape == (3, 4, 5)
    assert np.array_equal(z['label'].ravel(), i * 1021)
    assert z['label'][2, 1, 3] == ((2 * 4 + 1) * 5 + 3) * 1021
    for name, expected in {'input': i % 2 == 1, 'invalid': i % 3 == 0, 'unseen': i % 7 == 0}.items():
        assert z[name].dtype == bool and np.array_equal(z[name], expected.reshape(3, 4, 5)), name
    assert z['low'].tolist() == [-1, -2.5, -3] and z['size'].shape == () and z['size'] == 0.25
)");
  const std::filesystem::path out = folder.path() / "out";
  const std::string command =
      fmt::format("/usr/bin/python3 '{}' '{}' > '{}' 2>&1", script.string(), folder.path().string(), out.string());
  EXPECT_EQ(std::system(command.c_str()), 0) << readFile(out);
}

TEST(ScanVoxels, OfAnotherSizeAreNotEncoded) {
  ScanVoxels voxels = someVoxels();
  voxels.unseen.pop_back();
  EXPECT_THAT(messageOf<Error>([&] { encodeVoxels(voxels); }), HasSubstr("59 bytes"));
}

TEST(ScanVoxels, ThatAreDamagedAreRefusedByName) {
  const std::string flags(8, '\1');
  const auto messageWith = [&](const std::string& name, const std::string& array) {
    std::vector<std::pair<std::string, std::string>> files{
        {"label.npy", npyOf("<u2", {2, 2, 2}, std::string(16, '\0'))},
        {"input.npy", npyOf("|b1", {2, 2, 2}, flags)},
        {"invalid.npy", npyOf("|b1", {2, 2, 2}, flags)},
        {"unseen.npy", npyOf("|b1", {2, 2, 2}, flags)},
        {"low.npy", npyOf("<f8", {3}, std::string(24, '\0'))},
        {"size.npy", npyOf("<f8", {}, std::string("\0\0\0\0\0\0\xf8\x3f", 8))}};
    for (auto& [file, bytes] : files) {
      if (file == name + ".npy") bytes = array;
    }
    return messageOf<InputError>([&] { decodeVoxels(zipOf(files), "the file"); });
  };
  EXPECT_THAT(messageWith("label", npyOf("<u4", {2, 2, 2}, std::string(32, '\0'))), HasSubstr("<u2"));
  EXPECT_THAT(messageWith("label", npyOf("<u2", {8}, std::string(16, '\0'))), HasSubstr("1 dimensions"));
  EXPECT_THAT(messageWith("label", npyOf("<u2", {0, 2, 2}, "")), HasSubstr("no voxels"));
  EXPECT_THAT(messageWith("input", npyOf("|b1", {2, 2, 1}, flags.substr(4))),
              HasSubstr("and label have different sizes"));
  EXPECT_THAT(messageWith("invalid", npyOf("|b1", {2, 2, 2}, std::string(8, '\2'))), HasSubstr("besides 0 and 1"));
  EXPECT_THAT(messageWith("low", npyOf("<f8", {2}, std::string(16, '\0'))), HasSubstr("2 numbers, but must have 3"));
  EXPECT_THAT(messageWith("size", npyOf("<f8", {}, std::string(8, '\0'))), HasSubstr("not above 0"));
  EXPECT_THAT(messageWith("size", npyOf("<f8", {}, std::string(8, '\xff'))), HasSubstr("not finite"));
  const std::string whole = encodeVoxels(someVoxels());
  const std::size_t last = whole.find("size.npy");  // what follows the arrays is not needed to read them
  ASSERT_NE(last, std::string::npos);
  for (std::size_t length = 0; length < last; length += 7) {
    EXPECT_THAT(messageOf<InputError>([&] { decodeVoxels(whole.substr(0, length), "the file"); }),
                testing::StartsWith("the file"));
  }
}

}  // namespace
}  // namespace scanmill
