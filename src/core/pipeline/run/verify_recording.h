#pragma once

// Reads a recording whole and compares what is there with what recording.json names.

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace scanmill {

struct RecordingVerification {
  std::uint64_t scans = 0;            // that recording.json names
  std::uint64_t images = 0;           // that the scans name
  std::uint64_t pixels = 0;           // of the images that could be read; of hits: beams
  std::vector<std::string> problems;  // one line each, with the file; empty: the recording is sound
  std::vector<std::string> warnings;  // what is legal, but seldom meant
};

// Never throws for what is wrong with scans and images (one that is missing, damaged or of the wrong size, steps that
// do not cover the columns, a class that the recording's ontology does not have, a material that its table does not
// have): it goes on and lists all. An unreadable recording.json is an InputError. progress(done, total) counts images.
RecordingVerification verifyRecording(const std::filesystem::path& folder,
                                      const std::function<void(std::uint64_t, std::uint64_t)>& progress = {});

}  // namespace scanmill
