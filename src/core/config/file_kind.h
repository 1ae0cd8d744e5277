#pragma once

// Recognises the kinds of YAML files by keys that only one kind has. Where a file is given in the place of another
// kind, the message can then say what it is.

#include "config/value.h"

namespace scanmill {

enum class FileKind { Unknown, Pipeline, Scene, Sensor, Ontology, Materials };

// `root` is a whole file.
FileKind fileKind(const Value& root);

// Throws an InputError that says what the file is and where it belongs, if it is surely of another kind than expected.
void expectKind(const Value& root, FileKind expected);

}  // namespace scanmill
