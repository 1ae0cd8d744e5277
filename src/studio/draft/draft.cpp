#include "draft/draft.h"

#include <fmt/format.h>

#include "config/value.h"

namespace scanmill::draft {
namespace {

// True if the models are parts of one place and share its coordinates: most of their boxes neither contain the origin
// (x, y) nor have their centre in another box. Models of separate objects usually contain the origin of their file, or
// overlap if all are equally far from the origin.
bool areOnePlace(const std::vector<GuessedFile>& models) {
  std::vector<Box> away;
  for (const GuessedFile& m : models) {
    const Box& box = m.box;
    if (!box.empty() && (box.low.x > 0 || box.low.y > 0 || box.high.x < 0 || box.high.y < 0)) away.push_back(box);
  }
  const auto separate = std::ranges::count_if(away, [&](const Box& box) {
    const Vec3d middle = box.center();
    return std::ranges::none_of(away, [&](const Box& other) {
      return &other != &box && middle.x > other.low.x && middle.x < other.high.x && middle.y > other.low.y &&
             middle.y < other.high.y && middle.z > other.low.z && middle.z < other.high.z;
    });
  });
  return models.size() > 1 && 2 * static_cast<std::size_t>(separate) > models.size();
}

// Returns the position (m) of each model such that all are side by side on the ground, in about as many rows as
// columns; nothing for a model with an empty box.
std::vector<std::optional<Vec3d>> positionsInRows(const std::vector<GuessedFile>& models) {
  constexpr double kGap = 2;  // between the boxes of neighbours (m)
  const auto perRow = static_cast<std::size_t>(std::ceil(std::sqrt(static_cast<double>(models.size()))));
  std::vector<std::optional<Vec3d>> positions(models.size());
  double x = 0, y = 0;  // lower corner of the next box (m)
  double rowDepth = 0;  // largest extent along y in the row so far (m)
  for (std::size_t i = 0; i < models.size(); ++i) {
    const Box& box = models[i].box;
    if (box.empty()) continue;
    if (i % perRow == 0) {
      y += rowDepth + (i == 0 ? 0 : kGap);
      x = rowDepth = 0;
    }
    positions[i] = Vec3d{x - box.low.x, y - box.low.y, -box.low.z};
    x += box.high.x - box.low.x + kGap;
    rowDepth = std::max(rowDepth, box.high.y - box.low.y);
  }
  return positions;
}

}  // namespace

Draft draftScene(const std::vector<std::filesystem::path>& files, const std::vector<Concept>& concepts,
                 const Ontology& ontology, const std::string& ontologyName, const std::string& name,
                 const std::filesystem::path& folder, const DraftOptions& options) {
  Draft draft;
  draft.yaml = fmt::format(
      "# A draft: units, axes, classes and materials are guesses by names and sizes. Look at the picture, and at\n"
      "# `scanmill info` of this file, which counts the triangles of each rule.\n"
      "name: {}\nontology: {}\nmaterials: materials\nobjects:\n",
      quotedValue(name), quotedValue(ontologyName));
  draft.concepts = conceptsFor(concepts, ontology);
  draft.files = guessFiles(files, draft.concepts, options);
  draft.onePlace = areOnePlace(draft.files);
  const std::vector<std::optional<Vec3d>> positions = positionsInRows(draft.files);
  for (std::size_t i = 0; i < draft.files.size(); ++i) {
    draft.yaml += objectYaml(draft.files[i], draft.concepts, ontology, folder, options);
    if (draft.files.size() == 1 || !positions[i] || draft.onePlace) continue;
    draft.yaml += fmt::format("    position: [{:.3f}, {:.3f}, {:.3f}]   # beside the others\n", positions[i]->x,
                              positions[i]->y, positions[i]->z);
  }
  return draft;
}

}  // namespace scanmill::draft
