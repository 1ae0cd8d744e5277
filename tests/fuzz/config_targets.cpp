// YAML: by itself, and as the files of this program.

#include "base/error.h"
#include "config/resources.h"
#include "config/value.h"
#include "pipeline/read/pipeline.h"
#include "scene/material.h"
#include "scene/ontology.h"
#include "scene/scene.h"
#include "scenefile/scene_file.h"
#include "tests/fuzz/target.h"

namespace scanmill {
namespace {

const AddFuzzTarget kYaml("yaml", [](std::string_view bytes) { parseYaml(bytes, "input.yaml"); });

const AddFuzzTarget kPipeline("pipeline", [](std::string_view bytes) {
  readPipelineText(std::string(bytes), resourceFolder() / "pipelines/input.yaml");
});

// Towns have tests of their own, and take seconds.
const AddFuzzTarget kScene("scene", [](std::string_view bytes) {
  if (bytes.find("town") != std::string_view::npos) return;
  readScene(inputFile(bytes, ".yaml"), {});
});

const AddFuzzTarget kLabels("labels", [](std::string_view bytes) {
  const bool ontology = kindOf(bytes, 2) == 0;
  const auto file = inputFile(bytes, ".yaml");
  if (ontology) {
    readOntology(file);
  } else {
    readMaterials(file);
  }
});

}  // namespace
}  // namespace scanmill
