#pragma once

// Recognises the kinds of YAML files by keys that only one kind has. If a file of the wrong kind is given, the message
// can then say what it is.

#include "config/value.h"

namespace scanmill {

enum class FileKind { Unknown, Pipeline, Scene, Sensor, Ontology, Materials };

// Returns the kind of a file; `root` is the whole file.
FileKind fileKind(const Value& root);

// Throws an InputError that says what the file is and where it belongs, if it is certainly not of the expected kind.
void expectKind(const Value& root, FileKind expected);

}  // namespace scanmill
