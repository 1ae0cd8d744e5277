#include "report/dataset/dataset_report.h"

#include <fmt/core.h>

#include <algorithm>
#include <utility>

#include "base/error.h"
#include "dataset/reader.h"
#include "dataset/verify.h"
#include "formats/reasons_png.h"
#include "pipeline/run/progress.h"
#include "report/dataset/scan_view.h"
#include "study/figure_text.h"
#include "viewer/picture.h"

namespace scanmill {

namespace {

constexpr int kPictureWidth = 1280, kPictureHeight = 720;

std::string titleOf(const Manifest& manifest, const ScanIndex& index) {
  const SampleRecord& sample = manifest.samples[index.sample];
  return fmt::format("{}, {}", sample.key, sample.scans[index.scan].sensor);
}

// Draws pictures of a scan, coloured by class and by intensity. If the scan has neither, it is coloured by range.
PicturedScan pictureOf(const Manifest& manifest, const ScanIndex& index, const Scan& scan) {
  PicturedScan pictured{titleOf(manifest, index), manifest.samples[index.sample].split, {}};
  std::vector<ColorBy> colors;
  if (!scan[kLabel].empty()) colors.push_back(kByClass);
  if (!scan[kIntensity].empty()) colors.push_back(kByIntensity);
  if (colors.empty()) colors.push_back(kByRange);
  for (const ColorBy& color : colors) {
    const Coloring coloring = colorScan(scan, color, {&manifest.ontology});
    try {
      pictured.pictures.emplace_back(
          color.name(), encodePng(drawScan(scan, coloring, kPictureWidth, kPictureHeight, pictured.title)));
    } catch (const Error& e) {
      // Pictures need OpenGL, which may be missing; the other contents of the page do not need OpenGL.
      warn(std::string("the page has no pictures: ") + e.what());
    }
  }
  return pictured;
}

// Collects the contents of a report. Later steps use results of earlier steps; run() calls all steps in order.
class Examination {
 public:
  Examination(const std::filesystem::path& folder, const DatasetReportOptions& options)
      : folder_(folder), options_(options), store_(folder) {
    if (store_.manifest() == nullptr) throw InputError({folder.string()}, "is not the folder of a dataset");
    report_.manifest = *store_.manifest();
    report_.folder = lastName(folder);
    report_.path = folder.string();
    report_.seed = options.seed;
  }

  DatasetReport run() {
    const Manifest& manifest = report_.manifest;
    const std::vector<ScanIndex> countedScans = spreadScans(manifest, options_.mostScans);
    std::uint64_t allScans = 0;
    for (const SampleRecord& sample : manifest.samples) allScans += sample.scans.size();
    // If all scans are read, computing hashes takes little additional time.
    report_.hashed = countedScans.size() == allScans;
    report_.shardFaults = shardFaults(folder_, manifest, report_.hashed);
    std::vector<bool> sound;
    for (const std::string& fault : report_.shardFaults) sound.push_back(fault.empty());
    countScans(countedScans);
    countObjects(countedScans);
    findWarnings(countedScans);
    picture(randomScans(manifest, sound, options_.samples, options_.seed));
    return std::move(report_);
  }

 private:
  const ScanRecord& recordOf(const ScanIndex& index) const {
    return report_.manifest.samples[index.sample].scans[index.scan];
  }

  // Reads scans, compares them with the manifest and sets the summary.
  void countScans(const std::vector<ScanIndex>& countedScans) {
    double farthest = 1;
    for (const SensorRecord& s : report_.manifest.sensors) farthest = std::max(farthest, s.beams.maxRange);
    const RangeSteps steps = rangeStepsFor(farthest);
    double error = 0;  // largest position error of all formats (m): it is not known from which a scan is read
    for (const FormatRecord& f : report_.manifest.formats) error = std::max(error, f.maxErrorMetres);
    std::vector<std::optional<ScanCounts>> counts(countedScans.size());
    std::vector<std::vector<std::string>> mistakes(countedScans.size());
    Progress progress("scans read", countedScans.size(), "scans", "points", options_.quiet);
    ScanReading reading;
    reading.stop = options_.stop;
    reading.advance = [&](std::uint64_t points) { progress.advance(1, static_cast<double>(points)); };
    reading.take = [&](std::size_t k, Scan&& scan) {
      mistakes[k] = checkScan(scan, recordOf(countedScans[k]), report_.manifest, error);
      counts[k] = countScan(scan, steps);
    };
    faults_.scans = readScans(store_, countedScans, reading);
    for (std::size_t k = 0; k < countedScans.size(); ++k) {
      for (const std::string& mistake : mistakes[k]) {
        faults_.mistaken.push_back(fmt::format("{}: {}", titleOf(report_.manifest, countedScans[k]), mistake));
      }
    }
    report_.summary = summarise(report_.manifest, countedScans, counts, steps);
  }

  // Counts the objects of the samples with the scans `countedScans`, which must be sorted by sample.
  void countObjects(const std::vector<ScanIndex>& countedScans) {
    std::vector<std::size_t> samples;
    samples.reserve(countedScans.size());
    for (const ScanIndex& index : countedScans) samples.push_back(index.sample);
    samples.erase(std::unique(samples.begin(), samples.end()), samples.end());
    report_.objects = scanmill::countObjects(store_, samples, faults_.scans);
  }

  // Sets the warnings. Throws Error if there are scans, but none could be read.
  void findWarnings(const std::vector<ScanIndex>& countedScans) {
    for (std::size_t i = 0; i < report_.shardFaults.size(); ++i) {
      if (report_.shardFaults[i].empty()) continue;
      faults_.shards.push_back(fmt::format("{} {}", report_.manifest.shards[i].file, report_.shardFaults[i]));
    }
    if (!countedScans.empty() && report_.summary.scansRead == 0) {
      const std::vector<std::string>& faults = faults_.shards.empty() ? faults_.scans : faults_.shards;
      throw Error("{}: none of its scans can be read{}", folder_.string(), faults.empty() ? "" : ": " + faults.front());
    }
    report_.warnings = warningsOf(report_.summary, faults_);
  }

  // Draws pictures of the scans, sorted by key. Skips scans that cannot be read, without reporting them.
  void picture(std::vector<ScanIndex> shown) {
    std::ranges::stable_sort(shown, {}, [&](const ScanIndex& i) { return report_.manifest.samples[i.sample].key; });
    std::vector<std::optional<Scan>> scans(shown.size());
    ScanReading reading;
    reading.stop = options_.stop;
    reading.take = [&](std::size_t k, Scan&& scan) { scans[k] = std::move(scan); };
    readScans(store_, shown, reading);
    Progress progress("pictures", shown.size(), "scans", "scans", options_.quiet);
    std::vector<ViewedScan> viewed;
    for (std::size_t k = 0; k < shown.size(); ++k) {
      if (options_.stop != nullptr && *options_.stop) throw Error("stopped: nothing was written");
      progress.advance(1, 1);
      if (!scans[k]) continue;
      report_.pictured.push_back(pictureOf(report_.manifest, shown[k], *scans[k]));
      viewed.push_back({titleOf(report_.manifest, shown[k]), std::move(*scans[k])});
      readReasons(shown[k]);
    }
    report_.view = scanView(viewed, report_.manifest.ontology);
  }

  // Reads the image that shows the reason of each beam of a pictured scan, and adds it to the report.
  void readReasons(const ScanIndex& index) {
    const SampleRecord& sample = report_.manifest.samples[index.sample];
    if (recordOf(index).beamsPerReason.empty()) return;
    try {
      const ShardIndex shard(folder_ / report_.manifest.shards[sample.shard].file);
      const ShardMember* member = shard.find(sample.key + "." + memberSuffix(recordOf(index), kReasonsSuffix));
      if (member == nullptr) return;
      std::string png = shard.read(*member);
      decodeReasons(png, member->name);
      report_.reasonImages.push_back({titleOf(report_.manifest, index), sample.split, {{"reason", std::move(png)}}});
    } catch (const InputError&) {  // the page then does not show this image
    }
  }

  std::filesystem::path folder_;
  DatasetReportOptions options_;
  ScanStore store_;
  DatasetReport report_;
  ReadingFaults faults_;
};

}  // namespace

DatasetReport examineDataset(const std::filesystem::path& folder, const DatasetReportOptions& options) {
  return Examination(folder, options).run();
}

}  // namespace scanmill
