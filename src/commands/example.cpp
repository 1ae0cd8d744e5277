// Copies an example, a commented pipeline or scene, into a folder and prints the commands that make its picture. The
// files of the example NAME are pipelines/examples/NAME.*; NAME.yaml begins with a sentence and the commands.

#include <algorithm>
#include <filesystem>
#include <sstream>

#include "base/error.h"
#include "base/file.h"
#include "base/terminal.h"
#include "commands/arguments.h"
#include "commands/table.h"
#include "config/fields.h"
#include "config/resources.h"

namespace scanmill {

namespace {

namespace fs = std::filesystem;

struct Example {
  std::string name;
  std::string sentence;               // what the example shows
  std::vector<std::string> commands;  // commands that make its picture
  std::vector<fs::path> files;
};

// Reads the comment at the start of the file: lines "# words of the sentence" and "#   command". Leaves Example::files
// empty.
Example readExample(const fs::path& file) {
  constexpr std::string_view kCommand = "#   ", kWords = "# ";
  Example example{.name = file.stem().string(), .sentence = {}, .commands = {}, .files = {}};
  std::istringstream text(readFile(file));
  for (std::string line; std::getline(text, line) && line.starts_with('#');) {
    if (line.starts_with(kCommand)) {
      example.commands.push_back(line.substr(kCommand.size()));
    } else if (line.size() > kWords.size()) {
      example.sentence += (example.sentence.empty() ? "" : " ") + line.substr(kWords.size());
    }
  }
  return example;
}

std::vector<Example> allExamples() {
  std::vector<Example> examples;
  std::vector<fs::path> files;
  const fs::path folder = resourceFolder() / "pipelines" / "examples";
  if (fs::is_directory(folder)) files.assign(fs::directory_iterator(folder), fs::directory_iterator());
  std::ranges::sort(files);
  for (const fs::path& file : files) {
    // Other files, such as NAME.scene.yaml and NAME.obj, belong to the example NAME.
    if (file.extension() == ".yaml" && file.stem().extension().empty()) examples.push_back(readExample(file));
  }
  for (Example& example : examples) {
    for (const fs::path& file : files) {
      if (file.filename().string().starts_with(example.name + ".")) example.files.push_back(file);
    }
  }
  return examples;
}

}  // namespace

int runExample(const std::vector<std::string>& arguments) {
  CommandOptions options("example");
  options.add("o,out", "folder to copy to (default: this one)", textValue(), "DIR")(
      "overwrite", "replace files that are there already");
  const Arguments parsed =
      parseArguments(options, arguments, "  scanmill example\n  scanmill example rain_beside_dry\n");
  const std::vector<Example> examples = allExamples();
  if (!parsed.has("input")) {
    Rows rows;
    for (const Example& example : examples) rows.push_back({example.name, example.sentence});
    printText("{}", formatTable(rows));
    return 0;
  }
  const std::string name = parsed.positional("NAME");
  const auto example = std::ranges::find(examples, name, &Example::name);
  if (example == examples.end()) {
    throw InputError(fmt::format("there is no example '{}'{}; `scanmill example` lists them", name,
                                 suggestion(name, namesOf(examples))));
  }
  const fs::path folder = parsed.has("out") ? fs::path(parsed.text("out")) : fs::path(".");
  for (const fs::path& file : example->files) prepareOutputFile(folder / file.filename(), parsed);
  std::string copied;
  for (const fs::path& file : example->files) {
    writeFile(folder / file.filename(), readFile(file));
    copied += (copied.empty() ? "" : ", ") + (folder / file.filename()).lexically_normal().string();
  }
  printText("{}\n\ncopied: {}\nnext{}:\n", example->sentence, copied,
            parsed.has("out") ? fmt::format(", in {}", folder.string()) : "");
  for (const std::string& command : example->commands) printText("  {}\n", command);
  return 0;
}

}  // namespace scanmill
