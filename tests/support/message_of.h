#pragma once

// What bad input is told: the place, the name, what to do.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "base/error.h"

namespace scanmill {

// The message of the Failure that `work` throws; "accepted" where it throws none.
template <class Failure = InputError, class Work>
std::string messageOf(Work&& work) {
  try {
    work();
  } catch (const Failure& failure) {
    return failure.what();
  }
  return "accepted";
}

// `work` throws an InputError whose message holds all these words.
template <class Work>
void expectInputError(Work&& work, const std::vector<std::string>& words) {
  const std::string message = messageOf(work);
  EXPECT_NE(message, "accepted");
  for (const std::string& word : words) EXPECT_THAT(message, testing::HasSubstr(word));
}

}  // namespace scanmill
