#include "dataset/shard_writer.h"

#include <archive.h>
#include <archive_entry.h>
#include <fmt/core.h>

#include <algorithm>
#include <exception>
#include <set>
#include <utility>

#include "base/error.h"
#include "base/file.h"
#include "base/hash.h"
#include "base/own_folder.h"
#include "dataset/names.h"

namespace scanmill {

namespace {

// Number of bytes that are hashed and then written at a time, while they are still in the cache.
constexpr std::size_t kPieceBytes = 1 << 17;
// Number of bytes up to which headers, padding and short members are collected before they are written.
constexpr std::size_t kShortBytes = 1 << 14;
constexpr std::uint64_t kTarBlockBytes = 512;
constexpr std::size_t kMostUstarNameBytes = 100;

// Returns the number of bytes rounded up to complete blocks of a tar file.
std::uint64_t paddedBytes(std::uint64_t bytes) {
  return (bytes + kTarBlockBytes - 1) / kTarBlockBytes * kTarBlockBytes;
}

constexpr std::string_view kJsonSuffix = "json";

[[noreturn]] void refuse(const Sample& sample, const std::string& why) {
  throw Error("sample '{}' cannot be written: {}", sample.key, why);
}

// Throws Error for names that WebDataset would misread. WebDataset joins consecutive members to a sample if their names
// agree up to the first dot, and uses the rest of the name, in lower case, as the member's key. Names must be printable
// ASCII, so that all tar readers read the same names.
void checkNames(const Sample& sample) {
  const auto isAllowed = [](char c) { return c > ' ' && c < 0x7f && c != '/' && c != '\\'; };
  if (sample.key.empty() || !std::ranges::all_of(sample.key, [&](char c) { return isAllowed(c) && c != '.'; })) {
    refuse(sample, "its key must be printable ASCII without dots, slashes and spaces");
  }
  if (!isSplitName(sample.split)) refuse(sample, fmt::format("'{}' is not a name of a split", sample.split));
  std::set<std::string_view> suffixes{kJsonSuffix};
  for (const Member& file : sample.files) {
    const std::string& suffix = file.suffix;
    if (suffix.empty() || suffix.front() == '.' ||
        !std::ranges::all_of(suffix, [&](char c) { return isAllowed(c) && !(c >= 'A' && c <= 'Z'); })) {
      refuse(sample,
             fmt::format("the suffix '{}' must be lower-case printable ASCII without slashes and spaces", suffix));
    }
    if (!suffixes.insert(suffix).second) refuse(sample, fmt::format("the suffix '{}' is used twice", suffix));
  }
}

// Creates `folder` and the folders in it that lead to `file`. Returns `file`.
std::filesystem::path prepareFile(const std::filesystem::path& folder, const std::filesystem::path& file) {
  std::filesystem::create_directories(folder);
  makeFolders(folder, file.parent_path());
  return file;
}

}  // namespace

struct ShardFile::State {
  std::filesystem::path path;
  AtomicFile file;
  Sha256 hash;
  archive* tar = archive_write_new();
  archive_entry* entry = archive_entry_new();
  std::string pendingBytes;    // bytes that are not hashed and written yet
  std::exception_ptr failure;  // exception from writeBytes(), which must not pass through libarchive's C code
  bool discard = false;        // if true, nothing more is written

  State(const std::filesystem::path& folder, const std::filesystem::path& tarPath)
      : path(tarPath), file(folder, tarPath) {}
  ~State() {
    archive_entry_free(entry);
    discard = true;  // set first, because freeing an unfinished archive flushes it
    archive_write_free(tar);
  }
  State& operator=(State&&) = delete;  // neither copied nor moved

  // Callback of libarchive that writes bytes and returns `size`. `self`: the State.
  static la_ssize_t writeBytes(archive*, void* self, const void* data, std::size_t size) {
    State& state = *static_cast<State*>(self);
    if (state.discard) return static_cast<la_ssize_t>(size);
    try {
      state.put({static_cast<const char*>(data), size});
    } catch (...) {
      // The failure is hidden from libarchive, which leaks its buffers after a failed write; check() throws it to the
      // caller.
      state.failure = std::current_exception();
      state.discard = true;
    }
    return static_cast<la_ssize_t>(size);
  }

  // Hashes and writes bytes. Short texts are collected first, and written before the next long text or by flush().
  void put(std::string_view bytes) {
    if (bytes.size() + pendingBytes.size() <= kShortBytes) {
      pendingBytes += bytes;
      return;
    }
    flush();
    for (std::size_t first = 0; first < bytes.size(); first += kPieceBytes) {
      const std::string_view piece = bytes.substr(first, kPieceBytes);
      hash.add(piece);
      file.write(piece);
    }
  }

  void flush() {
    hash.add(pendingBytes);
    file.write(pendingBytes);
    pendingBytes.clear();
  }

  // Throws the exception of writeBytes(), or Error if a function of libarchive returned a failure.
  void check(la_ssize_t result) {
    if (failure) std::rethrow_exception(failure);
    if (result < ARCHIVE_OK) {
      throw Error("{}: cannot be written as tar: {}", path.string(), archive_error_string(tar));
    }
  }
};

ShardFile::ShardFile(const std::filesystem::path& folder, const std::filesystem::path& path)
    : state_(std::make_unique<State>(folder, path)) {
  State& s = *state_;
  s.check(archive_write_set_format_pax_restricted(s.tar));
  s.check(archive_write_set_bytes_per_block(s.tar, 0));      // no blocks: libarchive passes bytes on without a copy
  s.check(archive_write_set_bytes_in_last_block(s.tar, 1));  // the end is not padded to a complete block
  s.check(archive_write_open(s.tar, &s, nullptr, &State::writeBytes, nullptr));
}

ShardFile::~ShardFile() = default;

void ShardFile::add(const std::string& name, std::string_view bytes) {
  State& s = *state_;
  archive_entry_clear(s.entry);
  archive_entry_set_pathname(s.entry, name.c_str());
  archive_entry_set_filetype(s.entry, AE_IFREG);
  archive_entry_set_perm(s.entry, 0644);
  archive_entry_set_size(s.entry, static_cast<la_int64_t>(bytes.size()));
  archive_entry_set_mtime(s.entry, 0, 0);
  s.check(archive_write_header(s.tar, s.entry));
  s.check(archive_write_data(s.tar, bytes.data(), bytes.size()));
  s.check(archive_write_finish_entry(s.tar));
}

ShardFile::Digest ShardFile::close() {
  State& s = *state_;
  s.check(archive_write_close(s.tar));
  s.flush();
  s.file.commit();
  return {s.hash.hex(), s.file.size()};
}

std::uint64_t ShardFile::memberBytes(std::size_t nameLength, std::uint64_t bytes) {
  std::uint64_t size = kTarBlockBytes + paddedBytes(bytes);
  // A long name needs a pax header with one record: "<length> path=<name>\n".
  constexpr std::size_t kRecordBytes = 16;  // upper bound of the record's bytes beside the name
  if (nameLength > kMostUstarNameBytes) size += kTarBlockBytes + paddedBytes(nameLength + kRecordBytes);
  return size;
}

std::uint64_t bytesInShard(const Sample& sample) {
  const auto bytesOf = [&](std::string_view suffix, std::size_t size) {
    return ShardFile::memberBytes(sample.key.size() + 1 + suffix.size(), size);
  };
  std::uint64_t bytes = bytesOf(kJsonSuffix, sampleJson(sample).size());
  for (const Member& file : sample.files) bytes += bytesOf(file.suffix, file.bytes.size());
  return bytes;
}

ShardWriter::ShardWriter(const std::filesystem::path& folder, const std::string& name, const std::string& split)
    : part_{.shard = {.file = name, .split = split, .sha256 = {}}, .samples = {}},
      file_(folder, prepareFile(folder, folder / name)) {}

void ShardWriter::add(const Sample& sample) {
  if (broken_) refuse(sample, "an earlier sample of this shard failed");
  checkNames(sample);
  if (sample.split != part_.shard.split) {
    refuse(sample, fmt::format("it belongs to the split {}, but the shard to {}", sample.split, part_.shard.split));
  }
  SampleRecord record = sample;
  const std::string json = sampleJson(record);
  std::vector<std::string_view> contents{json};  // contents of the members, in order
  record.members.push_back(fmt::format("{}.{}", sample.key, kJsonSuffix));
  for (const Member& file : sample.files) {
    record.members.push_back(fmt::format("{}.{}", sample.key, file.suffix));
    contents.push_back(file.bytes);
  }
  broken_ = true;
  for (std::size_t i = 0; i < contents.size(); ++i) {
    file_.add(record.members[i], contents[i]);
    record.xxh3.push_back(xxh3(contents[i]));
  }
  part_.samples.push_back(std::move(record));
  broken_ = false;
}

ShardPart ShardWriter::finish() {
  if (broken_) throw Error("{}: cannot be finished: a sample could not be written", part_.shard.file);
  const ShardFile::Digest digest = file_.close();
  part_.shard.sha256 = digest.sha256;
  part_.shard.bytes = digest.bytes;
  part_.shard.samples = part_.samples.size();
  return std::move(part_);
}

}  // namespace scanmill
