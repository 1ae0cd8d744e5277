#pragma once

// Bad input must be an InputError whose message holds certain words: the place, the name, what to do.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "base/error.h"

template <class Action>
void expectInputError(Action action, const std::vector<std::string>& words) {
  try {
    action();
  } catch (const scanmill::InputError& e) {
    for (const std::string& word : words) EXPECT_THAT(e.what(), testing::HasSubstr(word));
    return;
  }
  ADD_FAILURE() << "no InputError; expected one with '" << (words.empty() ? "" : words.front()) << "'";
}
