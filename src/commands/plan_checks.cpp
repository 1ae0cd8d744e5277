#include "commands/plan_checks.h"

#include <fmt/core.h>

#include <algorithm>
#include <map>
#include <set>

#include "base/short_text.h"
#include "base/terminal.h"
#include "commands/table.h"
#include "pipeline/checks/warnings.h"
#include "pipeline/scenes/scene_probe.h"
#include "pipeline/scenes/shot_source.h"

namespace scanmill {

namespace {

constexpr std::size_t kMostScenes = 20;  // greatest number of scenes to load; further scenes seldom show other faults

// Prints the numbers of triangles without a class by file, material and texture, the largest number first.
void printUnlabeled(const std::map<UnlabeledPart, std::uint64_t>& unlabeled) {
  constexpr std::size_t kMostRows = 20;
  if (unlabeled.empty()) {
    printText("unlabelled geometry: none\n");
    return;
  }
  struct Group {
    std::uint64_t triangles = 0;
    std::set<std::string> nodes;
  };
  std::map<UnlabeledPart, Group> groups;
  for (const auto& [part, triangles] : unlabeled) {
    Group& group = groups[{part.file, part.material, part.texture, {}}];
    group.triangles += triangles;
    group.nodes.insert(part.node);
  }
  std::vector<std::pair<UnlabeledPart, Group>> sorted(groups.begin(), groups.end());
  std::stable_sort(sorted.begin(), sorted.end(),
                   [](const auto& a, const auto& b) { return a.second.triangles > b.second.triangles; });
  printText("unlabelled geometry (no rule gives it a class):\n");
  Rows rows{{"file", "material", "texture", "nodes", "triangles"}};
  for (std::size_t i = 0; i < std::min(sorted.size(), kMostRows); ++i) {
    const auto& [part, group] = sorted[i];
    const std::string& first = *group.nodes.begin();
    rows.push_back({part.file, part.material, part.texture,
                    group.nodes.size() == 1 ? first : fmt::format("{} and {} more", first, group.nodes.size() - 1),
                    grouped(group.triangles)});
  }
  printText("{}", formatTable(rows));
  if (sorted.size() > kMostRows)
    printText("and {} more combinations of file, material and texture\n", sorted.size() - kMostRows);
}

// Returns in words what the seed selects at random: the kind of place, and values of the scene file's keys.
std::string placeOf(const Scene& scene) {
  std::string words = scene.about;
  for (const DrawnValue& draw : scene.draws) {
    words += fmt::format("{}{} {}", words.empty() ? "" : ", ", draw.key, draw.value);
  }
  return words;
}

}  // namespace

SceneFindings checkScenes(ShotSource& source) {
  const Plan& plan = source.plan();
  const Pipeline& pipeline = plan.pipeline;
  SceneFindings found{modelled(plan, source.blockedShares()), 0};
  Rows scenes{{"scene", "triangles", "placed", "instances", "things", "materials", "dropped", "place"}};
  std::map<UnlabeledPart, std::uint64_t> unlabeled;
  std::set<std::string> rules;  // warnings about rules; each is printed once for all seeds
  std::uint64_t more = 0;       // number of scenes that are not loaded
  for (std::size_t i = 0; i < pipeline.sequences.size(); ++i) {
    const Sequence& s = pipeline.sequences[i];
    if (i > 0 && s.sameScene(pipeline.sequences[i - 1])) continue;  // the scene was checked with its first sequence
    if (scenes.size() > kMostScenes) {
      ++more;
      continue;
    }
    const std::string name = fmt::format("{} seed {}", s.scene, s.sceneSeed);
    const Scene scene = source.load(i);
    const auto method = source.method(scene);
    scenes.push_back({name, grouped(scene.triangles()), grouped(scene.placedTriangles()),
                      grouped(scene.instances.size()), grouped(scene.things()), grouped(scene.materials.size()),
                      grouped(scene.dropped.total()), placeOf(scene)});
    for (const std::string& line : damageWarnings(scene)) warn(line);
    for (const std::string& line : sizeWarnings(scene)) warn(line);
    for (const std::string& line : seedWarnings(pipeline, s, scene)) warn(line);
    for (const std::string& line : ruleWarnings(scene)) rules.insert(line);
    for (const std::string& line : withoutWarnings(scene)) rules.insert(line);
    if (pipeline.recording == nullptr) {
      const SceneProbe probe(scene, method.get(), pipeline.method.entry);
      for (std::size_t k = i; k < pipeline.sequences.size() && pipeline.sequences[k].sameScene(s); ++k) {
        for (const std::string& line : wayWarnings(source, k, probe)) warn(line);
      }
    }
    for (const auto& [what, triangles] : scene.unlabeled) unlabeled[what] += triangles;
    if (method == nullptr) continue;
    // Some of these items differ from scene to scene: report each feature once, for the first scene that has it.
    for (const ModelledItem& item : modelledOf(plan, s, scene, *method)) {
      const auto isSame = [&](const ModelledItem& known) {
        return known.topic == item.topic && known.leftOut == item.leftOut && known.sensor == item.sensor;
      };
      if (std::none_of(found.modelled.begin(), found.modelled.end(), isSame)) found.modelled.push_back(item);
    }
    plan.checkMemory(method->memoryBytes(), name);
    found.bytes = std::max(found.bytes, method->memoryBytes());
  }
  for (const std::string& line : rules) warn(line);
  // Leaves out the column "place" if the seed selects nothing at random in any scene.
  const bool places =
      std::any_of(scenes.begin() + 1, scenes.end(), [](const auto& row) { return !row.back().empty(); });
  for (std::vector<std::string>& row : scenes) row.resize(places ? row.size() : row.size() - 1);
  if (pipeline.recording == nullptr) {
    printText("{}", formatTable(scenes));
    if (more > 0) printText("and {} more scenes, which are checked when the dataset is made\n", grouped(more));
    printText("\n");
  } else {
    printText("scenes: none, the scans are made from the {} in {}\n\n", nameOf(pipeline.recording->kind),
              pipeline.recording->folder.string());
  }
  if (pipeline.recording == nullptr) printUnlabeled(unlabeled);
  return found;
}

}  // namespace scanmill
