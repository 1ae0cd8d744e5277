#pragma once

// Tests that need Blender, and variables of the environment that hold for a while.

#include <gtest/gtest.h>

#include <cstdlib>
#include <optional>
#include <string>

#include "base/process.h"

#define SKIP_WITHOUT_BLENDER()                  \
  if (scanmill::findProgram("blender").empty()) \
  GTEST_SKIP() << "Blender is not installed: scripts/setup --blender installs it"

class ScopedVariable {
 public:
  // Without a value, the variable is not set.
  ScopedVariable(std::string name, const std::optional<std::string>& value) : name_(std::move(name)) {
    if (const char* old = std::getenv(name_.c_str())) old_ = old;
    set(value);
  }
  ~ScopedVariable() { set(old_); }
  ScopedVariable(const ScopedVariable&) = delete;
  ScopedVariable& operator=(const ScopedVariable&) = delete;

 private:
  void set(const std::optional<std::string>& value) const {
    if (value) {
      ::setenv(name_.c_str(), value->c_str(), 1);
    } else {
      ::unsetenv(name_.c_str());
    }
  }

  std::string name_;
  std::optional<std::string> old_;
};
