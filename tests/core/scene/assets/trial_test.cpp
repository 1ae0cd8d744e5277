#include "scene/assets/trial.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <stdexcept>
#include <string>

namespace scanmill {
namespace {

using testing::HasSubstr;

constexpr std::uint64_t kMemory = std::uint64_t{1} << 30;

TEST(TryApart, GivesWhatTheWorkReturns) {
  EXPECT_EQ(tryApart([] { return std::string(); }, kMemory, 10), "");
  const std::string longText(200000, 'x');
  EXPECT_EQ(tryApart([&] { return longText; }, kMemory, 10), longText);
  EXPECT_EQ(tryApart([]() -> std::string { throw std::runtime_error("no wheels"); }, kMemory, 10), "no wheels");
}

TEST(TryApart, OutlivesWhateverHappens) {
  const auto die = [](int signal) {
    return [signal] {
      ::raise(signal);
      return std::string();
    };
  };
  EXPECT_THAT(tryApart(die(SIGSEGV), kMemory, 10), HasSubstr("signal 11"));
  EXPECT_THAT(tryApart(die(SIGABRT), kMemory, 10), HasSubstr("signal 6"));
  EXPECT_NE(tryApart([]() -> std::string { ::_Exit(3); }, kMemory, 10), "");
  volatile bool forever = true;
  EXPECT_THAT(tryApart(
                  [&] {
                    while (forever) {
                    }
                    return std::string();
                  },
                  kMemory, 1),
              HasSubstr("more than 1 s"));
}

TEST(TryApart, WhatHappensThereStaysThere) {
  int value = 1;
  testing::internal::CaptureStdout();
  tryApart(
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
