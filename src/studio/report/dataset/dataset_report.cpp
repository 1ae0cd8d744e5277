#include "report/dataset/dataset_report.h"

#include <fmt/core.h>

#include <algorithm>
#include <iterator>
#include <optional>
#include <utility>

#include "base/error.h"
#include "dataset/scan_check.h"
#include "dataset/shard_index.h"
#include "formats/reasons_png.h"
#include "pipeline/run/progress.h"
#include "report/dataset/scan_choice.h"
#include "report/dataset/scan_counts.h"
#include "report/dataset/scan_reading.h"
#include "report/dataset/scan_view.h"
#include "viewer/picture.h"

namespace scanmill {

namespace {

constexpr int kPictureWidth = 1280, kPictureHeight = 720;

double farthestRange(const Manifest& manifest) {
  double farthest = 1;
  for (const SensorRecord& s : manifest.sensors) farthest = std::max(farthest, s.beams.maxRange);
  return farthest;
}

std::string titleOf(const Manifest& manifest, const ScanPlace& place) {
  const SampleRecord& sample = manifest.samples[place.sample];
  return fmt::format("{}, {}", sample.key, sample.scans[place.scan].sensor);
}

// By class and by intensity, as far as the scan has them.
PicturedScan pictureOf(const Manifest& manifest, const ScanPlace& place, const Scan& scan) {
  PicturedScan pictured{titleOf(manifest, place), manifest.samples[place.sample].split, {}};
  std::vector<ColorBy> colors;
  if (!scan[kLabel].empty()) colors.push_back(kByClass);
  if (!scan[kIntensity].empty()) colors.push_back(kByIntensity);
  if (colors.empty()) colors.push_back(kByRange);
  for (const ColorBy& color : colors) {
    PictureOptions options;
    options.width = kPictureWidth;
    options.height = kPictureHeight;
    options.colorBy = color;
    try {
      pictured.pictures.emplace_back(color.name(),
                                     encodePng(drawPicture(scan, &manifest.ontology, options, pictured.title)));
    } catch (const Error& e) {
      warn(std::string("the page has no pictures: ") + e.what());  // such as: no OpenGL; the figures need none
    }
  }
  return pictured;
}

// Of the folder itself, however it was named: "." too.
std::string nameOf(const std::filesystem::path& folder) {
  const std::filesystem::path whole = std::filesystem::absolute(folder).lexically_normal();
  return (whole.has_filename() ? whole : whole.parent_path()).filename().string();
}

// What the reading of one place is for, and what came of it.
struct Read {
  bool counted = false, shown = false;
  std::optional<ScanCounts> counts;
  std::vector<std::string> mistakes;
  std::optional<Scan> scan;  // where it is shown
};

class Examination {
 public:
  Examination(const std::filesystem::path& folder, const DatasetReportOptions& options)
      : folder_(folder), options_(options) {
    report_.manifest = readManifest(folder);
    report_.folder = nameOf(folder);
    report_.path = folder.string();
    report_.seed = options.seed;
  }

  DatasetReport run() {
    const Manifest& manifest = report_.manifest;
    const std::vector<ScanPlace> spread = spreadScans(manifest, options_.mostScans);
    std::uint64_t scans = 0;
    for (const SampleRecord& sample : manifest.samples) scans += sample.scans.size();
    report_.hashed = spread.size() == scans;  // where all is read, this costs little more
    report_.shardFaults = shardFaults(folder_, manifest, report_.hashed);
    std::vector<bool> sound;
    for (const std::string& fault : report_.shardFaults) sound.push_back(fault.empty());
    const std::vector<ScanPlace> shown = randomScans(manifest, sound, options_.samples, options_.seed);
    read(spread, shown);
    countObjects(spread);
    count(spread);
    picture(shown);
    return std::move(report_);
  }

 private:
  void read(const std::vector<ScanPlace>& spread, const std::vector<ScanPlace>& shown) {
    std::vector<ScanPlace> sorted = shown;
    std::sort(sorted.begin(), sorted.end());
    std::set_union(spread.begin(), spread.end(), sorted.begin(), sorted.end(), std::back_inserter(places_));
    reads_.resize(places_.size());
    for (std::size_t k = 0; k < places_.size(); ++k) {
      reads_[k].counted = std::binary_search(spread.begin(), spread.end(), places_[k]);
      reads_[k].shown = std::binary_search(sorted.begin(), sorted.end(), places_[k]);
    }
    steps_ = rangeStepsFor(farthestRange(report_.manifest));
    Progress progress("scans read", places_.size(), "scans", "points", options_.quiet);
    ScanReading reading;
    reading.stop = options_.stop;
    reading.advance = [&](std::uint64_t scans, std::uint64_t points) {
      progress.advance(scans, static_cast<double>(points));
    };
    reading.take = [this](std::size_t k, Scan&& scan) { take(k, std::move(scan)); };
    faults_.scans = readScans(folder_, report_.manifest, places_, reading);
  }

  void take(std::size_t k, Scan&& scan) {
    const Manifest& manifest = report_.manifest;
    const ScanRecord& record = manifest.samples[places_[k].sample].scans[places_[k].scan];
    Read& own = reads_[k];
    own.mistakes = checkScan(scan, record, manifest, largestError());
    if (own.counted) {
      const std::vector<Pose>& poses = record.worldFromSensor;
      own.counts = countScan(scan, steps_, poses.empty() ? Mat3() : levelFromSensor(poses.front().rotation));
    }
    if (own.shown) own.scan = std::move(scan);
  }

  void countObjects(const std::vector<ScanPlace>& spread) {
    std::vector<std::size_t> samples;
    samples.reserve(spread.size());
    for (const ScanPlace& place : spread) samples.push_back(place.sample);
    samples.erase(std::unique(samples.begin(), samples.end()), samples.end());
    report_.objects = scanmill::countObjects(folder_, report_.manifest, samples, faults_.scans);
  }

  // Of any format: nobody says which one a scan was read from.
  double largestError() const {
    double error = 0;
    for (const FormatRecord& f : report_.manifest.formats) error = std::max(error, f.maxErrorMetres);
    return error;
  }

  void count(const std::vector<ScanPlace>& spread) {
    std::vector<std::optional<ScanCounts>> counts;
    for (std::size_t k = 0; k < places_.size(); ++k) {
      for (const std::string& mistake : reads_[k].mistakes) {
        faults_.mistaken.push_back(fmt::format("{}: {}", titleOf(report_.manifest, places_[k]), mistake));
      }
      if (reads_[k].counted) counts.push_back(std::move(reads_[k].counts));
    }
    for (std::size_t i = 0; i < report_.shardFaults.size(); ++i) {
      if (report_.shardFaults[i].empty()) continue;
      faults_.shards.push_back(fmt::format("{} {}", report_.manifest.shards[i].file, report_.shardFaults[i]));
    }
    report_.summary = summarise(report_.manifest, spread, counts, steps_);
    if (!spread.empty() && report_.summary.scansRead == 0) {
      const std::vector<std::string>& why = faults_.shards.empty() ? faults_.scans : faults_.shards;
      throw Error(
          fmt::format("{}: none of its scans can be read{}", folder_.string(), why.empty() ? "" : ": " + why.front()));
    }
    report_.warnings = warningsOf(report_.summary, faults_, folder_);
  }

  void picture(const std::vector<ScanPlace>& shown) {
    std::vector<std::size_t> order;  // into reads_
    for (const ScanPlace& place : shown) {
      const auto k =
          static_cast<std::size_t>(std::lower_bound(places_.begin(), places_.end(), place) - places_.begin());
      if (reads_[k].scan) order.push_back(k);
    }
    std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
      const auto keyOf = [&](std::size_t k) { return report_.manifest.samples[places_[k].sample].key; };
      return keyOf(a) < keyOf(b);
    });
    report_.pictured.resize(order.size());
    Progress progress("pictures", order.size(), "scans", "scans", options_.quiet);
    for (std::size_t i = 0; i < order.size(); ++i) {
      if (options_.stop != nullptr && *options_.stop) throw Error("stopped: nothing was written");
      report_.pictured[i] = pictureOf(report_.manifest, places_[order[i]], *reads_[order[i]].scan);
      progress.advance(1, 1);
    }
    std::vector<ViewedScan> viewed;
    viewed.reserve(order.size());
    for (const std::size_t k : order) {
      viewed.push_back({titleOf(report_.manifest, places_[k]), std::move(*reads_[k].scan)});
    }
    readReasons(order);
    report_.view = scanView(viewed, report_.manifest.ontology);
  }

  // The images of reasons of the pictured scans. What cannot be read has been reported with the scan itself.
  void readReasons(const std::vector<std::size_t>& order) {
    const Manifest& manifest = report_.manifest;
    for (const std::size_t k : order) {
      const SampleRecord& sample = manifest.samples[places_[k].sample];
      const ScanRecord& scan = sample.scans[places_[k].scan];
      if (scan.beamsPerReason.empty()) continue;
      try {
        const ShardIndex shard(folder_ / manifest.shards[sample.shard].file, DamagedShard::ReadAsFarAsWhole);
        const ShardMember* member = shard.find(sample.key + "." + memberSuffix(scan, kReasonsSuffix));
        if (member == nullptr) continue;
        std::string png = shard.read(*member);
        decodeReasons(png, member->name);
        report_.reasonImages.push_back({titleOf(manifest, places_[k]), sample.split, {{"reason", std::move(png)}}});
      } catch (const InputError& error) {
        faults_.scans.emplace_back(error.what());
      }
    }
  }

  std::filesystem::path folder_;
  DatasetReportOptions options_;
  DatasetReport report_;
  RangeSteps steps_;
  std::vector<ScanPlace> places_;  // all that are read, ascending
  std::vector<Read> reads_;
  ReadingFaults faults_;
};

}  // namespace

DatasetReport examineDataset(const std::filesystem::path& folder, const DatasetReportOptions& options) {
  return Examination(folder, options).run();
}

}  // namespace scanmill
