#pragma once

// Reads all files of a recording and compares them with what recording.json states.

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace scanmill {

struct RecordingVerification {
  std::uint64_t scans = 0;            // scans that recording.json names
  std::uint64_t images = 0;           // images that the scans name
  std::uint64_t pixels = 0;           // pixels of the images that could be read; for hits: beams
  std::vector<std::string> problems;  // one line each, with the file; empty: the recording is sound
  std::vector<std::string> warnings;  // about what is legal, but seldom meant so
};

// Returns a list of all problems with scans and images: files that are missing, damaged or of the wrong size, steps
// that do not cover the columns, classes that the recording's ontology lacks, materials that its table lacks. Throws
// InputError only for an unreadable recording.json or folder. progress(done, total) counts images.
RecordingVerification verifyRecording(const std::filesystem::path& folder,
                                      const std::function<void(std::uint64_t, std::uint64_t)>& progress = {});

}  // namespace scanmill
