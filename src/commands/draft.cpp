#include "draft/draft.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>
#include <set>

#include "assets/asset_kinds.h"
#include "base/file.h"
#include "base/short_text.h"
#include "base/terminal.h"
#include "commands/arguments.h"
#include "commands/table.h"
#include "config/resources.h"

namespace scanmill {

namespace {

// Returns the files that `paths` name. A folder names all 3D files in it, sorted by path; these files are also added to
// `filesInFolders`.
std::vector<std::filesystem::path> filesOf(const std::vector<std::string>& paths,
                                           std::set<std::filesystem::path>& filesInFolders) {
  std::vector<std::filesystem::path> files;
  for (const std::string& path : paths) {
    if (!isFolder(path)) {
      files.emplace_back(path);
      continue;
    }
    const std::vector<std::filesystem::path> assets = assetsIn(path);
    if (assets.empty()) throw InputError({path}, "contains no 3D file");
    files.insert(files.end(), assets.begin(), assets.end());
    filesInFolders.insert(assets.begin(), assets.end());
  }
  return files;
}

// Prints a table with a row for each file, then lines about all files together. `out`: the drafted scene file.
void printFiles(const draft::Draft& made, const std::filesystem::path& out) {
  Rows rows{{"file", "unit", "up", "size", "triangles", "guessed", "by the file's name", "doubtful"}};
  using draft::GuessedFile;
  std::uint64_t triangles = 0, withCopies = 0, guessed = 0, byFolder = 0;
  std::set<double> units;  // m per unit of the files
  for (const GuessedFile& f : made.files) {
    triangles += f.triangles();
    withCopies += f.trianglesWithCopies();
    guessed += f.guessed();
    byFolder += f.byFolder();
    units.insert(f.frame.unit);
    rows.push_back({f.file.string(), fmt::format("{:g}", f.frame.unit), std::string(1, f.frame.up), extentText(f.box),
                    grouped(f.triangles()), percent(f.guessed(), f.triangles()), percent(f.byFile(), f.triangles()),
                    fmt::format("{}", fmt::join(f.doubts(), ", "))});
  }
  const bool anyDoubts = std::ranges::any_of(made.files, [](const GuessedFile& f) { return !f.doubts().empty(); });
  if (!anyDoubts) {
    for (std::vector<std::string>& row : rows) row.pop_back();
  }
  printText("{}\nclasses are guessed for {} of {} triangles ({}), by the names that {} lists\n", formatTable(rows),
            grouped(guessed), grouped(triangles), percent(guessed, triangles), out.string());
  if (withCopies > triangles) {
    printText("a part that a file repeats is counted once; with all copies there are {} triangles, as in the picture\n",
              grouped(withCopies));
  }
  if (byFolder > 0) {
    printText("{} more ({}) get the class that only the name of their folder states: check it\n", grouped(byFolder),
              percent(byFolder, triangles));
  }
  if (made.files.size() > 1) {
    printText("{}\n",
              made.onePlace
                  ? "the files keep their coordinates, since these fit together as one place"
                  : "the files are placed side by side, since their coordinates do not fit together as one place");
  }
  if (units.size() > 1) {
    printText(
        "the guessed units differ, but files that fit together, such as tiles, share a unit: see the reasons in the "
        "draft\n");
  }
}

// Prints a hint if a third of the triangles have the class `object`, but classes of their own in the ontology for
// rooms.
void printIndoorHint(const draft::Draft& made, const Ontology& ontology) {
  const Ontology rooms = readOntology(namedResource("nyu40", "labels"));
  const auto nameIn = [](const Concept& shown, const Ontology& classes) {
    const SemanticClass* const found = classOf(shown, classes);
    return found == nullptr ? std::string() : found->name;
  };
  std::uint64_t triangles = 0, finer = 0;
  for (const draft::GuessedFile& file : made.files) {
    triangles += file.triangles();
    finer += file.trianglesOf([&](const draft::GuessedPart& part) {
      if (part.shows == nullptr || nameIn(*part.shows, ontology) != "object") return false;
      const std::string own = nameIn(*part.shows, rooms);
      return !own.empty() && !own.starts_with("other");
    });
  }
  if (3 * finer < triangles) return;
  printText("{} are `object` here, but have classes of their own in the ontology for rooms: --ontology nyu40\n",
            percent(finer, triangles));
}

}  // namespace

int runDraft(const std::vector<std::string>& arguments) {
  CommandOptions options("draft");
  options.add("o,out", "the scene file to write", textValue(), "FILE.yaml");
  options.add("ontology", "the classes to choose from: an ontology file, or a name of `scanmill list ontologies`",
              textValue()->default_value("scanmill"));
  options.add("words", "the classes that words in names stand for, instead of labels/words.yaml", textValue(),
              "FILE.yaml");
  options.add("overwrite", "replace an existing scene file and picture");
  options.add("allow-outside",
              "allow glTF and OBJ files to name files outside their folders; the scene file then allows it, too");
  options.add(
      "leave-out-missing",
      "go on without models and meshes that worlds name and that are missing; the scene file then does so, too");
  addInputLimit(options);
  const Arguments parsed = parseArguments(
      options, arguments,
      "  scanmill draft models/town.glb -o scenes/town.yaml\n"
      "  scanmill draft models/ -o scenes/all.yaml   # all 3D files of a folder, side by side\n"
      "  scanmill view scenes/town.yaml              # or look at scenes/town.png, which draft makes too\n");
  if (!parsed.has("input")) throw InputError("draft: name 3D files, or folders that contain 3D files");
  draft::DraftOptions reading{parsed.has("allow-outside"), parsed.has("leave-out-missing"), {}};
  const std::vector<std::filesystem::path> files = filesOf(parsed.inputs(), reading.mayFail);
  const std::filesystem::path out = folderOption(parsed, "out");
  if (out.empty()) throw InputError("-o FILE.yaml is missing: name the scene file to write");
  const std::filesystem::path picture = std::filesystem::path(out).replace_extension(".png");
  const std::string ontologyName = parsed.options["ontology"].as<std::string>();
  const Ontology ontology = readOntology(namedResource(ontologyName, "labels"));
  const std::vector<Concept> concepts = readConcepts(parsed.has("words") ? std::filesystem::path(parsed.text("words"))
                                                                         : resourceFolder() / "labels/words.yaml");
  for (const std::filesystem::path& made : {out, picture}) prepareOutputFile(made, parsed);
  const draft::Draft made = [&] {
    const InputBudget budget;  // the picture, which reads the scene, has a budget of its own
    return draft::draftScene(files, concepts, ontology, ontologyName, out.stem().string(), out.parent_path(), reading);
  }();
  writeFile(out, made.yaml);

  printFiles(made, out);
  if (!parsed.has("ontology")) printIndoorHint(made, ontology);
  runView({out.string(), "--screenshot", picture.string()});
  printText("next: scanmill view {0}; scanmill info {0}; write a pipeline that uses it (docs/own_scene.md)\n",
            out.string());
  return 0;
}

}  // namespace scanmill
