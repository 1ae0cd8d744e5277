#pragma once

// Readers of files of strangers, each of which takes any bytes: it reads them or throws an Error. Whatever else happens
// is a finding: a crash, a sanitizer's report, another exception, too much time or memory.

#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <string_view>

namespace scanmill {

using FuzzTarget = std::function<void(std::string_view bytes)>;

// By name; corpus/NAME holds inputs of each.
std::map<std::string, FuzzTarget>& fuzzTargets();

struct AddFuzzTarget {
  AddFuzzTarget(const char* name, FuzzTarget target) { fuzzTargets()[name] = std::move(target); }
};

// Gives the bytes to a target, which may cost a sixteenth of what a file of a stranger may cost: 128 MiB and 4 bytes
// for each byte of the file.
void runWithinBudget(const FuzzTarget& target, std::string_view bytes);

// A file with these bytes, in a folder of this process, until the next call. Its name ends with `suffix`.
std::filesystem::path inputFile(std::string_view bytes, const std::string& suffix);

// Kinds that share a target are told apart by the first byte of the input, which is removed: '0' for the first one.
std::size_t kindOf(std::string_view& bytes, std::size_t kinds);

}  // namespace scanmill
