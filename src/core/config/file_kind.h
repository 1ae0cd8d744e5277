#pragma once

// Recognises the kind of a YAML file by keys that only this kind has, so that a message about a wrong file can say what
// the file is.

#include <cstddef>
#include <filesystem>
#include <string>

#include "config/value.h"

namespace scanmill {

enum class FileKind { Unknown, Pipeline, Scene, Sensor, Ontology, Materials };

// Returns the kind of a file; `root` is the value of the complete file.
FileKind fileKind(const Value& root);

// Throws an InputError that says what the file is and where it belongs, if it is of another kind than expected. A file
// of unknown kind passes.
void expectKind(const Value& root, FileKind expected);

// True if a file is named like an extract of OpenStreetMap, compressed or not.
bool isMap(const std::filesystem::path& file);

// Returns the first bytes of a file, at most `count`; none if it cannot be read.
std::string firstBytes(const std::filesystem::path& file, std::size_t count);

}  // namespace scanmill
