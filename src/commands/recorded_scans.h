#pragma once

// What commands that read recorded scans share.

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "commands/arguments.h"
#include "scan/scan.h"

namespace scanmill {

// Calls visit(scan, name) for the scans of what is given: files, and folders of recorded scans, datasets and shards, of
// which the first sensor and at most 100 scans are taken, evenly. Throws InputError.
void forEachScan(const std::vector<std::string>& given,
                 const std::function<void(const Scan&, const std::string&)>& visit);

// The text of an option; throws InputError, which says what it is for, where it is missing.
std::string requiredText(const Arguments& parsed, const std::string& option, const std::string& what);

// The file of the option `out`. Throws InputError where it is a folder, or there already and --overwrite is not said.
std::filesystem::path requiredFile(const Arguments& parsed, const std::string& what);

}  // namespace scanmill
