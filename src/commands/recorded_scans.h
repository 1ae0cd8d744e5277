#pragma once

// Functions that commands share to read recorded scans.

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "commands/arguments.h"
#include "scan/scan.h"

namespace scanmill {

// Calls visit(scan, name) for the given scans: files, and folders of recorded scans, datasets and shards. Folders,
// datasets and shards give the scans of their first sensor, at most 100, taken evenly. Throws InputError.
void forEachScan(const std::vector<std::string>& given,
                 const std::function<void(const Scan&, const std::string&)>& visit);

// Returns the text of an option. Throws InputError if it is missing. `what`: purpose of the option in the message.
std::string requiredText(const Arguments& parsed, const std::string& option, const std::string& what);

// Returns the file of the option `out`. Throws InputError if it is a folder, or if it exists and --overwrite is not
// given.
std::filesystem::path requiredFile(const Arguments& parsed, const std::string& what);

}  // namespace scanmill
