#pragma once

// What bad input is told: the place, the name, what to do.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <utility>
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

// Returns what `work` prints on standard error, such as warnings.
template <class Work>
std::string printedBy(Work&& work) {
  testing::internal::CaptureStderr();
  work();
  return testing::internal::GetCapturedStderr();
}

// Each input of the table is refused with its words, which " | " separates. `refuse` returns the message about an
// input: see messageOf().
template <class Refuse>
void expectRefusals(const Refuse& refuse, const std::vector<std::pair<std::string, std::string>>& table) {
  for (const auto& [input, words] : table) {
    const std::string message = refuse(input);
    EXPECT_NE(message, "accepted") << input;
    for (std::size_t at = 0; at < words.size();) {
      const std::size_t end = std::min(words.find(" | ", at), words.size());
      EXPECT_THAT(message, testing::HasSubstr(words.substr(at, end - at))) << input;
      at = end + 3;
    }
  }
}

// `work` throws an InputError whose message holds all these words.
template <class Work>
void expectInputError(Work&& work, const std::vector<std::string>& words) {
  const std::string message = messageOf(work);
  EXPECT_NE(message, "accepted");
  for (const std::string& word : words) EXPECT_THAT(message, testing::HasSubstr(word));
}

}  // namespace scanmill
