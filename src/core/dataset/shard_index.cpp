#include "dataset/shard_index.h"

#include <fcntl.h>
#include <fmt/core.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>
#include <utility>

#include "base/error.h"
#include "base/file.h"
#include "dataset/tar_reader.h"

namespace scanmill {

namespace {

// Number of bytes to read at a time: enough for a header and a preceding pax header.
constexpr std::size_t kHeaderBytes = 2048;

std::string errnoText(int error) {
  return std::generic_category().message(error);
}

}  // namespace

ShardIndex::ShardIndex(std::filesystem::path file) : file_(std::move(file)) {
  TarReader tar(file_, kHeaderBytes);
  try {
    while (tar.next()) members_.push_back({tar.name(), tar.offset(), tar.bytes()});
  } catch (const InputError& e) {
    if (members_.empty()) throw;
    damage_ = e.what();
  }
  byName_.reserve(members_.size());
  for (std::size_t i = 0; i < members_.size(); ++i) byName_.emplace(members_[i].name, i);
}

const ShardMember* ShardIndex::find(std::string_view name) const {
  const auto found = byName_.find(name);
  return found == byName_.end() ? nullptr : &members_[found->second];
}

std::string ShardIndex::read(const ShardMember& member) const {
  const Descriptor file(::open(file_.c_str(), O_RDONLY | O_CLOEXEC));
  if (file.number < 0) throw InputError({file_.string()}, "cannot be read: " + errnoText(errno));
  std::string bytes(member.bytes, '\0');
  std::size_t done = 0;
  while (done < bytes.size()) {
    const ssize_t got =
        ::pread(file.number, bytes.data() + done, bytes.size() - done, static_cast<off_t>(member.offset + done));
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) throw InputError({file_.string()}, fmt::format("cannot read '{}': {}", member.name, errnoText(errno)));
    if (got == 0) {
      throw InputError({file_.string()},
                       fmt::format("is truncated in '{}': it was longer when it was opened", member.name));
    }
    done += static_cast<std::size_t>(got);
  }
  return bytes;
}

}  // namespace scanmill
