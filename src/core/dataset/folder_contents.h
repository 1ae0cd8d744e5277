#pragma once

// Lists the files in a folder that a dataset is written into, and finds those that this program has written.

#include <filesystem>
#include <string>
#include <vector>

namespace scanmill {

// Names in the hidden folder (kHiddenName).
inline constexpr const char* kPlanName = "plan";
inline constexpr const char* kReplacedName = "replaced.json";  // the manifest of the dataset that is being replaced
inline constexpr const char* kRecordSuffix = ".json";          // appended to the name of a shard

struct FolderContents {
  bool manifest = false;
  bool unfinished = false;             // see isUnfinished()
  std::vector<std::string> shards;     // relative names
  std::vector<std::string> leftovers;  // relative names of temporary files
  std::string foreign;                 // name of another file or folder, the first by name; empty: there is none
  bool empty() const { return !manifest && !unfinished && shards.empty() && leftovers.empty() && foreign.empty(); }
};

// True if a dataset was started in the folder and not completed.
bool isUnfinished(const std::filesystem::path& folder);

// Lists the folder and one level below. Throws std::filesystem::filesystem_error.
FolderContents contentsOf(const std::filesystem::path& folder);

// Returns the shards that a manifest lists, and the files that describe their samples; none if there is no manifest.
// Throws InputError if it cannot be read.
std::vector<std::string> listedIn(const std::filesystem::path& manifest);

// Returns the names of shards that have records in the hidden folder.
std::vector<std::string> recordedIn(const std::filesystem::path& hidden);

// Returns the names of the shards in a folder that this program wrote, and of the files that describe their samples.
// They belong to the dataset there or, if a process was killed while it replaced a dataset, to the old or the new one.
// Throws InputError as listedIn() does.
std::vector<std::string> ownShards(const std::filesystem::path& folder);

// Throws InputError if a new dataset would destroy or hide files that this program has not written.
void checkOwnership(const std::filesystem::path& folder, const FolderContents& contents);

}  // namespace scanmill
