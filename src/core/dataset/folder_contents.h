#pragma once

// Lists the files in the folder of a dataset, and finds the files that this program has written.

#include <filesystem>
#include <set>
#include <string>
#include <vector>

namespace scanmill {

// Names of files in the hidden folder (kHiddenName), and the suffix of the records in this folder.
inline constexpr const char* kPlanName = "plan";
inline constexpr const char* kReplacedName = "replaced.json";  // manifest of the dataset that is being replaced
inline constexpr const char* kRecordSuffix = ".json";          // appended to the name of a shard

struct FolderContents {
  bool manifest = false;
  bool unfinished = false;             // true if the folder has an unfinished dataset
  std::vector<std::string> shards;     // names relative to the folder
  std::vector<std::string> leftovers;  // names of temporary files, relative to the folder
  std::string foreign;                 // name of a file or folder that belongs to no dataset; empty: none
  bool empty() const { return !manifest && !unfinished && shards.empty() && leftovers.empty() && foreign.empty(); }
};

// True if a dataset was started in the folder and not completed.
bool isUnfinished(const std::filesystem::path& folder);

// Throws InputError if the folder has no manifest; the message says what the folder is instead. Unless the folder is a
// recording or an unfinished dataset, the message ends with `alternatives`, a text on what else the caller could read.
void requireDataset(const std::filesystem::path& folder, const std::string& alternatives = "");

// Lists the files in the folder and in its subfolders. Throws std::filesystem::filesystem_error.
FolderContents contentsOf(const std::filesystem::path& folder);

// Returns the shards that a manifest lists, and the files that describe their samples; none if the manifest does not
// exist. Throws InputError if the manifest cannot be read.
std::vector<std::string> filesListedIn(const std::filesystem::path& manifest);

// Returns the names of the shards that have records in the hidden folder.
std::vector<std::string> shardsRecordedIn(const std::filesystem::path& hidden);

// Returns the names of the shards that this program wrote into a folder, and of the files that describe their samples.
// These files belong to the dataset in the folder; or, if a process was killed while it published a dataset, to the old
// or the new dataset. Throws InputError if a manifest in the folder cannot be read.
std::set<std::string> writtenFiles(const std::filesystem::path& folder);

// Throws InputError if writing a new dataset would destroy or hide files that this program has not written.
void checkOwnership(const std::filesystem::path& folder, const FolderContents& contents);

}  // namespace scanmill
