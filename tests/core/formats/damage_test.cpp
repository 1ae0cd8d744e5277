// Damaged bytes of every format: decode() gives a scan or throws InputError, and never asks for memory without reason.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <ostream>

#include "tests/core/formats/allocation_watch.h"
#include "tests/core/formats/scans.h"

namespace scanmill {
namespace {

constexpr std::size_t kMostMemory = std::size_t{256} << 20;

struct Case {
  const char* format;
  const char* options;
  unsigned columns;
  bool organised;
};

void PrintTo(const Case& tested, std::ostream* out) {
  *out << tested.format << " {" << tested.options << "}";
}

class Damage : public testing::TestWithParam<Case> {
 protected:
  void SetUp() override {
    format_ = makeFormat(GetParam().format, GetParam().options);
    good_ = format_->encode(randomScan(77, 8, 40, GetParam().columns, GetParam().organised, 60));
  }

  void expectDecodesOrRefuses(const std::string& bytes, const std::string& what) const {
    largestRequestSinceLastCall();
    try {
      format_->decode(bytes, "damaged.file");
    } catch (const InputError& error) {
      EXPECT_EQ(std::string(error.what()).rfind("damaged.file", 0), 0u) << error.what();
    } catch (const std::exception& error) {
      ADD_FAILURE() << what << ": " << error.what();
    }
    EXPECT_LT(largestRequestSinceLastCall(), kMostMemory) << what;
  }

  std::unique_ptr<Format> format_;
  std::string good_;
};

TEST_P(Damage, TruncatedAnywhere) {
  for (std::size_t i = 0; i < 64; ++i) {
    const std::size_t size = good_.size() * i / 64;
    expectDecodesOrRefuses(good_.substr(0, size), fmt::format("truncated to {} of {}", size, good_.size()));
  }
  // The last line of a text may lack its end; what lacks values is refused.
  const bool text = good_.back() == '\n';
  const std::size_t end = text ? good_.find_last_of(", ") : good_.size() - 2;
  EXPECT_THROW(format_->decode(good_.substr(0, end), "damaged.file"), InputError);
  EXPECT_THROW(format_->decode(good_.substr(0, good_.size() / 2), "damaged.file"), InputError);
}

TEST_P(Damage, OneByteChanged) {
  std::mt19937 generator(5);
  for (int i = 0; i < 500; ++i) {
    std::string bad = good_;
    // Half of the changes hit the first bytes, where the headers are.
    const std::size_t at = generator() % (i % 2 == 0 ? std::min<std::size_t>(300, bad.size()) : bad.size());
    const char before = bad[at];
    bad[at] = static_cast<char>(generator());
    expectDecodesOrRefuses(bad, fmt::format("byte {} from {} to {}", at, int{before}, int{bad[at]}));
  }
}

TEST_P(Damage, Garbage) {
  std::mt19937 generator(6);
  for (int i = 0; i < 100; ++i) {
    std::string bad = good_.substr(0, generator() % 64);
    for (std::size_t size = generator() % 400; bad.size() < size;) bad.push_back(static_cast<char>(generator()));
    expectDecodesOrRefuses(bad, fmt::format("garbage {}", i));
  }
}

INSTANTIATE_TEST_SUITE_P(Formats, Damage,
                         testing::Values(Case{"pcd", "encoding: binary_compressed", kAllColumns, true},
                                         Case{"pcd", "encoding: binary_compressed", 6, false},
                                         Case{"pcd", "encoding: binary", kAllColumns, true},
                                         Case{"pcd", "encoding: ascii", kAllColumns, true},
                                         Case{"draco", "{}", 30, false}, Case{"draco", "time: true", kAllColumns, true},
                                         Case{"draco", "max_error_mm: 100", 0, false},
                                         Case{"csv", "{}", kAllColumns, true}),
                         [](const testing::TestParamInfo<Case>& tested) {
                           return fmt::format("{}_{}", tested.param.format, tested.index);
                         });

}  // namespace
}  // namespace scanmill
