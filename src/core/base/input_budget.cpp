#include "base/input_budget.h"

#include <fmt/format.h>
#include <sys/stat.h>

#include <atomic>
#include <set>
#include <utility>

#include "base/file.h"
#include "base/hash.h"
#include "base/memory.h"
#include "base/short_text.h"
#include "base/stage_clock.h"

namespace scanmill {

namespace {

// Limits on what the files of one scene may cost. All are multiplied by the user's factor.
constexpr double kMostFiles = 100'000;
constexpr double kMostCopies = 10'000'000;
constexpr double kMostBytes = 2147483648.0;
constexpr double kMostPixels = 2147483648.0;
constexpr double kMorePerByte = 64;  // growth of kMostBytes and kMostPixels per byte of the files
constexpr double kMostSeconds = 600;

std::atomic<double> factor{1};

thread_local FilesRead* innermostFiles = nullptr;

std::filesystem::path cleanPath(const std::filesystem::path& file) {
  return std::filesystem::absolute(file).lexically_normal();
}

}  // namespace

struct InputBudget::Counts {
  double files = 0;
  double copies = 0;
  double bytes = 0;
  double pixels = 0;
  double readBytes = 0;  // size of all files (bytes), each counted once
  std::set<std::pair<dev_t, ino_t>> filesSeen;
  double startSeconds = threadSeconds();
  std::uint32_t calls = 0;
};

namespace {

thread_local InputBudget::Counts* counts = nullptr;

[[noreturn]] void refuse(const Location& where, const std::string& exceeded) {
  throw InputLimitError(
      where,
      fmt::format("{}: a file that costs so much for its size is more often damaged or hostile than meant. If you "
                  "trust it, --input-limit 10 (in Python set_input_limit(10)) allows ten times as much",
                  exceeded));
}

// Adds `amount` to `sum`. Throws if the sum exceeds `limit`, with the text that describe(limit) returns.
template <class Text>
void add(double& sum, double amount, double limit, const Location& where, const Text& describe) {
  sum += amount;
  if (sum > limit) refuse(where, describe(limit));
  chargeTime(where);
}

}  // namespace

InputBudget::InputBudget() {
  if (counts != nullptr) return;
  started_ = std::make_unique<Counts>();
  counts = started_.get();
}

InputBudget::~InputBudget() {
  if (started_) counts = nullptr;
}

void chargeTime(const Location& where) {
  // The clock is read only at every 256th call, since reading it is a system call.
  if (counts == nullptr || ++counts->calls % 256 != 0) return;
  const double limit = kMostSeconds * factor;
  if (threadSeconds() - counts->startSeconds > limit) {
    refuse(where, fmt::format("the files of this scene take more than {} to read", shortTime(limit)));
  }
}

void chargeFile(const std::filesystem::path& file) {
  recordFile(file);
  if (counts == nullptr) return;
  struct stat status {};
  if (::stat(file.c_str(), &status) == 0 && S_ISREG(status.st_mode) &&
      counts->filesSeen.insert({status.st_dev, status.st_ino}).second) {
    counts->readBytes += static_cast<double>(status.st_size);
  }
  add(counts->files, 1, kMostFiles * factor, {file.string()},
      [](double limit) { return fmt::format("is one file too many: at most {:.0f} are opened for one scene", limit); });
}

void chargeCopies(std::uint64_t copies, const Location& where, double each) {
  if (counts == nullptr) return;
  add(counts->copies, static_cast<double>(copies), kMostCopies * factor, where, [](double limit) {
    return fmt::format("places more than {:.0f} meshes, nodes or models, with all copies", limit);
  });
  chargeBytes(each * static_cast<double>(copies), where);
}

void chargeBytes(double bytes, const Location& where) {
  const auto allowed = static_cast<double>(memoryLimitBytes());
  if (bytes > allowed) {
    throw InputLimitError(where,
                          fmt::format("needs {} of memory, but only {} are allowed (by --memory-limit, the machine or "
                                      "its container)",
                                      shortBytes(bytes), shortBytes(allowed)));
  }
  if (counts == nullptr) return;
  add(counts->bytes, bytes, (kMostBytes + kMorePerByte * counts->readBytes) * factor, where, [](double limit) {
    return fmt::format("holds, unpacked and with all copies, more than {}, the most for {} of files", shortBytes(limit),
                       shortBytes(counts->readBytes));
  });
}

void chargePixels(double pixels, const Location& where) {
  if (counts == nullptr) return;
  add(counts->pixels, pixels, (kMostPixels + kMorePerByte * counts->readBytes) * factor, where, [](double limit) {
    return fmt::format("has images that bring the scene's to more than {} pixels, the most for {} of files",
                       shortNumber(limit), shortBytes(counts->readBytes));
  });
}

InputLimitFactor::InputLimitFactor(double multiplier) : previous_(factor.exchange(multiplier)) {}

InputLimitFactor::~InputLimitFactor() {
  factor = previous_;
}

FilesRead::FilesRead() : outer_(innermostFiles) {
  innermostFiles = this;
}

FilesRead::~FilesRead() {
  innermostFiles = outer_;
}

std::map<std::filesystem::path, std::string> FilesRead::hashes() const {
  std::map<std::filesystem::path, std::string> hashes;
  for (const auto& [file, hash] : hashes_) {
    if (!isFile(file)) continue;  // readers go on without some files that are missing, such as textures
    hashes[file] = hash.empty() ? xxh3OfFile(file) : hash;
  }
  return hashes;
}

void recordFile(const std::filesystem::path& file) {
  if (innermostFiles != nullptr) innermostFiles->hashes_.try_emplace(cleanPath(file));
}

void recordFile(const std::filesystem::path& file, std::string_view bytes) {
  if (innermostFiles != nullptr) innermostFiles->hashes_[cleanPath(file)] = xxh3(bytes);
}

}  // namespace scanmill
