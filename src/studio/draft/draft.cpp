#include "draft/draft.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "config/value.h"

namespace scanmill::draft {
namespace {

// True if the models are parts of one place and share its coordinates: most of their boxes neither contain the origin
// (x, y) nor have their centre in another box. Models of separate objects usually contain the origin of their file, or
// overlap if all are equally far from it.
bool areOnePlace(const std::vector<GuessedFile>& models) {
  std::vector<Box> away;
  for (const GuessedFile& m : models) {
    const Box& box = m.box;
    if (!box.empty() && (box.low.x > 0 || box.low.y > 0 || box.high.x < 0 || box.high.y < 0)) away.push_back(box);
  }
  const auto alone = std::count_if(away.begin(), away.end(), [&](const Box& box) {
    const Vec3d middle = (box.low + box.high) * 0.5;
    return std::none_of(away.begin(), away.end(), [&](const Box& other) {
      return &other != &box && middle.x > other.low.x && middle.x < other.high.x && middle.y > other.low.y &&
             middle.y < other.high.y && middle.z > other.low.z && middle.z < other.high.z;
    });
  });
  return models.size() > 1 && 2 * static_cast<std::size_t>(alone) > models.size();
}

}  // namespace

Draft draftScene(const std::vector<std::filesystem::path>& files, const std::vector<Concept>& concepts,
                 const Ontology& ontology, const std::string& ontologyName, const std::string& name,
                 const std::filesystem::path& folder, const DraftOptions& options) {
  constexpr double kGap = 2;  // gap between objects that are placed side by side (m)
  Draft draft;
  draft.yaml = fmt::format(
      "# A draft: units, axes, classes and materials are guesses by names and sizes. Look at the picture, and at\n"
      "# `scanmill info` of this file, which counts the triangles of each rule.\n"
      "name: {}\nontology: {}\nmaterials: materials\nobjects:\n",
      quotedValue(name), quotedValue(ontologyName));
  const std::vector<Concept> known = conceptsFor(concepts, ontology);
  std::vector<GuessedFile> models = guessFiles(files, known, options);
  draft.onePlace = areOnePlace(models);
  const auto perRow = static_cast<std::size_t>(std::ceil(std::sqrt(static_cast<double>(models.size()))));
  double x = 0, y = 0, deepest = 0;
  for (std::size_t i = 0; i < models.size(); ++i) {
    const GuessedFile& model = models[i];
    draft.yaml += objectYaml(model, known, ontology, folder, options);
    const Box& box = model.box;
    if (models.size() == 1 || box.empty() || draft.onePlace) continue;
    if (i % perRow == 0) {
      y += deepest + (i == 0 ? 0 : kGap);
      x = deepest = 0;
    }
    draft.yaml += fmt::format("    position: [{:.3f}, {:.3f}, {:.3f}]   # beside the others\n", x - box.low.x,
                              y - box.low.y, -box.low.z);
    x += box.high.x - box.low.x + kGap;
    deepest = std::max(deepest, box.high.y - box.low.y);
  }
  draft.files = std::move(models);
  return draft;
}

}  // namespace scanmill::draft
