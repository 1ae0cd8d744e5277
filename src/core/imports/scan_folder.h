#pragma once

// Folders of recorded scans, in the layouts of public datasets. A new layout needs a new file and a row in
// scan_folder.cpp.

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "scan/scan.h"
#include "scene/ontology.h"

namespace scanmill {

struct FolderScan {
  std::string key;                      // sequence and frame, such as "08-000010"
  std::filesystem::path points;         // a file for readCloud() (formats/cloud_file.h)
  std::filesystem::path lidarseg = {};  // file with the labels of nuScenes-lidarseg; empty: none
  std::filesystem::path panoptic = {};  // file with the labels of Panoptic nuScenes; empty: none
};

struct ScanFolder {
  std::string layout;  // name of the layout, such as "kitti"
  std::string sensor;  // sensor's name, such as "velodyne"; empty: the layout does not name the sensor
  std::optional<Ontology> ontology = {};  // classes of the labels; none: unknown, or no labels
  std::vector<FolderScan> scans = {};     // ordered by key
  double heading = 0;                     // azimuth (rad) of the vehicle's heading in the frame of the points
};

// Finds the scans in a folder, with the first layout that fits. The folder may be a dataset's root or a part of the
// dataset, such as one sequence. Returns nothing if the folder has no scans. Throws InputError for damaged files.
std::optional<ScanFolder> scanFolderIn(const std::filesystem::path& folder);

// Reads a scan with its labels, in the coordinate frame of its file. Warns of what the reader leaves out, but only once
// per folder. May be called from any thread. Throws InputError.
Scan readFolderScan(const FolderScan& files);

// Returns the classes of the labels that readCloud() finds beside a scan; nothing if there are no labels.
std::optional<Ontology> ontologyBeside(const std::filesystem::path& scan);

// Each of these functions reads one layout. They return nothing if the folder has another layout, and throw InputError
// if the folder has this layout but is damaged.
std::optional<ScanFolder> readNuScenesFolder(const std::filesystem::path& folder);
std::optional<ScanFolder> readKittiFolder(const std::filesystem::path& folder);
std::optional<ScanFolder> readPlainFolder(const std::filesystem::path& folder);

// Returns the files in a folder that `accepts` accepts, sorted by name; none if the folder does not exist.
std::vector<std::filesystem::path> filesIn(const std::filesystem::path& folder,
                                           bool (*accepts)(const std::filesystem::path&));
// Returns the subfolders of a folder, sorted by name; none if the folder does not exist.
std::vector<std::filesystem::path> foldersIn(const std::filesystem::path& folder);

}  // namespace scanmill
