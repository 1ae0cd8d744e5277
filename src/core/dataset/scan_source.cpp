
#include <algorithm>

#include "base/error.h"
#include "config/text.h"
#include "dataset/sample_names.h"
#include "dataset/scan_store.h"

namespace scanmill {

ScanSource findScan(const std::filesystem::path& path, const std::string& sample, const std::string& sensor) {
  const ScanStore store(path);
  if (store.single()) {
    if (!sample.empty() || !sensor.empty()) {
      throw InputError({path.string()},
                       "is a single scan, so that --sample and --sensor have no effect: leave them out");
    }
    return {store.decode(0, {}), store.keys().front(), nullptr, {}};
  }
  std::size_t chosen = findKey(store.keys(), sample, path.string());
  const bool first = sensor.empty() && store.manifest() != nullptr;
  const std::string wanted = first ? store.manifest()->sensors.front().name : sensor;
  if (sample.empty()) {  // the first sample may have no scan of a sensor that turns slowly
    const auto isOfSensor = [&](const StoredScan& s) { return lowerCase(s.sensor) == lowerCase(wanted); };
    for (std::size_t i = chosen; i < store.keys().size() && !wanted.empty(); ++i) {
      if (std::ranges::none_of(store.scans(i), isOfSensor)) continue;
      chosen = i;
      break;
    }
  }
  const std::string& key = store.keys()[chosen];
  const StoredScan stored = store.scans(chosen, wanted).front();
  ScanSource source;
  source.scan = store.decode(chosen, stored);
  source.title = stored.sensor.empty() ? key : key + ", " + lowerCase(stored.sensor);
  source.beams = store.beams(stored.sensor, stored.record == nullptr ? 0 : stored.record->time);
  if (store.ontology() != nullptr) source.ontology = *store.ontology();
  return source;
}

}  // namespace scanmill
