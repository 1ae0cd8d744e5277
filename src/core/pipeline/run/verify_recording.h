#pragma once

// Reads all files of a recording and compares them with what recording.json states.

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace scanmill {

struct RecordingVerification {
  std::uint64_t scans = 0;            // number of scans that recording.json lists
  std::uint64_t images = 0;           // number of images that the scans refer to
  std::uint64_t pixels = 0;           // number of pixels of all readable images; for recorded hits, the number of beams
  std::vector<std::string> problems;  // one line each, starting with the file; empty: the recording is sound
  std::vector<std::string> warnings;  // one line each, about valid contents that were probably not intended
};

// Returns all problems with scans and images: missing or damaged files, wrong sizes, steps that do not cover the
// columns, classes that are not in the recording's ontology, and materials that are not in its table. Throws InputError
// only if recording.json or the folder cannot be read. progress(done, total) counts images.
[[nodiscard]] RecordingVerification verifyRecording(
    const std::filesystem::path& folder, const std::function<void(std::uint64_t, std::uint64_t)>& progress = {});

}  // namespace scanmill
