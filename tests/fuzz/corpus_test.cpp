// What fuzzing has found, and where it begins: every input is read or refused, in any build.

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <random>
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

std::vector<std::string> inputsOf(const std::string& target) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(kCorpus / target)) files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  std::vector<std::string> inputs;
  for (const fs::path& file : files) inputs.push_back(readFile(file));
  return inputs;
}

// Returns whether the bytes were read; they may be refused instead.
bool wasRead(const std::string& target, std::string_view bytes) {
  try {
    runWithinBudget(fuzzTargets().at(target), bytes);
    return true;
  } catch (const Error&) {
    return false;
  }
}

TEST_P(Corpus, IsReadOrRefused) {
  const std::vector<std::string> inputs = inputsOf(GetParam());
  ASSERT_FALSE(inputs.empty());
  EXPECT_GT(std::count_if(inputs.begin(), inputs.end(), [&](const auto& bytes) { return wasRead(GetParam(), bytes); }),
            0)
      << "no seed is a sound file";
}

// Cut short anywhere, or with some bytes changed, most of them in the first 300, where the headers are.
TEST_P(Corpus, IsReadOrRefusedWhateverIsDamaged) {
  std::minstd_rand random(5);
  for (const std::string& good : inputsOf(GetParam())) {
    for (std::size_t i = 0; i < 16; ++i) wasRead(GetParam(), std::string_view(good).substr(0, good.size() * i / 16));
    for (std::size_t i = 0; i < 48 && !good.empty(); ++i) {
      std::string bad = good;
      for (std::size_t k = 0; k <= i % 3; ++k) {
        bad[random() % (i % 4 == 0 ? bad.size() : std::min<std::size_t>(bad.size(), 300))] =
            static_cast<char>(random());
      }
      wasRead(GetParam(), bad);
    }
  }
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
