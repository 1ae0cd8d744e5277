#include "dataset/scan_source.h"

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
  const std::size_t chosen = findKey(store.keys(), sample, path.string());
  const std::string& key = store.keys()[chosen];
  const StoredScan first = store.scans(chosen, sensor).front();
  ScanSource source;
  source.scan = store.decode(chosen, first);
  source.title = first.sensor.empty() ? key : key + ", " + lowerCase(first.sensor);
  source.beams = store.beams(first.sensor, first.record == nullptr ? 0 : first.record->time);
  if (store.ontology() != nullptr) source.ontology = *store.ontology();
  return source;
}

}  // namespace scanmill
