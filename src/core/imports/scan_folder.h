#pragma once

// Folders of scans that somebody recorded, in the layouts of public datasets. Adding a layout is a new file and a row
// in scan_folder.cpp.

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
  std::filesystem::path lidarseg;  // of nuScenes; empty where there is none
};

struct ScanFolder {
  std::string layout;                // "kitti"
  std::string sensor;                // "velodyne"; empty where the layout names none
  std::optional<Ontology> ontology;  // of its labels; none where the layout has no labels
  std::vector<FolderScan> scans;     // in the order of their keys
};

// What the first layout that fits makes of a folder: a dataset's root, or a part of it such as one sequence. None where
// it holds no scans. Throws InputError.
std::optional<ScanFolder> scanFolderIn(const std::filesystem::path& folder);

// Reads a scan with its labels, in the frame that its file has. Any thread may call it. Throws InputError.
Scan readFolderScan(const FolderScan& scan);

// The classes of the labels that readCloud() finds beside a scan; none where there are no labels.
std::optional<Ontology> ontologyBeside(const std::filesystem::path& scan);

// The readers of the layouts: none where the folder is of another one. Throw InputError where it is of this one and
// damaged.
std::optional<ScanFolder> readNuScenesFolder(const std::filesystem::path& folder);
std::optional<ScanFolder> readKittiFolder(const std::filesystem::path& folder);
std::optional<ScanFolder> readPlainFolder(const std::filesystem::path& folder);

// The files of a folder that satisfy `wanted`, sorted by name; none where there is no such folder.
std::vector<std::filesystem::path> filesIn(const std::filesystem::path& folder,
                                           bool (*wanted)(const std::filesystem::path&));
// The folders in it, likewise.
std::vector<std::filesystem::path> foldersIn(const std::filesystem::path& folder);

}  // namespace scanmill
