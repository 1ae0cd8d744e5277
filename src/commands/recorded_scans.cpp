#include "commands/recorded_scans.h"

#include <fmt/core.h>

#include <algorithm>

#include "base/error.h"
#include "dataset/scan_store.h"

namespace scanmill {

namespace {

constexpr std::size_t kMostScans = 100;  // greatest number of scans per path; callers keep all of them in memory

}  // namespace

std::string requiredText(const Arguments& parsed, const std::string& option, const std::string& what) {
  std::string text = parsed.text(option);
  if (text.empty()) throw InputError(fmt::format("--{} is missing: {}", option, what));
  return text;
}

void forEachScan(const std::vector<std::string>& given,
                 const std::function<void(const Scan&, const std::string&)>& visit) {
  for (const std::string& path : given) {
    const ScanStore store(path);
    const std::size_t stored = store.keys().size();
    const std::size_t count = std::min(stored, kMostScans);
    if (count < stored) warn(fmt::format("{}: reads {} of its {} scans, evenly spaced", path, count, stored));
    for (std::size_t k = 0; k < count; ++k) {
      const std::size_t i = k * stored / count;
      visit(store.decode(i, store.scans(i).front()), store.single() ? path : store.keys()[i]);
    }
  }
}

std::filesystem::path requiredFile(const Arguments& parsed, const std::string& what) {
  std::filesystem::path out = requiredText(parsed, "out", what);
  std::error_code ignored;
  if (std::filesystem::is_directory(out, ignored)) throw InputError({out.string()}, "is a folder: name a file");
  if (std::filesystem::exists(out, ignored) && !parsed.has("overwrite")) {
    throw InputError({out.string()}, "exists: choose another name, or add --overwrite");
  }
  return out;
}

}  // namespace scanmill
