#pragma once

// What lies in a folder that a dataset is written into, and what of it is this program's.

#include <filesystem>
#include <string>
#include <vector>

namespace scanmill {

// Within the hidden folder (kHiddenName).
inline constexpr const char* kPlanName = "plan";
inline constexpr const char* kReplacedName = "replaced.json";  // the manifest of the dataset that is being replaced
inline constexpr const char* kRecordSuffix = ".json";          // behind the name of a shard

struct FolderContents {
  bool manifest = false;
  bool unfinished = false;             // somebody has begun a dataset here
  std::vector<std::string> shards;     // relative names
  std::vector<std::string> leftovers;  // relative names of temporary files
  std::string foreign;                 // the first name, by its letters, of what is neither; empty where there is none
  bool empty() const { return !manifest && !unfinished && shards.empty() && leftovers.empty() && foreign.empty(); }
};

// Whether somebody has begun a dataset there, and not ended it.
bool isUnfinished(const std::filesystem::path& folder);

// Looks at the folder and one level below. Throws std::filesystem::filesystem_error.
FolderContents contentsOf(const std::filesystem::path& folder);

// The shards that a manifest lists, and the files that describe their samples; none where it is absent. Throws
// InputError where it cannot be read.
std::vector<std::string> listedIn(const std::filesystem::path& manifest);

// Names of shards that have records in the hidden folder.
std::vector<std::string> recordedIn(const std::filesystem::path& hidden);

// The shards in a folder that are this program's: of the dataset there, of one that was being replaced, and of the one
// that replaced it, where a process was killed meanwhile. Throws InputError as listedIn() does.
std::vector<std::string> ownShards(const std::filesystem::path& folder);

// Throws InputError where a new dataset would destroy, or hide, what this program has not written.
void checkOwnership(const std::filesystem::path& folder, const FolderContents& contents);

}  // namespace scanmill
