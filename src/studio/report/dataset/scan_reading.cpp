#include "report/dataset/scan_reading.h"

#include <fmt/core.h>

#include <algorithm>
#include <fstream>
#include <functional>
#include <map>
#include <numeric>
#include <optional>
#include <utility>

#include "base/error.h"
#include "base/hash.h"
#include "base/parallel.h"
#include "dataset/reader.h"
#include "dataset/tar_reader.h"

namespace scanmill {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t kBatchScans = 64;
constexpr std::size_t kHeaderBlock = 1 << 12;

std::string hashOf(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  std::vector<char> block(1 << 20);
  Sha256 hash;
  while (stream) {
    stream.read(block.data(), static_cast<std::streamsize>(block.size()));
    hash.add({block.data(), static_cast<std::size_t>(stream.gcount())});
  }
  return stream.eof() ? hash.hex() : std::string();
}

std::string faultOf(const fs::path& file, const ShardRecord& record, bool hashed) {
  std::error_code failure;
  if (!fs::is_regular_file(file, failure)) return "is missing";
  const std::uint64_t bytes = fs::file_size(file, failure);
  if (failure) return "cannot be read: " + failure.message();
  if (bytes != record.bytes) return fmt::format("has {} bytes, not {} as the manifest says", bytes, record.bytes);
  if (!hashed) return {};
  const std::string hash = hashOf(file);
  if (hash.empty()) return "cannot be read";
  return hash == record.sha256 ? "" : "is damaged: its SHA-256 is not the manifest's";
}

std::string bytesAt(const fs::path& file, std::uint64_t offset, std::uint64_t bytes) {
  std::ifstream stream(file, std::ios::binary);
  std::string content(bytes, '\0');
  stream.seekg(static_cast<std::streamoff>(offset));
  stream.read(content.data(), static_cast<std::streamsize>(bytes));
  if (!stream) throw InputError({file.string()}, fmt::format("cannot be read at offset {}", offset));
  return content;
}

// One shard's scans: what is not wanted is not read, and a shard that is cut short is read as far as it goes.
class ShardReading {
 public:
  ShardReading(const fs::path& folder, const Manifest& manifest, std::uint32_t shard, const ScanReading& reading)
      : record_(manifest.shards[shard]), file_(folder / record_.file), reading_(reading) {
    formats_ = manifest.formats;
    std::stable_sort(formats_.begin(), formats_.end(),
                     [](const auto& a, const auto& b) { return a.maxErrorMetres < b.maxErrorMetres; });
  }

  void want(std::size_t k, const SampleRecord& sample, const ScanRecord& scan) {
    Wish& wish = wishes_.emplace_back(Wish{k, fmt::format("{}, {}", sample.key, scan.sensor), {}});
    for (const FormatRecord& format : formats_) {
      const std::string member = sample.key + "." + memberSuffix(scan, format.suffix);
      if (std::find(sample.members.begin(), sample.members.end(), member) == sample.members.end()) continue;
      wish.members.push_back(member);
      places_.emplace(member, std::nullopt);
    }
  }

  std::vector<std::string> run() {
    std::error_code failure;
    if (!fs::is_regular_file(file_, failure)) return {};  // a shard's fault, and told as one
    findMembers();
    for (std::size_t first = 0; first < wishes_.size(); first += kBatchScans) {
      if (reading_.stop != nullptr && *reading_.stop) throw Error("stopped: nothing was written");
      readBatch(first, std::min(first + kBatchScans, wishes_.size()));
    }
    return std::move(problems_);
  }

 private:
  struct Wish {
    std::size_t k = 0;
    std::string title;
    std::vector<std::string> members;  // the most exact first
  };
  struct Place {
    std::uint64_t offset = 0, bytes = 0;
  };

  void problem(std::string_view text) {
    const std::string place = file_.string() + ": ";
    if (text.starts_with(place)) text.remove_prefix(place.size());
    problems_.push_back(fmt::format("{}: {}", record_.file, text));
  }

  void findMembers() {
    try {
      TarReader tar(file_, kHeaderBlock);
      while (tar.next()) {
        const auto wanted = places_.find(tar.name());
        if (wanted != places_.end()) wanted->second = Place{tar.offset(), tar.bytes()};
      }
    } catch (const InputError& error) {
      problem(error.what());
    }
  }

  void readBatch(std::size_t begin, std::size_t end) {
    std::vector<std::string> failures(end - begin);
    std::vector<std::uint64_t> points(end - begin, 0);
    parallelFor(end - begin, 1, [&](std::size_t first, std::size_t last) {
      for (std::size_t i = first; i < last; ++i) failures[i] = readScan(wishes_[begin + i], points[i]);
    });
    for (const std::string& failure : failures) {
      if (!failure.empty()) problem(failure);
    }
    if (reading_.advance)
      reading_.advance(end - begin, std::accumulate(points.begin(), points.end(), std::uint64_t{0}));
  }

  // Empty, or why no format of the scan can be read.
  std::string readScan(const Wish& wish, std::uint64_t& points) const {
    std::string why;
    for (const std::string& name : wish.members) {
      const std::optional<Place>& place = places_.at(name);
      if (!place) continue;
      Scan scan;
      try {
        scan = decodeMember(name, bytesAt(file_, place->offset, place->bytes));
      } catch (const std::exception& error) {
        why += fmt::format("{}{}", why.empty() ? "" : "; ", error.what());
        continue;
      }
      points = scan.size();
      reading_.take(wish.k, std::move(scan));
      return {};
    }
    return why.empty() ? fmt::format("the scan of {} is not there", wish.title) : why;
  }

  const ShardRecord& record_;
  fs::path file_;
  const ScanReading& reading_;
  std::vector<FormatRecord> formats_;
  std::vector<Wish> wishes_;
  std::map<std::string, std::optional<Place>, std::less<>> places_;  // of the wanted members; absent: not found
  std::vector<std::string> problems_;
};

}  // namespace

std::vector<std::string> shardFaults(const fs::path& folder, const Manifest& manifest, bool hashed) {
  std::vector<std::string> faults(manifest.shards.size());
  parallelFor(faults.size(), 1, [&](std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i) {
      faults[i] = faultOf(folder / manifest.shards[i].file, manifest.shards[i], hashed);
    }
  });
  return faults;
}

std::vector<std::string> readScans(const fs::path& folder, const Manifest& manifest,
                                   const std::vector<ScanPlace>& places, const ScanReading& reading) {
  std::map<std::uint32_t, ShardReading> shards;
  for (std::size_t k = 0; k < places.size(); ++k) {
    const SampleRecord& sample = manifest.samples[places[k].sample];
    const auto shard = shards.try_emplace(sample.shard, folder, manifest, sample.shard, reading).first;
    shard->second.want(k, sample, sample.scans[places[k].scan]);
  }
  std::vector<std::string> problems;
  for (auto& [number, shard] : shards) {
    const std::vector<std::string> own = shard.run();
    problems.insert(problems.end(), own.begin(), own.end());
  }
  return problems;
}

}  // namespace scanmill
