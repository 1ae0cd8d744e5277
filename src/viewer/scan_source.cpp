#include "viewer/scan_source.h"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <utility>
#include <vector>

#include "base/error.h"
#include "base/file.h"
#include "dataset/manifest.h"
#include "dataset/reader.h"
#include "dataset/shard_name.h"
#include "formats/format.h"

namespace scanmill {

namespace {

// "dir/key.top.ray_tracing.pcd": WebDataset's key ends at the first dot of the file's name.
struct MemberName {
  std::string key;
  std::string sensor;  // empty where the name has no such part
  std::string format;  // suffix
};

MemberName partsOf(const std::string& member) {
  const std::size_t slash = member.rfind('/');
  const std::size_t dot = member.find('.', slash == std::string::npos ? 0 : slash);
  if (dot == std::string::npos) return {member, {}, {}};
  const std::size_t last = member.rfind('.');
  MemberName parts{member.substr(0, dot), {}, member.substr(last + 1)};
  if (last > dot) parts.sensor = member.substr(dot + 1, member.find('.', dot + 1) - dot - 1);
  return parts;
}

std::string lowerCase(std::string text) {
  for (char& c : text) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  return text;
}

// Levenshtein's distance.
std::size_t edits(const std::string& a, const std::string& b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 0; i < a.size(); ++i) {
    std::size_t diagonal = std::exchange(row[0], i + 1);
    for (std::size_t j = 0; j < b.size(); ++j) {
      const std::size_t substituted = diagonal + (a[i] == b[j] ? 0 : 1);
      diagonal = row[j + 1];
      row[j + 1] = std::min({substituted, diagonal + 1, row[j] + 1});
    }
  }
  return row.back();
}

std::vector<std::string> nearest(const std::string& wanted, const std::vector<std::string>& keys) {
  constexpr std::size_t kShown = 3;
  std::vector<std::pair<std::size_t, std::size_t>> order;
  for (std::size_t i = 0; i < keys.size(); ++i) order.emplace_back(edits(wanted, keys[i]), i);
  std::sort(order.begin(), order.end());
  std::vector<std::string> out;
  for (std::size_t i = 0; i < std::min(kShown, order.size()); ++i) out.push_back(keys[order[i].second]);
  return out;
}

std::size_t chooseSample(const std::vector<std::string>& keys, const std::string& wanted,
                         const std::filesystem::path& where) {
  if (keys.empty()) throw InputError({where.string()}, "holds no sample");
  if (wanted.empty()) return keys.size() / 2;
  const auto found = std::find(keys.begin(), keys.end(), wanted);
  if (found != keys.end()) return static_cast<std::size_t>(found - keys.begin());
  if (wanted.find_first_not_of("0123456789") == std::string::npos) {
    const std::uint64_t index = wanted.size() > 18 ? UINT64_MAX : std::stoull(wanted);
    if (index < keys.size()) return index;
    throw InputError(
        {where.string()},
        fmt::format("has the samples 0 to {}, not {}: --sample takes such an index or a key", keys.size() - 1, wanted));
  }
  throw InputError({where.string()}, fmt::format("has no sample '{}'; the nearest of {} keys: {}", wanted, keys.size(),
                                                 fmt::join(nearest(wanted, keys), ", ")));
}

std::vector<std::string> keysOfShard(const std::filesystem::path& shard) {
  std::vector<std::string> keys;
  readTar(shard, [&](const std::string& name, std::string_view) {
    const MemberName parts = partsOf(name);
    if (formatBySuffix(parts.format) != nullptr && (keys.empty() || keys.back() != parts.key)) {
      keys.push_back(parts.key);
    }
  });
  return keys;
}

struct Candidate {
  std::string name;
  std::string bytes;
};

// Every format of the wanted sensor's scan.
std::vector<Candidate> candidates(const std::filesystem::path& shard, const std::string& key,
                                  const std::string& wantedSensor, std::string& sensor) {
  std::vector<Candidate> found;
  std::vector<std::string> sensors;
  sensor = lowerCase(wantedSensor);
  readTar(shard, [&](const std::string& name, std::string_view bytes) {
    const MemberName parts = partsOf(name);
    if (parts.key != key || formatBySuffix(parts.format) == nullptr) return;
    const std::string own = lowerCase(parts.sensor);
    if (sensors.empty() && wantedSensor.empty()) sensor = own;
    if (std::find(sensors.begin(), sensors.end(), own) == sensors.end()) sensors.push_back(own);
    if (own == sensor) found.push_back({name, std::string(bytes)});
  });
  if (!found.empty()) return found;
  if (sensors.empty()) {
    throw InputError({shard.string()}, fmt::format("holds no scan of the sample '{}' in a known format", key));
  }
  throw InputError({shard.string()}, fmt::format("the sample '{}' has no sensor '{}'; it has {}", key, wantedSensor,
                                                 fmt::join(sensors, ", ")));
}

ScanSource fromShard(const std::filesystem::path& shard, const std::string& key, const std::string& wantedSensor) {
  std::string sensor;
  const std::vector<Candidate> found = candidates(shard, key, wantedSensor, sensor);
  std::string failures;
  for (const Candidate& c : found) {
    try {
      return {decodeMember(c.name, c.bytes), sensor.empty() ? key : key + ", " + sensor, {}};
    } catch (const InputError& e) {
      failures += fmt::format("{}{}", failures.empty() ? "" : "; ", e.what());
    }
  }
  throw InputError({shard.string()}, failures);
}

ScanSource fromDataset(const std::filesystem::path& folder, const std::string& sample, const std::string& sensor) {
  Manifest manifest = readManifest(folder);
  std::vector<std::string> keys;
  for (const SampleRecord& s : manifest.samples) keys.push_back(s.key);
  const SampleRecord& chosen = manifest.samples[chooseSample(keys, sample, folder)];
  ScanSource source = fromShard(folder / manifest.shards[chosen.shard].file, chosen.key, sensor);
  source.ontology = std::move(manifest.ontology);
  return source;
}

// Of the manifest that lists the shard, in its folder or the one above.
std::optional<Ontology> ontologyOf(const std::filesystem::path& shard) {
  const std::filesystem::path file = std::filesystem::absolute(shard).lexically_normal();
  for (const auto& folder : {file.parent_path(), file.parent_path().parent_path()}) {
    if (!std::filesystem::exists(folder / kManifestName)) continue;
    try {
      Manifest manifest = readManifest(folder);
      const std::string relative = file.lexically_relative(folder).generic_string();
      for (const ShardRecord& s : manifest.shards) {
        if (s.file == relative) return std::move(manifest.ontology);
      }
    } catch (const InputError& e) {
      warn(fmt::format("the classes stay without names: {}", e.what()));
    }
  }
  return {};
}

}  // namespace

ScanSource findScan(const std::filesystem::path& path, const std::string& sample, const std::string& sensor) {
  if (!std::filesystem::exists(path)) throw InputError({path.string()}, "does not exist");
  if (std::filesystem::is_directory(path)) return fromDataset(path, sample, sensor);
  std::string suffix = path.extension().string();
  if (!suffix.empty()) suffix.erase(0, 1);
  if (suffix == "tar") {
    const std::vector<std::string> keys = keysOfShard(path);
    ScanSource source = fromShard(path, keys[chooseSample(keys, sample, path)], sensor);
    source.ontology = ontologyOf(path);
    return source;
  }
  if (formatBySuffix(suffix) == nullptr) {
    std::vector<std::string> known{".tar"};
    for (const FormatEntry& f : formats()) known.push_back(fmt::format(".{}", f.suffix));
    throw InputError({path.string()},
                     fmt::format("is neither a dataset's folder nor one of {}", fmt::join(known, ", ")));
  }
  if (!sample.empty() || !sensor.empty()) {
    throw InputError({path.string()}, "is a single scan: --sample and --sensor choose from a dataset or a shard");
  }
  return {decodeMember(path.string(), readFile(path)), path.filename().string(), {}};
}

}  // namespace scanmill
