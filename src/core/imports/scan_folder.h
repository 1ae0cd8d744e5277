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
  std::string key;                 // "08-000010": sequence and frame
  std::filesystem::path points;    // a file that readCloud() reads (formats/cloud_file.h)
  std::filesystem::path lidarseg;  // the labels of nuScenes-lidarseg; empty: none
};

struct ScanFolder {
  std::string layout;                // "kitti"
  std::string sensor;                // "velodyne"; empty: the layout does not name the sensor
  std::optional<Ontology> ontology;  // the classes of the labels; none: there are no labels
  std::vector<FolderScan> scans;     // in the order of their keys
};

// Finds the scans in a folder, by the first layout that fits. The folder may be a dataset's root, or a part of it such
// as one sequence. Returns none if it holds no scans. Throws InputError.
std::optional<ScanFolder> scanFolderIn(const std::filesystem::path& folder);

// Reads a scan with its labels, in the coordinate frame of its file. Any thread may call it. Throws InputError.
Scan readFolderScan(const FolderScan& scan);

// Returns the classes of the labels that readCloud() finds beside a scan; none if there are no labels.
std::optional<Ontology> ontologyBeside(const std::filesystem::path& scan);

// Each of these reads one layout. They return none if the folder has another layout, and throw InputError if it has
// this layout but is damaged.
std::optional<ScanFolder> readNuScenesFolder(const std::filesystem::path& folder);
std::optional<ScanFolder> readKittiFolder(const std::filesystem::path& folder);
std::optional<ScanFolder> readPlainFolder(const std::filesystem::path& folder);

// Returns the files in a folder that satisfy `wanted`, sorted by name; none if the folder does not exist.
std::vector<std::filesystem::path> filesIn(const std::filesystem::path& folder,
                                           bool (*wanted)(const std::filesystem::path&));
// Returns the subfolders of a folder, sorted by name; none if the folder does not exist.
std::vector<std::filesystem::path> foldersIn(const std::filesystem::path& folder);

}  // namespace scanmill
