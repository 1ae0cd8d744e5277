#pragma once

// Third-party scenes, sensors and recordings lie beside the checkout, or where SCANMILL_ASSETS points.

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>

inline std::filesystem::path sharedData() {
  if (const char* folder = std::getenv("SCANMILL_ASSETS")) return folder;
  return std::filesystem::path(SCANMILL_SOURCE_DIR).parent_path() / "shared" / "data";
}

#define SKIP_WITHOUT_SHARED_DATA(relative)                 \
  if (!std::filesystem::exists(sharedData() / (relative))) \
  GTEST_SKIP() << (sharedData() / (relative)).string() << " is absent: set SCANMILL_ASSETS to the folder that holds it"
