// Reads the folders of KITTI (Geiger et al., "Vision meets Robotics: The KITTI Dataset", IJRR 2013) and of datasets
// that use its layout:
//
//   sequences/00/velodyne/000000.bin            the odometry benchmark; SemanticKITTI has labels/000000.label beside it
//   training/velodyne/000000.bin                the object benchmark; testing/ has the same folders
//   DRIVE/velodyne_points/data/0000000000.bin   raw drives
//
// The given folder may be the root, a folder of sequences or drives, one sequence or drive, or a folder velodyne.

#include "config/resources.h"
#include "formats/readers.h"
#include "imports/scan_folder.h"

namespace scanmill {

namespace fs = std::filesystem;

namespace {

// Adds the scans of one sequence, whose folder contains velodyne/ or velodyne_points/data/. Their keys begin with the
// sequence's name unless it is empty.
void addSequence(const fs::path& sequence, const std::string& name, std::vector<FolderScan>& scans) {
  for (const fs::path& folder : {sequence / "velodyne", sequence / "velodyne_points" / "data"}) {
    for (const fs::path& file : filesIn(folder, [](const fs::path& f) { return numbersOfRecord(f) == 4; })) {
      scans.push_back({.key = (name.empty() ? "" : name + "-") + file.stem().string(), .points = file});
    }
  }
}

}  // namespace

std::optional<ScanFolder> readKittiFolder(const fs::path& folder) {
  ScanFolder kitti{.layout = "kitti", .sensor = "velodyne"};
  const fs::path absolute = fs::absolute(folder).lexically_normal();
  const fs::path root = absolute.has_filename() ? absolute : absolute.parent_path();  // without a final slash
  // The folder may be a sequence or drive, its folder velodyne, or a folder of sequences or drives.
  addSequence(root, "", kitti.scans);
  if (kitti.scans.empty() && root.filename() == "velodyne") addSequence(root.parent_path(), "", kitti.scans);
  for (const fs::path& sequences : {root, root / "sequences", root / "dataset" / "sequences"}) {
    if (!kitti.scans.empty()) break;
    for (const fs::path& sequence : foldersIn(sequences)) {
      addSequence(sequence, sequence.filename().string(), kitti.scans);
    }
  }
  if (kitti.scans.empty()) return {};
  for (auto scan = kitti.scans.begin(); scan != kitti.scans.end() && !kitti.ontology; ++scan) {
    kitti.ontology = ontologyBeside(scan->points);
  }
  return kitti;
}

std::optional<Ontology> ontologyBeside(const fs::path& scan) {
  if (numbersOfRecord(scan) == 0 || labelsBeside(scan).empty()) return {};
  return readOntology(namedResource("semantic_kitti", "labels"));
}

}  // namespace scanmill
