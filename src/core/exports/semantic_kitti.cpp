// Writes the folders of SemanticKITTI (Behley et al., "SemanticKITTI: A Dataset for Semantic Scene Understanding of
// LiDAR Sequences", ICCV 2019; file formats on semantic-kitti.org/dataset.html and in
// github.com/PRBonn/semantic-kitti-api), which are the folders of KITTI's odometry benchmark with additional labels:
//
//   semantic-kitti.yaml                    classes, colours (blue, green, red) and splits, for the API's --config
//   sequences/00/velodyne/000000.bin       float32 x, y, z, remission per point, ring after ring from the top
//   sequences/00/labels/000000.label       uint32 per point: class in the lower 16 bits, instance in the upper
//   sequences/00/voxels/000000.label       uint16 per voxel, if the dataset has voxels: class, 0 for an empty voxel; in
//                                          the order of VoxelGrid::index()
//   sequences/00/voxels/000000.bin         a bit per voxel: it contains a point of the scan
//   sequences/00/voxels/000000.invalid     a bit per voxel: it must be ignored, see ScanVoxels
//   sequences/00/voxels/000000.occluded    a bit per voxel: another voxel hides it, see occludedVoxels()
//   sequences/00/poses.txt                 12 numbers per line: pose of camera 0 relative to its first pose
//   sequences/00/calib.txt, times.txt
//   semantickitti_infos_train.json, ...    the frames of each split, for mmdetection3d's `ann_file`
//
// If SemanticKITTI has a sequence that the dataset lacks, its folder is created empty, since Pointcept lists it.
//
// There is no real camera: camera 0 is placed at the sensor's origin and looks along the sensor's x axis. numbersOf()
// numbers the sequences. If the dataset lists objects, moving objects have the classes 252 to 259.

#include <fmt/ranges.h>

#include <algorithm>
#include <map>
#include <set>

#include "dataset/json_text.h"
#include "exports/instance_numbers.h"
#include "exports/layout.h"
#include "formats/little_endian.h"

namespace scanmill {

namespace {

constexpr std::uint32_t kMostInstanceId = 32767;  // largest instance id; a larger id would set the sign bit of an int32
constexpr std::size_t kMostSequences = 100;       // largest number of sequences, because their numbers have two digits

// Rotation from the sensor's axes to the camera's: x right, y down, z forward.
const Quat kCameraFromSensor{0.5, 0.5, -0.5, 0.5};

// Returns the first three rows of the 4 x 4 matrix of a pose as text.
std::string matrixText(const Pose& pose) {
  const std::array<double, 16> rows = matrixRows(toAffine(pose));
  return fmt::format("{:.9e}", fmt::join(rows.begin(), rows.begin() + 12, " "));
}

// Returns the numbers of SemanticKITTI's sequences in a split, which are built into training programs; none for other
// splits.
std::vector<std::size_t> usualNumbers(const std::string& split) {
  if (split == "train") return {0, 1, 2, 3, 4, 5, 6, 7, 9, 10};
  if (split == "val") return {8};
  if (split == "test") return {11, 12, 13, 14, 15, 16, 17, 18, 19, 20, 21};
  return {};
}

// Returns the number of each sequence: the first free number of usualNumbers() for the sequence's split. If all of
// these are taken, the first free number from 22 on, which SemanticKITTI does not use, and then the first free number
// of all. check() has refused plans with more sequences than numbers.
std::vector<std::size_t> numbersOf(const ExportPlan& plan) {
  constexpr std::size_t kFirstUnusual = 22;
  std::set<std::size_t> taken;
  std::vector<std::size_t> numbers;
  for (const ExportSequence& sequence : plan.sequences) {
    std::vector<std::size_t> candidates = usualNumbers(sequence.split);
    for (std::size_t n = kFirstUnusual; n < kMostSequences; ++n) candidates.push_back(n);
    for (std::size_t n = 0; n < kFirstUnusual; ++n) candidates.push_back(n);
    numbers.push_back(*std::ranges::find_if(candidates, [&](std::size_t n) { return !taken.contains(n); }));
    taken.insert(numbers.back());
  }
  return numbers;
}

std::filesystem::path sequenceFolder(std::size_t number) {
  return std::filesystem::path("sequences") / fmt::format("{:02}", number);
}

// Returns a point's instance; all instances are in one group.
InstanceNumbers::Instance numberedInstance(const ExportPlan&, const Scan& scan, std::size_t point) {
  return {.group = 0, .id = scan[kInstance].empty() ? 0 : scan[kInstance][point]};
}

// Returns flags as bits, eight per byte, the first in the highest bit.
std::string packed(const std::vector<std::uint8_t>& flags) {
  std::string bytes((flags.size() + 7) / 8, '\0');
  for (std::size_t i = 0; i < flags.size(); ++i) {
    if (flags[i] != 0) bytes[i / 8] = static_cast<char>(static_cast<unsigned char>(bytes[i / 8]) | 0x80u >> i % 8);
  }
  return bytes;
}

class SemanticKitti : public ExportLayout {
 public:
  void check(const ExportPlan& plan) const override {
    if (plan.sequences.size() > kMostSequences) {
      refuse(plan, "has {} sequences, but SemanticKITTI's numbers of two digits allow {}: take fewer with --split",
             plan.sequences.size(), kMostSequences);
    }
  }

  bool checksSamples(const ExportPlan& plan) const override { return plan.manifest.hasColumn("instance"); }

  void checkSample(const ExportPlan& plan, const ExportSample& sample) const override { numbers_.add(plan, sample); }

  void write(const ExportPlan& plan, std::size_t sequence, std::size_t frame, const ReadSample& read,
             const ExportFolder& folder) const override {
    const ExportSample sample = read(sequence, frame);
    const std::vector<std::size_t> order = velodyneOrder(sample.scans.front());
    const std::string name = fmt::format("{:06}", frame);
    const std::filesystem::path path = sequenceFolder(numbersOf(plan)[sequence]);
    folder.write(path / "velodyne" / (name + ".bin"), velodynePoints(sample.scans.front(), order));
    if (plan.manifest.hasColumn("label"))
      folder.write(path / "labels" / (name + ".label"), labels(plan, sample, order));
    if (!sample.voxels) return;
    const ScanVoxels& voxels = *sample.voxels;
    std::string voxelLabels;
    for (const std::uint16_t label : voxels.label) {
      putNumber(label == 0 ? label : plan.classes.targetId(label), voxelLabels);
    }
    folder.write(path / "voxels" / (name + ".bin"), packed(voxels.input));
    folder.write(path / "voxels" / (name + ".label"), voxelLabels);
    folder.write(path / "voxels" / (name + ".invalid"), packed(voxels.invalid));
    folder.write(path / "voxels" / (name + ".occluded"), packed(occludedVoxels(voxels)));
  }

  std::vector<std::string> finish(const ExportPlan& plan, const ReadObjects&,
                                  const ExportFolder& folder) const override {
    writePoses(plan, folder);
    folder.write("semantic-kitti.yaml", configuration(plan));
    writeInfos(plan, folder);
    std::vector<std::string> warnings = skewWarnings(plan, "SemanticKITTI");
    const std::vector<std::size_t> numbers = numbersOf(plan);
    std::size_t unusual = 0, renumbered = 0;  // numbers of sequences
    for (std::size_t s = 0; s < plan.sequences.size(); ++s) {
      const std::vector<std::size_t> usual = usualNumbers(plan.sequences[s].split);
      unusual += std::ranges::find(usual, numbers[s]) == usual.end() ? 1 : 0;
      renumbered += newNumbers(s).empty() ? 0 : 1;
    }
    if (unusual > 0) {
      warnings.push_back(fmt::format(
          "{} of {} sequences have numbers that are in none of SemanticKITTI's splits, since it has 10 "
          "sequences for training and 1 for validation: programs with lists of their own, such as Pointcept, do "
          "not read them; semantic-kitti.yaml and semantickitti_infos_*.json list all",
          unusual, plan.sequences.size()));
    }
    if (renumbered > 0) {
      warnings.push_back(
          fmt::format("instances have new numbers from 1 in {} of {} sequences, since SemanticKITTI's labels store ids "
                      "up to {}; they do not join the dataset's",
                      renumbered, plan.sequences.size(), kMostInstanceId));
    }
    if (!plan.manifest.hasColumn("label") || listsObjects(plan)) return warnings;
    warnings.emplace_back(
        "the dataset lists no objects, so that moving objects get the classes of static ones: generate it with "
        "`output: {objects: true}` for the moving classes");
    return warnings;
  }

 private:
  // Returns the contents of a file of labels. `order`: indices of the points, in the order of the file.
  std::string labels(const ExportPlan& plan, const ExportSample& sample, const std::vector<std::size_t>& order) const {
    const Scan& scan = sample.scans.front().scan;
    if (scan[kLabel].empty()) return {};  // an empty scan may have no columns
    std::set<std::uint32_t> movingInstances;
    if (sample.objects) {
      for (const ObjectRecord& object : sample.objects->objects) {
        if (object.moves) movingInstances.insert(object.id);
      }
    }
    const InstanceNumbers::Numbers numbers = newNumbers(sample.sequence);
    std::string bytes;
    for (const std::size_t i : order) {
      const std::uint32_t instance = numberedInstance(plan, scan, i).id;
      const std::uint16_t semantic = scan[kLabel][i];
      const std::uint32_t label =
          movingInstances.contains(instance) ? plan.classes.movingTargetId(semantic) : plan.classes.targetId(semantic);
      const std::uint32_t number =
          numbers.empty() || instance == 0 ? instance : numbers.at({.group = 0, .id = instance});
      putNumber(label | number << 16, bytes);
    }
    return bytes;
  }

  // Writes poses.txt, times.txt and calib.txt of each sequence.
  static void writePoses(const ExportPlan& plan, const ExportFolder& folder) {
    const Pose cameraFromSensor{kCameraFromSensor, {}};
    std::string calibration;
    for (int camera = 0; camera < 4; ++camera) {
      calibration += fmt::format("P{}: 1 0 0 0 0 1 0 0 0 0 1 0\n", camera);
    }
    calibration += fmt::format("Tr: {}\n", matrixText(cameraFromSensor));
    const std::vector<std::size_t> numbers = numbersOf(plan);
    for (std::size_t s = 0; s < plan.sequences.size(); ++s) {
      const std::vector<std::size_t>& samples = plan.sequences[s].samples;
      const ScanRecord& first = scanOf(plan, plan.manifest.samples[samples.front()]);
      std::string poses, times;
      for (const std::size_t sample : samples) {
        const ScanRecord& scan = scanOf(plan, plan.manifest.samples[sample]);
        const Pose firstFromSensor = inverse(first.worldFromSensor.front()) * scan.worldFromSensor.front();
        poses += matrixText(cameraFromSensor * firstFromSensor * inverse(cameraFromSensor)) + "\n";
        times += fmt::format("{:.6e}\n", scan.time - first.time);
      }
      folder.write(sequenceFolder(numbers[s]) / "poses.txt", poses);
      folder.write(sequenceFolder(numbers[s]) / "times.txt", times);
      folder.write(sequenceFolder(numbers[s]) / "calib.txt", calibration);
    }
  }

  // Writes mmdetection3d's list of frames of each split, and creates the folders of all sequences that SemanticKITTI
  // has in these splits; they are empty if the dataset has no such sequence.
  static void writeInfos(const ExportPlan& plan, const ExportFolder& folder) {
    const std::vector<std::size_t> numbers = numbersOf(plan);
    std::map<std::string, OrderedJson> frames;
    for (std::size_t s = 0; s < plan.sequences.size(); ++s) {
      const std::string path = sequenceFolder(numbers[s]).generic_string();
      OrderedJson& list = frames.try_emplace(plan.sequences[s].split, OrderedJson::array()).first->second;
      for (std::size_t f = 0; f < plan.sequences[s].samples.size(); ++f) {
        list.push_back(
            {{"lidar_points", {{"lidar_path", fmt::format("{}/velodyne/{:06}.bin", path, f)}, {"num_pts_feats", 4}}},
             {"pts_semantic_mask_path", fmt::format("{}/labels/{:06}.label", path, f)},
             {"sample_idx", fmt::format("{:02}{:06}", numbers[s], f)}});
      }
    }
    for (auto& [split, list] : frames) {
      const OrderedJson infos{{"metainfo", {{"dataset", "semantickitti"}}}, {"data_list", std::move(list)}};
      folder.write(fmt::format("semantickitti_infos_{}.json", split), layOut(infos) + "\n");
      for (const std::size_t number : usualNumbers(split)) {
        for (const char* kind : {"velodyne", "labels"}) folder.prepareFile(sequenceFolder(number) / kind / "");
      }
    }
  }

  // Returns the new numbers of a sequence's instances; empty if the dataset's instance ids fit into labels unchanged.
  InstanceNumbers::Numbers newNumbers(std::size_t sequence) const {
    InstanceNumbers::Numbers numbers = numbers_.numbersOf(sequence);
    if (numbers.empty() || numbers.rbegin()->first.id <= kMostInstanceId) return {};  // the last has the largest id
    return numbers;
  }

  // Returns a configuration in the form of the API's config/semantic-kitti.yaml. The trained classes are the classes
  // that points can have, in the order of their ids; a class of moving objects is trained as the class of the same
  // objects standing still. The split `val` is called `valid` in this configuration.
  static std::string configuration(const ExportPlan& plan) {
    std::string text = "# Of a simulated dataset, in the form of SemanticKITTI's configuration.\nname: \"" +
                       plan.classes.target().name + "\"\nlabels:\n";
    std::string colors, trainedOfClass, classOfTrained, ignored;  // lines of maps of the configuration
    std::map<std::uint16_t, int> trainedNumbers;                  // by class id
    std::set<std::uint16_t> usedIds{0};
    for (const SemanticClass& c : plan.manifest.ontology.classes) usedIds.insert(plan.classes.targetId(c.id));
    for (const SemanticClass& c : plan.classes.target().classes) {
      text += fmt::format("  {}: \"{}\"\n", c.id, c.name);
      colors += fmt::format("  {}: [{}, {}, {}]\n", c.id, c.color[2], c.color[1], c.color[0]);
      if (usedIds.contains(c.id) && !c.movingOf) {
        const int number = static_cast<int>(trainedNumbers.size());
        trainedNumbers.emplace(c.id, number);
        classOfTrained += fmt::format("  {}: {}\n", number, c.id);
        ignored += fmt::format("  {}: {}\n", number, number == 0 ? "True" : "False");
      }
      const auto trained = trainedNumbers.find(c.movingOf.value_or(c.id));
      trainedOfClass += fmt::format("  {}: {}\n", c.id, trained == trainedNumbers.end() ? 0 : trained->second);
    }
    std::map<std::string, std::string> splits{{"train", ""}, {"valid", ""}, {"test", ""}};
    const std::vector<std::size_t> numbers = numbersOf(plan);
    for (std::size_t s = 0; s < plan.sequences.size(); ++s) {
      const std::string& split = plan.sequences[s].split;
      splits[split == "val" ? "valid" : split] += fmt::format("\n    - {}", numbers[s]);
    }
    text += "color_map:  # blue, green, red\n" + colors + "learning_map:\n" + trainedOfClass + "learning_map_inv:\n" +
            classOfTrained + "learning_ignore:\n" + ignored + "split:\n";
    for (const auto& [split, sequences] : splits) {
      text += fmt::format("  {}:{}\n", split, sequences.empty() ? " []" : sequences);
    }
    return text;
  }

  mutable InstanceNumbers numbers_{"SemanticKITTI", kMostInstanceId, numberedInstance,
                                   [](const ExportPlan&, std::uint16_t) { return std::string("instances"); }};
};

}  // namespace

std::unique_ptr<ExportLayout> makeSemanticKitti() {
  return std::make_unique<SemanticKitti>();
}

}  // namespace scanmill
