#pragma once

// Prepares the folder into which a study writes its tables, charts and report.

#include <filesystem>

namespace scanmill {

// Creates the folder before the study starts. Throws InputError if the folder contains files. With `overwrite`, the
// folder may contain files if one of them is `result`, the file that shows that the folder has results of the same kind
// of study. Removes nothing; old files remain until new files replace them.
void prepareReportFolder(const std::filesystem::path& folder, const std::string& result, bool overwrite);

// Removes the file `result` if it exists, so that the folder does not look complete while its other files are written.
void beginReport(const std::filesystem::path& folder, const std::string& result);

}  // namespace scanmill
