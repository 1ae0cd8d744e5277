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
  ScopedVariable(std::string name, const std::string& value) : name_(std::move(name)) {
    if (const char* old = std::getenv(name_.c_str())) old_ = old;
    ::setenv(name_.c_str(), value.c_str(), 1);
  }
  ~ScopedVariable() {
    if (old_) {
      ::setenv(name_.c_str(), old_->c_str(), 1);
    } else {
      ::unsetenv(name_.c_str());
    }
  }
  ScopedVariable(const ScopedVariable&) = delete;
  ScopedVariable& operator=(const ScopedVariable&) = delete;

 private:
  std::string name_;
  std::optional<std::string> old_;
};
