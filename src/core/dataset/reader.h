#pragma once

// Reads the shards of a dataset back.

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "dataset/manifest.h"
#include "scan/scan.h"

namespace scanmill {

// Calls visit(name, bytes) for each member of a tar file, in order. Throws InputError that names the file and the
// offset where it is truncated or not a tar.
void readTar(const std::filesystem::path& file, const std::function<void(const std::string&, std::string_view)>& visit);

// A scan of one member, decoded by the format that its suffix names.
Scan decodeMember(const std::string& name, std::string_view bytes);

}  // namespace scanmill
