#pragma once

// The folder that a study writes its tables, charts and report into.

#include <filesystem>

namespace scanmill {

// Creates `folder`, before the work. One that holds files is an InputError, unless `overwrite` and it holds `result`,
// the file by which a study of the kind is known. Removes nothing: what is there stays until there is something new.
void prepareReportFolder(const std::filesystem::path& folder, const std::string& result, bool overwrite);

// Takes `result` away, where it is, so that nothing looks finished while the folder's other files are written anew.
void beginReport(const std::filesystem::path& folder, const std::string& result);

}  // namespace scanmill
