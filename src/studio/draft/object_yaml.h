#pragma once

// Writes the lines of a drafted scene file for one 3D file.

#include <filesystem>
#include <string>
#include <vector>

#include "draft/model.h"
#include "scene/ontology.h"

namespace scanmill::draft {

// Returns the concepts that have a class in the ontology, and those that need no class, such as parts to be removed.
// Example: if an ontology for rooms has no class for buildings, "office.glb" is not taken for a building. Names of the
// ontology's classes are words, too.
std::vector<Concept> conceptsFor(const std::vector<Concept>& concepts, const Ontology& ontology);

// Returns the YAML of an object without its position. `folder`: future folder of the scene file, to which paths are
// relative.
std::string objectYaml(const Model& model, const std::vector<Concept>& concepts, const Ontology& ontology,
                       const std::filesystem::path& folder, const DraftOptions& options);

}  // namespace scanmill::draft
