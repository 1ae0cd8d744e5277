// Copies an example, a commented pipeline or scene, into a folder and prints the commands that make its picture. The
// files of the example NAME are pipelines/examples/NAME.*; NAME.yaml begins with a sentence and the commands.

#include <algorithm>
#include <filesystem>

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
  std::string sentence;
  std::vector<std::string> commands;
  std::vector<fs::path> files;
};

Example readExample(const fs::path& file) {
  constexpr std::string_view kCommand = "#   ";
  Example example{file.stem().string(), {}, {}, {}};
  const std::string text = readFile(file);
  for (std::size_t at = 0; at < text.size() && text[at] == '#';) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    const std::string line = text.substr(at, end - at);
    if (line.starts_with(kCommand)) {
      example.commands.push_back(line.substr(kCommand.size()));
    } else if (line.size() > 2) {
      example.sentence += (example.sentence.empty() ? "" : " ") + line.substr(2);
    }
    at = end + 1;
  }
  return example;
}

std::vector<Example> allExamples() {
  std::vector<Example> examples;
  std::vector<fs::path> files;
  const fs::path folder = resourceFolder() / "pipelines" / "examples";
  if (fs::is_directory(folder)) {
    for (const auto& entry : fs::directory_iterator(folder)) files.push_back(entry.path());
  }
  std::ranges::sort(files);
  for (const fs::path& file : files) {
    // Other files belong to an example, such as NAME.scene.yaml and NAME.obj.
    const bool isExample = file.extension() == ".yaml" && file.stem().extension().empty();
    if (isExample) examples.push_back(readExample(file));
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
  options.add_options()("o,out", "folder to copy to (default: this one)", textValue(), "DIR")(
      "overwrite", "replace files that are there already");
  const Arguments parsed =
      parseArguments(options, arguments, "  scanmill example\n  scanmill example rain_beside_dry\n");
  if (parsed.help) return 0;
  const std::vector<Example> examples = allExamples();
  if (!parsed.has("input")) {
    Rows rows;
    for (const Example& example : examples) rows.push_back({example.name, example.sentence});
    printText("{}", formatTable(rows));
    return 0;
  }
  const std::string name = parsed.positional("NAME");
  const auto found = std::ranges::find(examples, name, &Example::name);
  if (found == examples.end()) {
    std::vector<std::string> names;
    for (const Example& example : examples) names.push_back(example.name);
    throw InputError(
        fmt::format("there is no example '{}'{}; `scanmill example` lists them", name, suggestion(name, names)));
  }
  const fs::path folder = parsed.has("out") ? fs::path(parsed.text("out")) : fs::path(".");
  for (const fs::path& file : found->files) prepareOutputFile(folder / file.filename(), parsed);
  std::string copied;
  for (const fs::path& file : found->files) {
    writeFile(folder / file.filename(), readFile(file));
    copied += (copied.empty() ? "" : ", ") + (folder / file.filename()).lexically_normal().string();
  }
  printText("{}\n\ncopied: {}\nnext{}:\n", found->sentence, copied,
            parsed.has("out") ? fmt::format(", in {}", folder.string()) : "");
  for (const std::string& command : found->commands) printText("  {}\n", command);
  return 0;
}

}  // namespace scanmill
