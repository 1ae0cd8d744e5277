#include "base/memory.h"

#include <unistd.h>

#include <cstring>

namespace scanmill {
namespace {

TEST(Memory, TheLimitIsNoMoreThanTheMachineHas) {
  const auto machine =
      static_cast<std::uint64_t>(::sysconf(_SC_PHYS_PAGES)) * static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
  EXPECT_LE(memoryLimitBytes(), machine);
  EXPECT_GT(memoryLimitBytes(), residentBytes());
}

TEST(Memory, ItsUserMayAllowLess) {
  const std::uint64_t all = memoryLimitBytes();
  {
    const MemoryLimit outer(1 << 20);
    EXPECT_EQ(memoryLimitBytes(), 1u << 20);
    {
      const MemoryLimit none(0);
      EXPECT_EQ(memoryLimitBytes(), all);
    }
    EXPECT_EQ(memoryLimitBytes(), 1u << 20);
    const MemoryLimit more(all * 2);
    EXPECT_EQ(memoryLimitBytes(), all);
  }
  EXPECT_EQ(memoryLimitBytes(), all);
}

TEST(Memory, IsScarceWhereHalfOfWhatIsAllowedIsResident) {
  EXPECT_FALSE(memoryIsScarce()) << "this test takes less than half of the machine's memory";
  const MemoryLimit little(residentBytes());
  EXPECT_TRUE(memoryIsScarce());
}

TEST(Memory, WhatIsWrittenToIsResident) {
  constexpr std::size_t kBytes = 64 << 20;
  const std::uint64_t before = residentBytes();
  const std::unique_ptr<char[]> bytes(new char[kBytes]);
  std::memset(bytes.get(), 1, kBytes);
  [[maybe_unused]] const char* volatile used = bytes.get();  // without a use, a compiler may leave out the memory
  EXPECT_GE(residentBytes() + (1 << 20), before + kBytes);
}

}  // namespace
}  // namespace scanmill
