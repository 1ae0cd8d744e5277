#pragma once

// Collects which files a thread reads, with hashes of their bytes, and limits what the files of one scene may cost: a
// small file can include other files, twice as many at each level, place a mesh a million times, or decompress to a
// thousand times its size. docs/reliability.md lists the limits. This header is installed because dataset/manifest.h
// includes it.
//
//   const InputBudget budget;           // around everything that is read for one scene
//   chargeCopies(1000, {"a.gltf"});     // throws InputError beyond the limit

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <string_view>

#include "base/error.h"

namespace scanmill {

// While an InputBudget lives on a thread, the functions below count on this thread. If the thread has a budget already,
// the new object joins it: all count together until the outermost object ends. Without a budget nothing is counted.
class [[nodiscard]] InputBudget {
 public:
  InputBudget();
  ~InputBudget();
  InputBudget& operator=(InputBudget&&) = delete;  // neither copied nor moved

  struct Counts;

 private:
  std::unique_ptr<Counts> started_;  // null if this object has joined another
};

// Each of the next five functions throws an InputLimitError at `where` if its sum exceeds the limit, which the message
// names, or if the thread has computed for longer than the limit of time.
//
// Counts a file that is opened, at most 100,000. The size of each file, counted once however often it is opened, raises
// the limits of bytes and pixels. readFile() calls it.
void chargeFile(const std::filesystem::path& file);
// Counts placed meshes, nodes, tiles, models and the like: at most ten million. Also charges `each` bytes per copy.
void chargeCopies(std::uint64_t copies, const Location& where, double each = 1024);
// Counts bytes that are decompressed, or copied from data already counted: at most 2 GiB plus 64 times the size of the
// files. Also throws if these bytes alone are more than memoryLimitBytes().
void chargeBytes(double bytes, const Location& where);
// Counts pixels of images that are decoded: at most 2^31 plus 64 for each byte of the files.
void chargePixels(double pixels, const Location& where);
// Checks only the limit of time, ten minutes of this thread's CPU time, and only at every 256th call.
void chargeTime(const Location& where);

// Thrown by the functions above. A reader that continues without a damaged image or other file must not catch it.
class InputLimitError : public InputError {
 public:
  using InputError::InputError;
};

// Multiplies all limits by a factor above 0 for as long as the object lives, in all threads.
class [[nodiscard]] InputLimitFactor {
 public:
  explicit InputLimitFactor(double multiplier);
  ~InputLimitFactor();
  InputLimitFactor& operator=(InputLimitFactor&&) = delete;  // neither copied nor moved

 private:
  double previous_;
};

// While a FilesRead lives on a thread, it collects the files that this thread reads. While a second FilesRead lives on
// the same thread, only the second one collects files.
class [[nodiscard]] FilesRead {
 public:
  FilesRead();
  ~FilesRead();
  FilesRead& operator=(FilesRead&&) = delete;  // neither copied nor moved

  // Returns the XXH3 of each file, see xxh3(), by its absolute path. Reads files again that libraries have read.
  std::map<std::filesystem::path, std::string> hashes() const;

 private:
  friend void recordFile(const std::filesystem::path& file);
  friend void recordFile(const std::filesystem::path& file, std::string_view bytes);

  std::map<std::filesystem::path, std::string> hashes_;  // an empty hash is not computed yet
  FilesRead* outer_;
};

// Record in the thread's latest FilesRead that a file is read; the second function also gets the file's bytes.
// readFile() and chargeFile() call them; readers that leave the reading to a library call the first function.
void recordFile(const std::filesystem::path& file);
void recordFile(const std::filesystem::path& file, std::string_view bytes);

}  // namespace scanmill
