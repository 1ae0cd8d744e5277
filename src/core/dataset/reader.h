#pragma once

// Reads the shards of a dataset back.
//
//   readTar("out/quickstart/train/train-000000.tar", [](const std::string& name, std::string_view bytes) {
//     if (name.ends_with(".drc")) std::printf("%s: %zu points\n", name.c_str(), decodeMember(name, bytes).size());
//   });

#include <filesystem>
#include <functional>
#include <string>
#include <string_view>

#include "dataset/manifest.h"
#include "scan/scan.h"

namespace scanmill {

// Calls visit(name, bytes) for each member of a tar file, in the file's order. Throws an InputError with the file and
// the offset if the file is truncated or not a tar file.
void readTar(const std::filesystem::path& file, const std::function<void(const std::string&, std::string_view)>& visit);

// Decodes a member of a shard. The suffix of its name determines the format. Throws an InputError that names the
// member, also if no format has this suffix.
Scan decodeMember(const std::string& name, std::string_view bytes);

}  // namespace scanmill
