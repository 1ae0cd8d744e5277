#pragma once

// The folder that a study writes its tables, charts and report into.

#include <filesystem>

namespace scanmill {

// Creates `folder` before the work begins. Throws InputError if the folder holds files, unless `overwrite` is set and
// one of the files is `result`, which marks the results of this kind of study. Removes nothing: old files stay until
// new ones replace them.
void prepareReportFolder(const std::filesystem::path& folder, const std::string& result, bool overwrite);

// Removes the file `result` if it exists: the folder must not look finished while its other files are being rewritten.
void beginReport(const std::filesystem::path& folder, const std::string& result);

}  // namespace scanmill
