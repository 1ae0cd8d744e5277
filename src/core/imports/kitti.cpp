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

bool isRecords(const fs::path& file) {
  return numbersOfRecord(file) == 4;
}

// Adds the scans of one sequence, whose folder contains velodyne/ or velodyne_points/data/.
void addSequence(const fs::path& folder, const std::string& name, ScanFolder& found) {
  for (const fs::path& scans : {folder / "velodyne", folder / "velodyne_points" / "data"}) {
    for (const fs::path& file : filesIn(scans, isRecords)) {
      found.scans.push_back({name.empty() ? file.stem().string() : name + "-" + file.stem().string(), file, {}});
    }
  }
}

}  // namespace

std::optional<ScanFolder> readKittiFolder(const fs::path& folder) {
  ScanFolder found{"kitti", "velodyne", {}, {}};
  const fs::path whole = fs::absolute(folder).lexically_normal();
  const fs::path own = whole.has_filename() ? whole : whole.parent_path();
  addSequence(own, "", found);
  if (found.scans.empty() && own.filename() == "velodyne") addSequence(own.parent_path(), "", found);
  for (const fs::path& above : {own, own / "sequences", own / "dataset" / "sequences"}) {
    if (!found.scans.empty()) break;
    for (const fs::path& sequence : foldersIn(above)) addSequence(sequence, sequence.filename().string(), found);
  }
  if (found.scans.empty()) return {};
  for (const FolderScan& scan : found.scans) {
    found.ontology = ontologyBeside(scan.points);
    if (found.ontology) break;
  }
  return found;
}

std::optional<Ontology> ontologyBeside(const fs::path& scan) {
  if (numbersOfRecord(scan) == 0 || labelsBeside(scan).empty()) return {};
  return readOntology(namedResource("semantic_kitti", "labels"));
}

}  // namespace scanmill
