#pragma once

#include <string>

#include "base/error.h"

// The message of the InputError that `action` throws; "no error" where it throws none.
template <class Action>
std::string errorOf(const Action& action) {
  try {
    action();
  } catch (const scanmill::InputError& e) {
    return e.what();
  }
  return "no error";
}
