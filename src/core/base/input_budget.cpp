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

constexpr double kFiles = 100'000;
constexpr double kCopies = 10'000'000;
constexpr double kBytes = 2147483648.0;
constexpr double kPixels = 2147483648.0;
constexpr double kPerByte = 64;  // bytes, and pixels, for each byte of the files
constexpr double kSeconds = 600;

std::atomic<double> factor{1};

thread_local FilesRead* latest = nullptr;

std::filesystem::path cleanPath(const std::filesystem::path& file) {
  return std::filesystem::absolute(file).lexically_normal();
}

}  // namespace

struct InputBudget::Counts {
  double files = 0;
  double copies = 0;
  double bytes = 0;
  double pixels = 0;
  double read = 0;  // size of all files (bytes), each counted once
  std::set<std::pair<dev_t, ino_t>> known;
  double began = threadSeconds();
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

// Adds to a sum and compares it with its limit, which `says` describes ("would decode more than {}").
template <class Text>
void add(double& sum, double amount, double limit, const Location& where, const Text& says) {
  sum += amount;
  if (sum > limit) refuse(where, says(limit));
  chargeTime(where);
}

}  // namespace

InputBudget::InputBudget() {
  if (counts != nullptr) return;
  own_ = std::make_unique<Counts>();
  counts = own_.get();
}

InputBudget::~InputBudget() {
  if (own_) counts = nullptr;
}

void chargeTime(const Location& where) {
  // Reading this clock is a system call.
  if (counts == nullptr || ++counts->calls % 256 != 0) return;
  const double limit = kSeconds * factor;
  if (threadSeconds() - counts->began > limit) {
    refuse(where, fmt::format("the files of this scene take more than {} to read", shortTime(limit)));
  }
}

void chargeFile(const std::filesystem::path& file) {
  recordFile(file);
  if (counts == nullptr) return;
  struct stat status {};
  if (::stat(file.c_str(), &status) == 0 && S_ISREG(status.st_mode) &&
      counts->known.insert({status.st_dev, status.st_ino}).second) {
    counts->read += static_cast<double>(status.st_size);
  }
  add(counts->files, 1, kFiles * factor, {file.string()},
      [](double limit) { return fmt::format("is one file too many: at most {:.0f} are opened for one scene", limit); });
}

void chargeCopies(std::uint64_t copies, const Location& where, double each) {
  if (counts == nullptr) return;
  add(counts->copies, static_cast<double>(copies), kCopies * factor, where, [](double limit) {
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
  add(counts->bytes, bytes, (kBytes + kPerByte * counts->read) * factor, where, [](double limit) {
    return fmt::format("holds, unpacked and with all copies, more than {}, the most for {} of files", shortBytes(limit),
                       shortBytes(counts->read));
  });
}

void chargePixels(double pixels, const Location& where) {
  if (counts == nullptr) return;
  add(counts->pixels, pixels, (kPixels + kPerByte * counts->read) * factor, where, [](double limit) {
    return fmt::format("has images that bring the scene's to more than {} pixels, the most for {} of files",
                       shortNumber(limit), shortBytes(counts->read));
  });
}

InputLimitFactor::InputLimitFactor(double by) : before_(factor.exchange(by)) {}

InputLimitFactor::~InputLimitFactor() {
  factor = before_;
}

FilesRead::FilesRead() : outer_(latest) {
  latest = this;
}

FilesRead::~FilesRead() {
  latest = outer_;
}

std::map<std::filesystem::path, std::string> FilesRead::hashes() const {
  std::map<std::filesystem::path, std::string> all = hashes_;
  std::erase_if(all, [](const auto& entry) {  // readers go on without some files that are missing, such as textures
    return !isFile(entry.first);
  });
  for (auto& [file, hash] : all) {
    if (hash.empty()) hash = xxh3OfFile(file);
  }
  return all;
}

void recordFile(const std::filesystem::path& file) {
  if (latest != nullptr) latest->hashes_.try_emplace(cleanPath(file));
}

void recordFile(const std::filesystem::path& file, std::string_view bytes) {
  if (latest != nullptr) latest->hashes_[cleanPath(file)] = xxh3(bytes);
}

}  // namespace scanmill
