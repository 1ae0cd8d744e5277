#pragma once

#include <filesystem>

namespace scanmill {

// Print `scanmill info` of a recording's folder, and of one image of passes or hits.
void printRecording(const std::filesystem::path& folder);
void printExr(const std::filesystem::path& file);

}  // namespace scanmill
