#pragma once

#include <filesystem>

namespace scanmill {

// Print what `scanmill info` shows of a recording's folder, and of one EXR image of passes or hits.
void printRecording(const std::filesystem::path& folder);
void printExr(const std::filesystem::path& file);

}  // namespace scanmill
