#pragma once

// Writes the lines of a drafted scene file for one 3D file.

#include <filesystem>
#include <string>
#include <vector>

#include "draft/model.h"
#include "scene/ontology.h"

namespace scanmill::draft {

// Returns the concepts for which the ontology has a class, and those without classes, such as for parts to leave out.
// An ontology of rooms without buildings, for example, does not take "office.glb" for a building.
std::vector<Concept> conceptsFor(const std::vector<Concept>& concepts, const Ontology& ontology);

// Returns a text in double quotes, escaped for YAML.
std::string quoted(const std::string& text);

// Returns the YAML of an object without its position. Paths are relative to `folder`, where the scene file will be.
std::string objectYaml(const Model& model, const std::vector<Concept>& concepts, const Ontology& ontology,
                       const std::filesystem::path& folder);

}  // namespace scanmill::draft
