#pragma once

// What commands that read recorded scans share.

#include <filesystem>
#include <string>

#include "commands/arguments.h"

namespace scanmill {

// Throws InputError where the file is a folder of frames, which is no scan, and says how to name those in it.
void expectScan(const std::string& file);

// The text of an option; throws InputError, which says what it is for, where it is missing.
std::string requiredText(const Arguments& parsed, const std::string& option, const std::string& what);

// The file of the option `out`. Throws InputError where it is a folder, or there already and --overwrite is not said.
std::filesystem::path requiredFile(const Arguments& parsed, const std::string& what);

}  // namespace scanmill
