#include <fmt/format.h>

#include "assets/meshes/asset_parts.h"
#include "assets/surveys/surveys.h"
#include "base/error.h"
#include "base/input_budget.h"
#include "config/text.h"
#include "draft/draft.h"

namespace scanmill::draft {
namespace {

// Converts `box`, read with the unit 1, to metres with z up. `frame`: the guessed unit and up axis.
Box inMetres(const Box& box, const FrameGuess& frame) {
  if (box.empty() || frame.up == frame.readUp) return {box.low * frame.unit, box.high * frame.unit};
  // The asset was read with z up, but y is up: (x, y, z) becomes (x, -z, y).
  return {Vec3d{box.low.x, -box.high.z, box.low.y} * frame.unit,
          Vec3d{box.high.x, -box.low.z, box.high.y} * frame.unit};
}

// Reads a file and guesses its concepts. `words`: a copy, in which the words that this asset's names share are ignored.
// The result has no name yet, and its box is in the file's units.
GuessedFile guessFile(const std::filesystem::path& file, Vocabulary words, const DraftOptions& options) {
  const Asset asset = readAsset(
      file, {.textures = false, .allowOutside = options.allowOutside, .leaveOutMissing = options.leaveOutMissing});
  GuessedFile model;
  model.file = file;
  words.ignoreShared(asset);
  model.fileConcept = conceptOfFile(words, asset);
  const Concept* const stated = model.fileConcept.shown;
  // No materials are drafted for points with intensities, nor for coloured points whose file or folder states a class.
  model.measured = std::ranges::any_of(asset.parts, [&](const AssetPart& part) {
    return part.texture == kPointIntensity || (part.texture == kPointColor && stated != nullptr);
  });
  model.numbered = std::ranges::any_of(asset.parts, [](const AssetPart& part) {
    return !part.ownClass.empty() && part.ownClass.find_first_not_of("0123456789") == std::string::npos;
  });
  const std::vector<const Concept*> guesses = guessParts(words, asset, stated);
  const std::vector<const Concept*> guessesWithoutFolder =
      guessParts(words, asset, model.fileConcept.byFolder ? nullptr : stated);
  const std::vector<CountedPart> parts = partsOf(asset);
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const auto& [part, copies] = parts[i];
    // A concept without classes does not label the part, unless it says that the part is dropped.
    const Concept* shows = guesses[i];
    if (shows != nullptr && shows->classes.empty() && shows->kind != ConceptKind::Drop) shows = nullptr;
    const bool byFolder = shows != nullptr && guesses[i] != guessesWithoutFolder[i];
    model.parts.push_back({part->node, part->material, part->texture, shows, byFolder, part->triangles.size(), copies});
  }
  model.frame = guessFrame(asset, guesses);
  model.box = boundsOf(asset);
  model.mixed = groundIn(words, file) != nullptr;
  return model;
}

// Names each model after its file or, if the name is meaningless (such as "model") or not unique, after its folder.
void nameFiles(std::vector<GuessedFile>& models) {
  static constexpr std::array<std::string_view, 6> kMeaningless{"model",    "scene",  "mesh",
                                                                "untitled", "object", "asset"};
  std::map<std::string, std::size_t> filesWithName;
  for (const GuessedFile& m : models) ++filesWithName[m.file.stem().string()];
  std::set<std::string> usedNames;
  for (GuessedFile& m : models) {
    std::string name = m.file.stem().string();
    const std::string folder = folderName(m.file);
    const bool isMeaningless = std::ranges::find(kMeaningless, lowerCase(name)) != kMeaningless.end();
    if ((isMeaningless || filesWithName[name] > 1) && !folder.empty()) name = folder;
    m.name = name;
    for (int number = 2; !usedNames.insert(m.name).second; ++number) m.name = fmt::format("{}_{}", name, number);
  }
}

// True if nodes are named after coarser levels of detail too: "Tree_LOD1" or "Tree_Billboard" beside "Tree_LOD0".
bool hasCoarserLevels(const std::vector<GuessedPart>& parts) {
  std::set<std::string> nodes;
  for (const GuessedPart& p : parts) nodes.insert(lowerCase(p.node));
  return std::ranges::any_of(nodes, [&](const std::string& node) {
    const std::size_t underscore = node.rfind('_');
    if (underscore == std::string::npos || !nodes.contains(node.substr(0, underscore) + "_lod0")) return false;
    const std::string level = node.substr(underscore + 1);
    return level == "billboard" ||
           (level.size() == 4 && level.starts_with("lod") && level[3] >= '1' && level[3] <= '9');
  });
}

}  // namespace

std::vector<std::string> GuessedFile::doubts() const {
  std::vector<std::string> doubts;
  if (frame.doubtfulUnit) doubts.emplace_back("size");
  if (frame.doubtfulUp) doubts.emplace_back("up axis");
  if (numbered) doubts.emplace_back("labels without names");
  std::set<std::string> materials;
  for (const GuessedPart& p : parts) materials.insert(p.material + '\n' + p.texture);
  const bool isGround = fileConcept.shown != nullptr && fileConcept.shown->kind == ConceptKind::Ground;
  if (isGround && byFile() + byFolder() > 0 && materials.size() > 1)
    doubts.emplace_back("one class for several materials");
  if (mixed && byFile() > 0) doubts.emplace_back("one class for two in its name");
  if (hasCoarserLevels(parts)) doubts.emplace_back("several levels of detail: `drop` the coarser ones");
  return doubts;
}

std::vector<GuessedFile> guessFiles(const std::vector<std::filesystem::path>& files,
                                    const std::vector<Concept>& concepts, const DraftOptions& options) {
  Vocabulary words(concepts);
  std::vector<std::string> names, folders;
  for (const std::filesystem::path& file : files) {
    names.push_back(file.stem().string());
    folders.push_back(folderName(file));
  }
  words.ignoreShared(names);
  words.ignoreShared(folders);
  std::vector<GuessedFile> models;
  std::exception_ptr firstFailure;  // first exception of a file that may fail
  for (const std::filesystem::path& file : files) {
    try {
      models.push_back(guessFile(file, words, options));
    } catch (const InputLimitError&) {
      throw;
    } catch (const InputError& e) {
      if (!options.mayFail.contains(file)) throw;
      if (firstFailure == nullptr) firstFailure = std::current_exception();
      warn("left out: {}", e.what());
    }
  }
  if (models.empty() && firstFailure != nullptr) std::rethrow_exception(firstFailure);
  std::map<std::pair<std::filesystem::path, std::string>, std::vector<FrameGuess*>> framesByKind;  // folder and format
  for (GuessedFile& m : models) framesByKind[{m.file.parent_path(), lowerExtension(m.file)}].push_back(&m.frame);
  for (const auto& [folderAndFormat, frames] : framesByKind) guessUnitsTogether(frames);
  for (GuessedFile& m : models) m.box = inMetres(m.box, m.frame);
  nameFiles(models);
  return models;
}

}  // namespace scanmill::draft
