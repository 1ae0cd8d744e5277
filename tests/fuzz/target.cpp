#include "tests/fuzz/target.h"

#include <fstream>
#include <iterator>

#include "base/file.h"
#include "base/input_budget.h"
#include "base/memory.h"

namespace scanmill {

std::map<std::string, FuzzTarget>& fuzzTargets() {
  static std::map<std::string, FuzzTarget> targets;
  return targets;
}

void runWithinBudget(const FuzzTarget& target, std::string_view bytes) {
  const InputLimitFactor factor(1.0 / 16);
  const MemoryLimit memory(std::uint64_t{1} << 30);
  const InputBudget budget;
  target(bytes);
}

std::filesystem::path inputFile(std::string_view bytes, const std::string& suffix) {
  static const ScratchFolder folder;
  const std::filesystem::path file = folder.path() / ("input" + suffix);
  std::ofstream(file, std::ios::binary).write(bytes.data(), std::ssize(bytes));  // not flushed to the disk
  return file;
}

std::size_t kindOf(std::string_view& bytes, std::size_t kinds) {
  if (bytes.empty()) return 0;
  const auto first = static_cast<unsigned char>(bytes.front());
  bytes.remove_prefix(1);
  return (first - static_cast<unsigned char>('0')) % kinds;
}

}  // namespace scanmill
