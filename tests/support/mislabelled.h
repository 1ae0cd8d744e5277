#pragma once

// A dataset with a mistake in it, as whoever labels scans makes one.

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "dataset/reader.h"
#include "formats/format.h"
#include "tests/support/packed_dataset.h"

namespace scanmill {

// Copies the dataset; in one sample the points of one instance get another class. All else follows, counts and
// hashes: `verify` finds nothing wrong. Formats are written with their defaults. Returns how many points
// changed.
inline std::uint64_t copyMislabelled(const std::filesystem::path& from, const std::filesystem::path& to,
                                     const std::string& key, std::uint32_t instance, std::uint16_t wrong) {
  Manifest manifest = readManifest(from);
  std::uint64_t changed = 0;
  PackedDataset writer(to, false, std::uint64_t{1} << 30);
  for (const SampleRecord& record : manifest.samples) {
    Sample sample{record.key, record.split, record.scans, {}};
    std::map<std::string, std::string> members;
    readTar(from / manifest.shards[record.shard].file, [&](const std::string& name, std::string_view bytes) {
      if (name.starts_with(record.key + ".")) members[name.substr(record.key.size() + 1)] = bytes;
    });
    if (record.key == key) {
      for (ScanRecord& scan : sample.scans) {
        for (const FormatEntry& format : formats()) {
          const auto member = members.find(memberSuffix(scan, format.suffix));
          if (member == members.end()) continue;
          Scan decoded = decodeMember(member->first, member->second);
          changed = 0;
          scan.pointsPerClass.clear();
          for (std::size_t i = 0; i < decoded.size(); ++i) {
            if (decoded[kInstance][i] == instance && isFinite(decoded.position[i])) {
              decoded[kLabel][i] = wrong;
              ++changed;
            }
            if (isFinite(decoded.position[i])) ++scan.pointsPerClass[decoded[kLabel][i]];
          }
          const Value none = parseYaml("{}", "options");
          Fields options(none, "format");
          member->second = format.make(options)->encode(decoded);
        }
      }
    }
    for (const std::string& name : record.members) {
      const std::string suffix = name.substr(record.key.size() + 1);
      if (suffix != "json") sample.members.push_back({suffix, members[suffix]});  // which the writer makes
    }
    writer.add(sample);
  }
  manifest.shards.clear();
  manifest.samples.clear();
  writer.finish(manifest);
  return changed;
}

}  // namespace scanmill
