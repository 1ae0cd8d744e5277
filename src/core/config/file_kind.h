#pragma once

// Which of our YAML files a file is, told by keys that only its kind has: so that one in the place of another is called
// by its name.

#include "config/value.h"

namespace scanmill {

enum class FileKind { Unknown, Pipeline, Scene, Sensor, Ontology, Materials };

FileKind fileKind(const Value& root);

// Throws InputError that says what the file is and where to name it, if it is surely of another kind.
void expectKind(const Value& root, FileKind expected);

}  // namespace scanmill
