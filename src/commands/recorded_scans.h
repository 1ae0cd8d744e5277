#pragma once

// What commands that read recorded scans share.

#include <filesystem>
#include <string>
#include <vector>

#include "commands/arguments.h"

namespace scanmill {

// The files of the scans that are given, in place of the folders of recorded scans among them (imports/scan_folder.h).
// Throws InputError for folders that hold none.
std::vector<std::string> scanFiles(const std::vector<std::string>& given);

// The text of an option; throws InputError, which says what it is for, where it is missing.
std::string requiredText(const Arguments& parsed, const std::string& option, const std::string& what);

// The file of the option `out`. Throws InputError where it is a folder, or there already and --overwrite is not said.
std::filesystem::path requiredFile(const Arguments& parsed, const std::string& what);

}  // namespace scanmill
