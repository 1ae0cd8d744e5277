#include "scene/draft/draft.h"

#include <fmt/format.h>

#include <filesystem>
#include <set>

#include "base/file.h"
#include "base/grouped.h"
#include "commands/arguments.h"
#include "commands/table.h"
#include "config/resources.h"
#include "scene/assets/asset_files.h"

namespace scanmill {

namespace {

// Folders stand for the 3D files in them, in the order of their names.
std::vector<std::filesystem::path> filesOf(const std::vector<std::string>& named) {
  std::vector<std::filesystem::path> files;
  for (const std::string& name : named) {
    std::error_code error;
    if (!std::filesystem::is_directory(name, error)) {
      files.emplace_back(name);
      continue;
    }
    const std::vector<std::filesystem::path> found = assetsIn(name);
    if (found.empty()) throw InputError({name}, "holds no 3D file");
    files.insert(files.end(), found.begin(), found.end());
  }
  return files;
}

std::vector<std::string> assetsOf(const Arguments& parsed) {
  if (parsed.options.count("input") == 0) throw InputError("draft: name 3D files, or folders that hold some");
  return parsed.options["input"].as<std::vector<std::string>>();
}

std::filesystem::path ontologyFile(const std::string& name) {
  const std::filesystem::path own = resourceFolder() / "labels" / (name + ".yaml");
  std::error_code error;
  return std::filesystem::exists(own, error) ? own : std::filesystem::path(name);
}

}  // namespace

int runDraft(const std::vector<std::string>& arguments) {
  const Command& command = commandNamed("draft");
  cxxopts::Options options = describe(command);
  options.add_options()("o,out", "the scene file", cxxopts::value<std::string>(), "FILE.yaml")(
      "ontology", "classes to guess: a file, or the name of one of the program's",
      cxxopts::value<std::string>()->default_value("scanmill"))(
      "words", "what words mean, in place of labels/words.yaml", cxxopts::value<std::string>(), "FILE.yaml")(
      "overwrite", "replace a scene file and a picture that are there");
  const Arguments parsed = parseArguments(
      command, options, arguments,
      "  scanmill draft models/town.glb -o scenes/town.yaml\n"
      "  scanmill draft models/ -o scenes/all.yaml   # what is in a folder, side by side\n"
      "  scanmill view scenes/town.yaml              # or look at scenes/town.png, which draft makes too\n");
  if (parsed.help) return 0;
  const std::vector<std::filesystem::path> files = filesOf(assetsOf(parsed));
  const std::filesystem::path out = folderOption(parsed, "out");
  if (out.empty()) throw InputError("draft: name the scene file: -o FILE.yaml");
  const std::filesystem::path picture = std::filesystem::path(out).replace_extension(".png");
  for (const std::filesystem::path& made : {out, picture}) {
    std::error_code error;
    if (std::filesystem::exists(made, error) && parsed.options.count("overwrite") == 0) {
      throw InputError({made.string()}, "is there already: name another file, or say --overwrite");
    }
  }
  const std::string ontologyName = parsed.options["ontology"].as<std::string>();
  const Ontology ontology = readOntology(ontologyFile(ontologyName));
  const std::vector<draft::Concept> concepts = draft::readConcepts(
      parsed.options.count("words") > 0 ? std::filesystem::path(parsed.options["words"].as<std::string>())
                                        : resourceFolder() / "labels/words.yaml");
  const draft::Draft made =
      draft::draftScene(files, concepts, ontology, ontologyName, out.stem().string(), out.parent_path());
  writeFile(out, made.yaml);

  std::vector<std::vector<std::string>> rows{{"file", "unit", "up", "triangles", "guessed", "by the file's name"}};
  std::uint64_t triangles = 0;
  std::uint64_t guessed = 0;
  std::set<double> units;
  for (const draft::DraftedFile& f : made.files) {
    rows.push_back({f.file.string(), fmt::format("{:g}", f.frame.unit), std::string(1, f.frame.up),
                    grouped(f.triangles), percent(static_cast<double>(f.guessed), static_cast<double>(f.triangles)),
                    percent(static_cast<double>(f.byFile), static_cast<double>(f.triangles))});
    units.insert(f.frame.unit);
    triangles += f.triangles;
    guessed += f.guessed;
  }
  fmt::print("{}\nclasses are guessed for {} of {} triangles ({}), by the names that stand in {}\n", formatTable(rows),
             grouped(guessed), grouped(triangles),
             percent(static_cast<double>(guessed), static_cast<double>(triangles)), out.string());
  if (made.files.size() > 1) {
    fmt::print("{}\n", made.onePlace ? "the files keep their own coordinates, as parts of one place"
                                     : "the files stand side by side; their own coordinates do not make one place");
  }
  if (units.size() > 1)
    fmt::print("units differ: files that fit together, such as tiles, have one; see why in the draft\n");
  runView({out.string(), "--screenshot", picture.string()});
  fmt::print("next: scanmill view {0}; scanmill info {0}; a pipeline for it (docs/guide.md)\n", out.string());
  return 0;
}

}  // namespace scanmill
