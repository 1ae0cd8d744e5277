#include "assets/meshes/child_process.h"

#include <csignal>
#include <cstdio>
#include <stdexcept>

#include "tests/support/message_of.h"
#include "tests/support/sanitizers.h"

namespace scanmill {
namespace {

using testing::HasSubstr;

constexpr std::uint64_t kMemory = std::uint64_t{1} << 30;

TEST(InChildProcess, GivesWhatTheWorkReturns) {
  EXPECT_EQ(inChildProcess([] { return std::string(); }, kMemory, 10), "");
  std::string bytes(10 << 20, '\0');
  for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<char>(i * 7 + i / 256);
  EXPECT_TRUE(inChildProcess([&] { return bytes; }, kMemory, 10) == bytes);
  EXPECT_EQ(messageOf<Error>(
                [] { inChildProcess([]() -> std::string { throw std::runtime_error("no wheels"); }, kMemory, 10); }),
            "no wheels");
}

TEST(InChildProcess, SaysHowTheChildEnded) {
  const auto end = [](const std::function<std::string()>& work, unsigned seconds = 10) {
    return messageOf<ChildEnded>([&] { inChildProcess(work, kMemory, seconds); });
  };
  const auto die = [](int signal) {
    return [signal] {
      ::raise(signal);
      return std::string();
    };
  };
  EXPECT_THAT(end(die(SIGSEGV)), HasSubstr("signal 11"));
  EXPECT_THAT(end(die(SIGABRT)), HasSubstr("signal 6"));
  EXPECT_THAT(end([]() -> std::string { ::_Exit(1); }), HasSubstr("makes the importer exit"));
  volatile bool forever = true;
  EXPECT_THAT(end(
                  [&] {
                    while (forever) {
                    }
                    return std::string();
                  },
                  1),
              HasSubstr("more than 1 s"));
  EXPECT_THAT(end([]() -> std::string { throw std::length_error("basic_string::_M_create"); }),
              HasSubstr("more than 1.1 GB of memory"));
  if (kSanitized) return;  // sanitizers end the process where an allocation fails
  EXPECT_THAT(end([] { return std::string(std::size_t{3} << 30, 'x'); }), HasSubstr("more than 1.1 GB of memory"));
}

TEST(InChildProcess, WhatHappensThereStaysThere) {
  int value = 1;
  testing::internal::CaptureStdout();
  inChildProcess(
      [&] {
        value = 2;
        std::puts("noise");
        std::fflush(stdout);
        return std::string();
      },
      kMemory, 10);
  EXPECT_EQ(value, 1);
  EXPECT_EQ(testing::internal::GetCapturedStdout(), "");
}

}  // namespace
}  // namespace scanmill
