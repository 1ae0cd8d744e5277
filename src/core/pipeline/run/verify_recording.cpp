#include "pipeline/run/verify_recording.h"

#include <fmt/core.h>

#include <algorithm>
#include <iterator>
#include <limits>
#include <map>
#include <mutex>
#include <set>
#include <string_view>
#include <utility>
#include <vector>

#include "base/error.h"
#include "base/parallel.h"
#include "dataset/recording.h"
#include "passes/exr/exr_file.h"
#include "passes/exr/hits_exr.h"
#include "passes/exr/pass_exr.h"
#include "pipeline/read/pipeline.h"

namespace scanmill {

namespace fs = std::filesystem;

namespace {

constexpr std::uint32_t kFramesAtOnce = 4096;

std::vector<std::uint16_t> distinct(const std::vector<std::uint16_t>& ids) {
  std::vector<char> met(std::numeric_limits<std::uint16_t>::max() + std::size_t{1});
  for (const std::uint16_t id : ids) met[id] = 1;
  std::vector<std::uint16_t> list;
  for (std::size_t id = 0; id < met.size(); ++id) {
    if (met[id] != 0) list.push_back(static_cast<std::uint16_t>(id));
  }
  return list;
}

// Returns up to eight of the values as a text such as "3, 7, 9".
template <class Values>
std::string listOf(const Values& values) {
  constexpr std::size_t kMost = 8;
  std::string text;
  std::size_t count = 0;
  for (const auto& value : values) {
    if (count == kMost) return text + " ...";
    text += fmt::format("{}{}", count++ == 0 ? "" : ", ", value);
  }
  return text;
}

// An image file, with facts from the recorded scans that refer to it.
struct Image {
  std::string namedBy;  // file of the first scan that refers to the image
  std::set<std::uint32_t> tables;
  std::set<std::size_t> sensors;
};

class RecordingCheck {
 public:
  explicit RecordingCheck(const Recording& recording)
      : recording_(recording), prefix_((recording.folder / "").string()) {
    for (const fs::directory_entry& entry : fs::directory_iterator(recording.folder)) {
      if (!entry.is_directory()) files_.insert(entry.path().filename().string());
    }
  }

  RecordingVerification run(const std::function<void(std::uint64_t, std::uint64_t)>& progress) {
    named_.insert("recording.json");
    for (const RecordedSequence& sequence : recording_.sequences) {
      for (std::size_t s = 0; s < recording_.sensors.size(); ++s) checkScans(sequence, s);
    }
    checkImages(progress);
    std::vector<std::string> strangers;
    std::set_difference(files_.begin(), files_.end(), named_.begin(), named_.end(), std::back_inserter(strangers));
    if (!strangers.empty()) {
      result_.warnings.push_back(fmt::format("{}: files that do not belong to the recording, {} in all: {}",
                                             recording_.folder.string(), strangers.size(), listOf(strangers)));
    }
    return std::move(result_);
  }

 private:
  // The result of checkScan() for the file of a recorded scan.
  struct Scan {
    std::string file;
    bool missing = false;
    std::vector<std::string> problems;
    std::vector<std::string> images;
  };

  // Returns a message without the recording's folder at its start, so that it names files in the same way as
  // recording.json.
  std::string relative(std::string_view message) const {
    if (message.starts_with(prefix_)) message.remove_prefix(prefix_.size());
    return std::string(message);
  }

  // Checks the scans of one sensor for all frames of a sequence. Consecutive missing frames are reported as one
  // problem.
  void checkScans(const RecordedSequence& recorded, std::size_t sensor) {
    Sequence sequence;
    sequence.scene = recorded.scene;
    sequence.sceneSeed = recorded.seed;
    sequence.trajectoryName = recorded.trajectory;
    std::string firstMissing;
    std::uint32_t missing = 0;
    const auto reportMissing = [&] {
      if (missing == 0) return;
      result_.problems.push_back(fmt::format("{}: is missing{}", firstMissing,
                                             missing == 1 ? "" : fmt::format(", and {} frames after it", missing - 1)));
      missing = 0;
    };
    std::vector<Scan> scans;
    for (std::uint32_t first = 0; first < recorded.frames; first += kFramesAtOnce) {
      scans.assign(std::min(kFramesAtOnce, recorded.frames - first), {});
      parallelFor(scans.size(), 16, [&](std::size_t from, std::size_t to) {
        for (std::size_t i = from; i < to; ++i) {
          checkScan(sequence.key(first + static_cast<std::uint32_t>(i)), recording_.sensors[sensor], scans[i]);
        }
      });
      for (Scan& scan : scans) {
        if (scan.missing) {
          if (missing++ == 0) firstMissing = scan.file;
          continue;
        }
        reportMissing();
        result_.problems.insert(result_.problems.end(), scan.problems.begin(), scan.problems.end());
        for (const std::string& file : scan.images) {
          Image& image = images_.try_emplace(file, Image{scan.file, {}, {}}).first->second;
          image.tables.insert(recorded.materials);
          image.sensors.insert(sensor);
        }
        named_.insert(std::move(scan.file));
      }
    }
    reportMissing();
    result_.scans += recorded.frames;
  }

  void checkScan(const std::string& sample, const RecordedSensor& sensor, Scan& scan) const {
    scan.file = fmt::format("{}.{}.json", sample, sensor.name);
    scan.missing = !files_.contains(scan.file);
    if (scan.missing) return;
    try {
      RecordedShot shot = recording_.shot(sample, sensor.name);
      if (shot.worldFromSensor.size() > sensor.columns) {
        scan.problems.push_back(fmt::format("{}: /world_from_sensor: has {} poses, more than the {} columns of '{}'",
                                            scan.file, shot.worldFromSensor.size(), sensor.columns, sensor.name));
      }
      if (!shot.hits.empty()) scan.images.push_back(std::move(shot.hits));
      for (RecordedStep& step : shot.steps) {
        std::move(step.images.begin(), step.images.end(), std::back_inserter(scan.images));
      }
    } catch (const std::exception& error) {
      scan.problems.push_back(relative(reasonOf(error)));
    }
  }

  void checkImages(const std::function<void(std::uint64_t, std::uint64_t)>& progress) {
    std::vector<const std::pair<const std::string, Image>*> list;
    for (const auto& entry : images_) {
      list.push_back(&entry);
      named_.insert(entry.first);
    }
    std::vector<std::vector<std::string>> problems(list.size());
    std::mutex mutex;
    std::uint64_t done = 0;
    parallelFor(list.size(), 1, [&](std::size_t first, std::size_t last) {
      for (std::size_t i = first; i < last; ++i) {
        const std::uint64_t pixels = checkImage(list[i]->first, list[i]->second, problems[i]);
        const std::scoped_lock lock(mutex);
        result_.pixels += pixels;
        if (progress) progress(++done, list.size());
      }
    });
    for (const std::vector<std::string>& lines : problems) {
      result_.problems.insert(result_.problems.end(), lines.begin(), lines.end());
    }
    result_.images = list.size();
  }

  // Checks an image and appends its problems. Returns its number of pixels; 0 if the image cannot be read.
  std::uint64_t checkImage(const std::string& file, const Image& image, std::vector<std::string>& problems) const {
    if (!files_.contains(file)) {
      problems.push_back(fmt::format("{}: is missing, but {} names it", file, image.namedBy));
      return 0;
    }
    const fs::path path = recording_.folder / file;
    try {
      if (recording_.kind == RecordingKind::Hits) {
        Hits hits;
        readHits(path, channelsIn(path), hits);
        for (const std::size_t s : image.sensors) {
          const RecordedSensor& sensor = recording_.sensors[s];
          if (hits.rings == sensor.rings && hits.columns == sensor.columns) continue;
          problems.push_back(fmt::format("{}: holds {} x {} beams, but '{}' has {} x {}", file, hits.rings,
                                         hits.columns, sensor.name, sensor.rings, sensor.columns));
        }
        checkIds(file, image, hits.semantic, hits.material, !hits.roughness.empty(), problems);
        return hits.size();
      }
      const PassChoice there = passesIn(path);
      const PassPlanes planes = readPasses(path, there).planes;
      checkIds(file, image, planes.semantic, planes.material, there.surfaceParameters, problems);
      return planes.size();
    } catch (const std::exception& error) {
      problems.push_back(relative(reasonOf(error)));
      return 0;
    }
  }

  void checkIds(const std::string& file, const Image& image, const std::vector<std::uint16_t>& semantic,
                const std::vector<std::uint16_t>& material, bool surfaceParameters,
                std::vector<std::string>& problems) const {
    std::vector<std::uint16_t> unknown;
    if (!recording_.ontology.classes.empty()) {
      for (const std::uint16_t id : distinct(semantic)) {
        if (id != 0 && recording_.ontology.find(id) == nullptr) unknown.push_back(id);
      }
    }
    if (!unknown.empty()) {
      problems.push_back(fmt::format("{}: channel 'semantic': the ontology '{}' of the recording has no class {}", file,
                                     recording_.ontology.name, listOf(unknown)));
    }
    if (surfaceParameters || material.empty()) return;
    const std::uint16_t last = *std::max_element(material.begin(), material.end());
    for (const std::uint32_t table : image.tables) {
      const std::size_t known = recording_.materials[table].size();
      if (known == 0 || last < known) continue;
      problems.push_back(
          fmt::format("{}: channel 'material': has the index {}, but /materials/{} of the recording has {} entries",
                      file, last, table, known));
    }
  }

  const Recording& recording_;
  std::string prefix_;
  std::set<std::string> files_;  // names of all files in the recording's folder
  std::set<std::string> named_;
  std::map<std::string, Image> images_;  // keys: file names
  RecordingVerification result_;
};

}  // namespace

RecordingVerification verifyRecording(const fs::path& folder,
                                      const std::function<void(std::uint64_t, std::uint64_t)>& progress) {
  const Recording recording = readRecording(folder, recordingIn(folder).value_or(RecordingKind::Hits));
  try {
    return RecordingCheck(recording).run(progress);
  } catch (const fs::filesystem_error& error) {
    throw InputError({folder.string()}, "cannot be listed: " + error.code().message());
  }
}

}  // namespace scanmill
