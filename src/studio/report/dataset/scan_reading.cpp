#include "report/dataset/scan_reading.h"

#include <fmt/core.h>

#include <utility>

#include "base/append_new.h"
#include "base/file.h"
#include "base/parallel.h"
#include "base/random.h"

namespace scanmill {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t kBatchScans = 64;  // number of scans that are read between two reports of progress

Scan readScan(const ScanStore& store, const ScanIndex& index) {
  const SampleRecord& sample = store.manifest()->samples[index.sample];
  const ScanRecord& record = sample.scans[index.scan];
  for (const StoredScan& scan : store.scans(index.sample)) {
    if (scan.record == &record) return store.decode(index.sample, scan);
  }
  throw InputError(fmt::format("the scan of {}, {} is missing", sample.key, record.sensor));
}

// Returns a random number from the Philox generator. The key is the seed; the counter consists of the sample and a word
// for the purpose of the number, which is therefore independent of the program's other random numbers.
std::uint64_t randomNumber(std::uint64_t seed, std::size_t sample) {
  constexpr std::uint32_t kPictures = 0xFFFF0000u;
  const RandomBlock block = philox4x32(
      {static_cast<std::uint32_t>(sample), static_cast<std::uint32_t>(std::uint64_t{sample} >> 32), 0, kPictures},
      {static_cast<std::uint32_t>(seed), static_cast<std::uint32_t>(seed >> 32)});
  return std::uint64_t{block[0]} << 32 | block[1];
}

// The samples of a split that have points and are not in damaged shards.
struct SplitSamples {
  std::string split;
  std::vector<std::pair<std::uint64_t, std::size_t>> shuffled;  // pairs of random number and index of the sample
};

}  // namespace

std::string readingFault(const ScanStore& store, std::size_t sample, const InputError& error) {
  const std::string damage = store.damage(sample);
  std::string fault = damage.empty() ? error.what() : damage;
  const std::string folder = (store.folder() / "").string();
  if (fault.starts_with(folder)) fault.erase(0, folder.size());
  return fault;
}

std::vector<std::string> readScans(const ScanStore& store, const std::vector<ScanIndex>& places,
                                   const ScanReading& reading) {
  const Manifest& manifest = *store.manifest();
  std::vector<std::string> problems(places.size());
  for (std::size_t begin = 0; begin < places.size(); begin += kBatchScans) {
    if (reading.stop != nullptr && *reading.stop) throw Error("stopped: nothing was written");
    const std::size_t count = std::min(kBatchScans, places.size() - begin);
    std::vector<std::uint64_t> points(count, 0);
    parallelForEach(count, 1, [&](std::size_t i) {
      const ScanIndex& index = places[begin + i];
      const fs::path shard = store.folder() / manifest.shards[manifest.samples[index.sample].shard].file;
      if (!isFile(shard)) return;  // shardFaults() reports the missing shard
      try {
        Scan scan = readScan(store, index);
        points[i] = scan.size();
        reading.take(begin + i, std::move(scan));
      } catch (const InputError& error) {
        problems[begin + i] = readingFault(store, index.sample, error);
      }
    });
    if (reading.advance) {
      for (const std::uint64_t n : points) reading.advance(n);
    }
  }
  std::erase(problems, "");
  std::vector<std::string> different;
  appendNew(problems, different);
  return different;
}

std::vector<ScanIndex> spreadScans(const Manifest& manifest, std::size_t most) {
  std::vector<ScanIndex> scans;
  for (std::size_t s = 0; s < manifest.samples.size(); ++s) {
    for (std::size_t i = 0; i < manifest.samples[s].scans.size(); ++i) scans.push_back({s, i});
  }
  if (scans.size() <= most) return scans;
  std::vector<ScanIndex> spread;  // the middle scan of each of `most` equal parts
  for (std::size_t k = 0; k < most; ++k) spread.push_back(scans[(2 * k + 1) * scans.size() / (2 * most)]);
  return spread;
}

std::vector<ScanIndex> randomScans(const Manifest& manifest, const std::vector<bool>& sound, std::size_t count,
                                   std::uint64_t seed) {
  std::vector<SplitSamples> splits;
  for (std::size_t s = 0; s < manifest.samples.size(); ++s) {
    const SampleRecord& sample = manifest.samples[s];
    const bool hasPoints = std::ranges::any_of(sample.scans, [](const auto& r) { return r.points > 0; });
    if (!hasPoints || !sound[sample.shard]) continue;
    auto split = std::ranges::find(splits, sample.split, &SplitSamples::split);
    if (split == splits.end()) split = splits.insert(splits.end(), {sample.split, {}});
    split->shuffled.emplace_back(randomNumber(seed, s), s);
  }
  for (SplitSamples& split : splits) std::ranges::sort(split.shuffled);
  // Take the first sample of each split, then the second and so on.
  std::vector<ScanIndex> chosen;
  for (std::size_t k = 0; k < manifest.samples.size(); ++k) {
    for (const SplitSamples& split : splits) {
      if (k >= split.shuffled.size() || chosen.size() >= count) continue;
      const std::size_t sample = split.shuffled[k].second;
      const std::vector<ScanRecord>& scans = manifest.samples[sample].scans;
      std::size_t scan = chosen.size() % scans.size();
      while (scans[scan].points == 0) scan = (scan + 1) % scans.size();
      chosen.push_back({sample, scan});
    }
  }
  return chosen;
}

}  // namespace scanmill
