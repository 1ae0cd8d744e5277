#include "formats/npy.h"

#include <fmt/core.h>

#include <cstdlib>

#include "base/error.h"
#include "base/file.h"
#include "base/input_budget.h"
#include "tests/support/message_of.h"
#include "tests/support/temporary_folder.h"

namespace scanmill {
namespace {

using Files = std::vector<std::pair<std::string, std::string>>;

// Python's own modules are the independent readers: zipfile checks sizes and CRC-32.
class ZipFile : public testing::Test {
 protected:
  void readBack(const std::string& bytes, const std::string& code) const {
    const std::filesystem::path file = folder_.write("archive", bytes);
    const std::filesystem::path script =
        folder_.write("script.py", "import io, sys, zipfile\nimport numpy as np\nfile = sys.argv[1]\n" + code);
    const std::filesystem::path out = folder_.path() / "out";
    const std::string command =
        fmt::format("/usr/bin/python3 '{}' '{}' > '{}' 2>&1", script.string(), file.string(), out.string());
    EXPECT_EQ(std::system(command.c_str()), 0) << readFile(out);
  }

  TemporaryFolder folder_;
};

TEST_F(ZipFile, HoldsItsFilesInOrder) {
  std::string noise;  // does not shrink, and has all bytes
  for (std::uint32_t i = 0, state = 1; i < 5000; ++i) {
    state = state * 1664525 + 1013904223;
    noise += static_cast<char>(state >> 24);
  }
  const Files files{{"empty", ""}, {"folder/zeros", std::string(3'000'000, '\0')}, {"noise.bin", noise}, {"a", "a"}};
  const std::string archive = zipOf(files);
  EXPECT_LT(archive.size(), 10'000u) << "zeros are deflated";
  EXPECT_EQ(archive, zipOf(files));
  const std::filesystem::path noiseFile = folder_.write("noise", noise);
  readBack(archive, fmt::format(R"(
with zipfile.ZipFile(file) as z:
    assert z.testzip() is None
    assert z.namelist() == ['empty', 'folder/zeros', 'noise.bin', 'a'], z.namelist()
    assert z.read('empty') == b'' and z.read('a') == b'a'
    assert z.read('folder/zeros') == bytes(3000000)
    assert z.read('noise.bin') == open('{}', 'rb').read()
    for info in z.infolist():
        assert info.date_time == (1980, 1, 1, 0, 0, 0), info.date_time
)",
                                noiseFile.string()));
}

TEST_F(ZipFile, MayHoldNothing) {
  readBack(zipOf({}), "assert zipfile.ZipFile(file).namelist() == []\n");
}

// Neither the clock nor the time zone is written.
TEST_F(ZipFile, IsTheSameInAllTimeZones) {
  const Files files{{"a", "some"}, {"b", "bytes"}};
  const std::string archive = zipOf(files);
  for (const char* zone : {"Pacific/Kiritimati", "America/Adak"}) {
    ::setenv("TZ", zone, 1);
    ::tzset();
    EXPECT_EQ(zipOf(files), archive) << zone;
  }
  ::unsetenv("TZ");
  ::tzset();
}

// numpy.load() itself reads the header.
TEST_F(ZipFile, OfArraysIsNumPysNpz) {
  std::string numbers;
  for (int i = 0; i < 12; ++i) numbers += {static_cast<char>(i), 1};
  const Files files{{"line.npy", npyOf("<u2", {12}, numbers)},
                    {"table.npy", npyOf("<u2", {3, 4}, numbers)},
                    {"bytes.npy", npyOf("|u1", {2, 3, 4}, numbers)},
                    {"none.npy", npyOf("<f4", {0, 3}, "")},
                    {"one.npy", npyOf("<f8", {}, std::string("\0\0\0\0\0\0\xf8\x3f", 8))},
                    {"text.npy", npyOf("<U2", {1}, std::string("h\0\0\0i\0\0\0", 8))}};
  readBack(zipOf(files), R"(
with np.load(file) as z:
    expected = np.arange(12) + 256
    assert z['line'].dtype == np.uint16 and np.array_equal(z['line'], expected)
    assert np.array_equal(z['table'], expected.reshape(3, 4)) and z['table'].flags['C_CONTIGUOUS']
    assert z['bytes'].dtype == np.uint8 and z['bytes'].shape == (2, 3, 4) and z['bytes'][1, 2, 2] == 11
    assert z['none'].dtype == np.float32 and z['none'].shape == (0, 3)
    assert z['one'].shape == () and z['one'] == 1.5
    assert z['text'].tolist() == ['hi']
)");
}

TEST(Npy, ElementsBeginAtAMultipleOf64Bytes) {
  for (const std::vector<std::size_t>& shape : {std::vector<std::size_t>{5}, {1, 5}, {1, 1, 1, 1, 1, 1, 1, 1, 5}}) {
    const std::string file = npyOf("|u1", shape, "abcde");
    EXPECT_EQ(file.size() % 64, 5u);
    EXPECT_EQ(file[file.size() - 6], '\n');
  }
}

TEST(Npy, DamagedArchivesAreRefusedWithTheArray) {
  const auto refused = [](const std::string& archive) { return messageOf([&] { readNpzArrays(archive, "a.npz"); }); };
  const auto changed = [](std::string array, std::string_view from, std::string_view to) {
    array.replace(array.find(from), from.size(), to);
    const Files files{{"xyz.npy", array}};
    return zipOf(files);
  };
  const std::string array = npyOf("<f4", {2, 3}, std::string(24, 'x'));
  const std::string good = changed(array, "<f4", "<f4");
  EXPECT_EQ(readNpzArrays(good, "a.npz").at(0).shape, (std::vector<std::size_t>{2, 3}));
  EXPECT_THAT(refused("no archive"), testing::HasSubstr("a.npz: is no sound archive .npz"));
  EXPECT_THAT(refused(changed(array, "<f4", ">f4")), testing::HasSubstr("a.npz: xyz.npy: is of the type >f4"));
  EXPECT_THAT(refused(changed(array, "False", "True ")), testing::HasSubstr("Fortran"));
  EXPECT_THAT(refused(changed(array, "(2, 3)", "(2, 4)")), testing::HasSubstr("has 24 bytes"));
  EXPECT_THAT(refused(changed(array, "(2, 3)", "      ")), testing::HasSubstr("no shape"));
  // Cut short, or changed, anywhere: an error or arrays, never more.
  for (std::size_t i = 0; i < good.size(); ++i) {
    std::string damaged = good;
    damaged[i] = static_cast<char>(damaged[i] ^ 0x41);
    refused(damaged);
    refused(good.substr(0, i));
  }
  const InputBudget budget;
  const InputLimitFactor little(1e-6);
  const Files zeros{{"zeros.npy", npyOf("|u1", {100'000}, std::string(100'000, '\0'))}};
  EXPECT_THAT(refused(zipOf(zeros)), testing::HasSubstr("unpacked"));
}

TEST(Npy, RefusesBytesThatAreNotOfTheShape) {
  EXPECT_THAT(messageOf<Error>([] {
                npyOf("<f4", {2, 3}, "abc");
              }),
              testing::AllOf(testing::HasSubstr("3 bytes"), testing::HasSubstr("24")));
  EXPECT_THAT(messageOf<Error>([] { npyOf("float", {1}, "abcd"); }), testing::HasSubstr("'float'"));
}

}  // namespace
}  // namespace scanmill
