// What fuzzing has found, and where it begins: every input is read or refused, in any build.

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <set>
#include <vector>

#include "base/error.h"
#include "base/file.h"
#include "tests/fuzz/target.h"

namespace scanmill {
namespace {

namespace fs = std::filesystem;

const fs::path kCorpus = fs::path(SCANMILL_SOURCE_DIR) / "tests/fuzz/corpus";

std::vector<std::string> targetNames() {
  std::vector<std::string> names;
  for (const auto& [name, target] : fuzzTargets()) names.push_back(name);
  return names;
}

class Corpus : public testing::TestWithParam<std::string> {};

TEST_P(Corpus, IsReadOrRefused) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(kCorpus / GetParam())) files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  ASSERT_FALSE(files.empty());
  std::size_t read = 0;
  for (const fs::path& file : files) {
    SCOPED_TRACE(file);
    try {
      runWithinBudget(fuzzTargets().at(GetParam()), readFile(file));
      ++read;
    } catch (const Error&) {
    }
  }
  EXPECT_GT(read, 0u) << "no seed is a sound file";
}

TEST(Corpora, AreOfTargets) {
  const std::vector<std::string> names = targetNames();
  for (const auto& entry : fs::directory_iterator(kCorpus)) {
    EXPECT_EQ(std::count(names.begin(), names.end(), entry.path().filename().string()), 1) << entry.path();
  }
}

INSTANTIATE_TEST_SUITE_P(Of, Corpus, testing::ValuesIn(targetNames()), [](const auto& one) { return one.param; });

}  // namespace
}  // namespace scanmill
