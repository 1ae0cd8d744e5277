#include "assets/worlds/missing_files.h"

#include <fmt/format.h>

#include <set>

namespace scanmill {

void MissingFiles::add(const MissingFileError& error) {
  errors_.push_back(error);
}

void MissingFiles::noteOrThrow(bool leaveOut, LeftOut& leftOut) const {
  if (leaveOut) {
    for (const MissingFileError& e : errors_) leftOut.add(fmt::format("missing models and meshes ('{}')", e.name));
    return;
  }
  if (errors_.empty()) return;
  const MissingFileError& first = errors_.front();
  std::set<std::string> named{first.name};
  std::string others;
  for (const MissingFileError& e : errors_) {
    if (!named.insert(e.name).second) continue;
    const bool sameFile = e.where.file == first.where.file && e.where.line > 0;
    others += fmt::format("{} '{}' ({})", others.empty() ? "" : ",", e.name,
                          sameFile ? fmt::format("line {}", e.where.line) : e.where.text());
  }
  throw InputError(fmt::format(
      "{}{}{}; `missing: leave_out` of the object (--leave-out-missing of `info` and `draft`) goes on without {}",
      first.what(), others.empty() ? "" : "; further ones are missing:", others, named.size() == 1 ? "it" : "them"));
}

}  // namespace scanmill
