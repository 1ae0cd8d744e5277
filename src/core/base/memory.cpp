#include "base/memory.h"

#include <malloc.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <filesystem>
#include <fstream>
#include <limits>
#include <string>

namespace scanmill {

namespace {

namespace fs = std::filesystem;

// Returns the least limit that `file` states in a control group and its ancestors; UINT64_MAX if none states a number.
std::uint64_t leastLimit(const fs::path& root, const std::string& group, const char* file) {
  std::uint64_t least = std::numeric_limits<std::uint64_t>::max();
  for (fs::path folder = fs::path(group).relative_path();; folder = folder.parent_path()) {
    std::uint64_t limit = 0;
    if (std::ifstream(root / folder / file) >> limit) least = std::min(least, limit);
    if (folder.empty()) return least;
  }
}

// Returns the smallest memory limit (bytes) of the program's control groups; UINT64_MAX if they have none.
std::uint64_t groupLimit() {
  std::uint64_t least = std::numeric_limits<std::uint64_t>::max();
  std::ifstream groups("/proc/self/cgroup");
  // A line is "0::/path" in version 2, "9:memory:/path" in version 1.
  for (std::string line; std::getline(groups, line);) {
    const std::size_t first = line.find(':');
    const std::size_t second = line.find(':', first + 1);
    if (second == std::string::npos) continue;
    const std::string kind = line.substr(first + 1, second - first - 1);
    const std::string group = line.substr(second + 1);
    if (kind.empty()) least = std::min(least, leastLimit("/sys/fs/cgroup", group, "memory.max"));
    if (kind == "memory") least = std::min(least, leastLimit("/sys/fs/cgroup/memory", group, "memory.limit_in_bytes"));
  }
  return least;
}

std::uint64_t addressSpaceLimit() {
  rlimit limit{};
  return ::getrlimit(RLIMIT_AS, &limit) == 0 ? limit.rlim_cur : std::numeric_limits<std::uint64_t>::max();
}

std::atomic<std::uint64_t> userLimit{0};  // the limit that the user sets (bytes); 0: no limit

std::uint64_t pageBytes() {
  return static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
}

}  // namespace

std::uint64_t memoryLimitBytes() {
  static const std::uint64_t limit = std::min(
      {static_cast<std::uint64_t>(::sysconf(_SC_PHYS_PAGES)) * pageBytes(), groupLimit(), addressSpaceLimit()});
  const std::uint64_t usersLimit = userLimit;
  return usersLimit > 0 ? std::min(limit, usersLimit) : limit;
}

MemoryLimit::MemoryLimit(std::uint64_t bytes) : previous_(userLimit.exchange(bytes)) {}

MemoryLimit::~MemoryLimit() {
  userLimit = previous_;
}

std::uint64_t residentBytes() {
  std::uint64_t total = 0;
  std::uint64_t resident = 0;
  std::ifstream("/proc/self/statm") >> total >> resident;
  return resident * pageBytes();
}

bool memoryIsScarce() {
  return residentBytes() > memoryLimitBytes() / 2;
}

void returnFreedMemoryIfScarce() {
  if (memoryIsScarce()) ::malloc_trim(0);
}

}  // namespace scanmill
