#pragma once

// Functions that commands on recorded scans share: they read scans and options, and find the response of a sensor.

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "commands/arguments.h"
#include "commands/command.h"
#include "scan/scan.h"
#include "study/noise/response.h"

namespace scanmill {

// Calls visit(scan, name) for the scans of these paths: files, folders of recorded scans, datasets and shards. Each
// folder, dataset or shard gives the scans of its first sensor, at most 100, evenly spaced. Throws InputError.
void forEachScan(const std::vector<std::string>& paths,
                 const std::function<void(const Scan&, const std::string&)>& visit);

// Returns the text of an option. If the text is missing or empty, throws an InputError that ends with `advice`, which
// says what the user should give.
std::string requiredText(const Arguments& parsed, const std::string& option, const std::string& advice);

// Returns the file that --out names. Throws InputError if the option is missing (the message ends with `advice`), or if
// the file must not be written (see prepareOutputFile()).
std::filesystem::path requiredFile(const Arguments& parsed, const std::string& advice);

// Adds the option `simulated` of the commands that find a sensor's response.
void addSimulatedOption(CommandOptions& options);

struct FoundResponse {
  ResponseFit fit;
  std::string yaml;  // the effect `intensity`, an item of the key `effects`
};
// Finds the response of the sensor that recorded the scans, by comparing them with the dataset that --simulated names
// (study/noise/response.h), and prints the misfit. Returns nothing if the option is not given. Throws InputError if the
// dataset has no manifest or cannot be read.
std::optional<FoundResponse> responseOf(const std::vector<Scan>& recorded, const Arguments& parsed);

}  // namespace scanmill
