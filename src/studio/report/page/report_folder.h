#pragma once

// The folder that a study writes its tables, charts and report into.

#include <filesystem>

namespace scanmill {

// Creates `folder` before the work begins. Throws InputError where it holds files, unless `overwrite` is set and one of
// them is `result`, the file by which a study of the kind is known. Removes nothing: what is there stays until there is
// something new.
void prepareReportFolder(const std::filesystem::path& folder, const std::string& result, bool overwrite);

// Removes `result` where it is there, so that nothing looks finished while the folder's other files are written anew.
void beginReport(const std::filesystem::path& folder, const std::string& result);

}  // namespace scanmill
