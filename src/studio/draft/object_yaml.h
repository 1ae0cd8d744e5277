#pragma once

// The lines of a scene file that draft writes for one 3D file.

#include <filesystem>
#include <string>
#include <vector>

#include "draft/model.h"
#include "scene/ontology.h"

namespace scanmill::draft {

// Concepts that the ontology has a class for, or that leave parts out. In rooms, "office.glb" is no building.
std::vector<Concept> conceptsFor(const std::vector<Concept>& concepts, const Ontology& ontology);

// A text in double quotes, as YAML has it.
std::string quoted(const std::string& text);

// All but its place. Files are named from `folder`, where the scene file will be.
std::string objectYaml(const Model& model, const std::vector<Concept>& concepts, const Ontology& ontology,
                       const std::filesystem::path& folder);

}  // namespace scanmill::draft
