#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <memory>
#include <sstream>
#include <vector>

#include "assets/meshes/blender.h"
#include "assets/meshes/gltf/model.h"
#include "assets/meshes/imported_file.h"
#include "assets/worlds/world_asset.h"
#include "base/error.h"
#include "base/format_support.h"
#include "base/terminal.h"
#include "commands/arguments.h"
#include "commands/info.h"
#include "commands/table.h"
#include "config/fields.h"
#include "config/resources.h"
#include "exports/layout.h"
#include "formats/format.h"
#include "formats/readers.h"
#include "gpu/compute.h"
#include "gpu/device.h"
#include "images/images.h"
#include "methods/method.h"
#include "pipeline/read/effects.h"
#include "rasters/raster.h"
#include "scan/columns.h"
#include "scene/material.h"
#include "scene/ontology.h"
#include "sense/effect.h"
#include "sensors/calibration.h"
#include "sensors/recorded_poses.h"
#include "sensors/sensor.h"
#include "town/map.h"

namespace scanmill {

namespace {

template <class Entries>
Rows entryRows(const Entries& entries) {
  Rows rows;
  for (const auto& entry : entries) rows.push_back({std::string(entry.name), std::string(entry.summary)});
  return rows;
}

Rows columnRows() {
  Rows rows{{"column", "unit", "type", "by default", "in Draco", "what"}};
  for (const Column& column : kColumns) {
    const std::string loss = column.loss == ColumnLoss::Exact         ? "exact"
                             : column.loss == ColumnLoss::AsPositions ? "as positions"
                                                                      : fmt::format("within {:g}", column.lossBound);
    rows.push_back({std::string(column.name), column.unit.empty() ? "-" : std::string(column.unit),
                    std::string(nameOf(column.type)), column.byDefault ? "yes" : "no", loss,
                    std::string(column.meaning)});
  }
  return rows;
}

// Prints the keys of an effect, format or method that a pipeline can set, one per line. `entry.keys`: one line per key.
template <class Entry>
void printKeysOf(const Entry& entry) {
  printText("  {}{}\n", entry.name, entry.keys.empty() ? ": none" : "");
  std::istringstream lines{std::string(entry.keys)};
  for (std::string line; std::getline(lines, line);) printText("    {}\n", line);
}

template <class Entries>
void printKeys(const Entries& entries) {
  printText("\nkeys, with their defaults:\n");
  for (const auto& entry : entries) printKeysOf(entry);
}

// Prints the entry with this name. Returns false if there is none.
template <class Entries>
bool printNamed(const char* kind, const Entries& entries, std::string_view name) {
  for (const auto& entry : entries) {
    if (entry.name != name) continue;
    printText("{} {}: {}\n\nkeys, with their defaults:\n", kind, entry.name, entry.summary);
    printKeysOf(entry);
    return true;
  }
  return false;
}

// Prints the features that each method supports.
void printCapabilities() {
  printText("\nwhat they can do:\n");
  for (const MethodEntry& method : methods()) {
    const MethodCapabilities& can = method.can;
    printText("  {}: {}, {}{}\n", method.name, can.transmission ? "light goes through glass" : "glass is solid",
              can.moving ? "objects may move" : "objects stand still",
              can.passes ? ", its images can be saved (scanmill render)" : "");
  }
}

// Returns the formats whose readers list what they read and what they leave out.
std::vector<FormatSupport> inputFormats() {
  return {gltf::kGltfFormat,   kBlenderFormat,   kObjFormat,      kPlyMeshFormat, kStlFormat,      kColladaFormat,
          kAc3dFormat,         kImageFormat,     kSdfFormat,      kUrdfFormat,    kTilesetFormat,  kRasterFormat,
          kCloudColumns,       kLasFormat,       kPlyCloudFormat, kPcdFormat,     kCsvFormat,      kDracoFormat,
          kPointRecordsFormat, town::kOsmFormat, kPoseFormat,     kOusterFormat,  kVelodyneFormat, kBeamTableFormat};
}

Rows inputRows() {
  Rows rows;
  for (const FormatSupport& format : inputFormats()) {
    rows.push_back({std::string(format.name), std::string(format.suffixes)});
  }
  return rows;
}

// Prints what the reader of each format reads and leaves out, in Markdown: docs/inputs.md contains this text.
void printElements() {
  for (const FormatSupport& format : inputFormats()) {
    const FormatKeywords& keywords = format.keywords;
    std::vector<std::string_view> notes;
    for (const FormatKeywords::Row& row : keywords.leftOut) notes.push_back(row.note);
    if (!format.alsoLeftOut.empty()) notes.push_back(format.alsoLeftOut);
    printText("\n## {} ({})\n\n{}.\n", format.name, format.suffixes, format.how);
    if (!keywords.read.empty() || !keywords.unused.empty() || !notes.empty()) printText("\n");
    if (!keywords.read.empty()) printText("- Names: `{}`\n", fmt::join(keywords.read, " "));
    if (!keywords.unused.empty()) printText("- *Without effect*: `{}`\n", fmt::join(keywords.unused, " "));
    if (!notes.empty()) printText("- *Left out*: {}\n", fmt::join(notes, "; "));
  }
}

// Returns the names and paths of the YAML files in a folder of the program.
Rows fileRows(const char* folder) {
  Rows rows;
  for (const std::string& name : resourceNames(folder)) {
    rows.push_back({name, (resourceFolder() / folder / (name + ".yaml")).string()});
  }
  return rows;
}

Rows sensorRows() {
  Rows rows{
      {"name", "model", "beams", "scans/s", "points/s", "field (deg)", "range (m)", "origins", "effects", "intensity"}};
  for (const std::vector<std::string>& file : fileRows("pipelines/sensors")) {
    const Value value = readYaml(file.back());
    const std::shared_ptr<const BeamTable> beams = makeBeams(value);
    const std::array<double, 2> field = fieldOf(*beams);
    const bool hasEffects = value.find("effects") != nullptr;
    rows.push_back({file.front(), beams->model, fmt::format("{} x {}", beams->rings, beams->columns * beams->sectors),
                    fmt::format("{:.4g}", 1 / (beams->period * beams->sectors)),
                    fmt::format("{:.0f}", static_cast<double>(beams->size()) / beams->period),
                    fmt::format("{:.3g} x {:.3g}", field[0], field[1]),
                    fmt::format("{:g} to {:g}", beams->minRange, beams->maxRange),
                    beams->origin.empty() ? "" : "stated", hasEffects ? "its own" : "",
                    !hasEffects                                       ? ""
                    : value.valueOf("intensity_from").text != "scans" ? "estimate"
                                                                      : "from scans"});
  }
  return rows;
}

Rows corruptionRows() {
  Rows rows;
  for (const std::string& name : corruptionNames()) rows.push_back({name, corruptionSummary(name)});
  return rows;
}

Rows ontologyRows() {
  Rows rows;
  for (const std::vector<std::string>& file : fileRows("labels")) {
    if (readYaml(file.back()).find("classes") == nullptr) continue;
    const Ontology ontology = readOntology(file.back());
    rows.push_back({file.front(), fmt::format("{} classes", ontology.classes.size())});
  }
  return rows;
}

Rows materialRows() {
  Rows rows;
  for (const Material& m : readMaterials(resourceFolder() / "labels" / "materials.yaml").materials) {
    rows.push_back({m.name, fmt::format("reflectance {:.2f} at 905 nm; {}", m.reflectance, m.source)});
  }
  return rows;
}

// Returns the names and files of the scenes. Leaves out scenes without objects, such as `empty`, to which programs add
// objects.
Rows sceneRows() {
  Rows rows = fileRows("scenes");
  std::erase_if(rows, [](const auto& row) {
    try {
      const Value root = readYaml(row.back());
      const Value* const objects = root.find("objects");
      return objects == nullptr || objects->items.empty();
    } catch (const InputError&) {
      return false;  // an environment variable in the file is not set: list the scene
    }
  });
  return rows;
}

// Prints the devices that can compute and draw with OpenGL. Opens each device for a moment to test it.
void printDevices() {
  Rows rows;
  bool anyUsable = false;
  for (const FoundDevice& device : findDevices()) {
    anyUsable = anyUsable || device.usable;
    rows.push_back({device.name, device.usable
                                     ? device.driver + (device.software ? ", in software on the processor" : "")
                                     : "cannot be used: " + device.driver});
  }
  printText("devices:\n{}", rows.empty() ? "  none\n" : formatTable(rows));
  if (!anyUsable) return;
  const std::string named = namedDevice();
  printText(
      "\nThe program takes {}: the depth camera draws with it, and `particle: {{backend: gl}}` computes with it.\n",
      named.empty() ? "the first usable device, or the device that SCANMILL_GL_DEVICE names"
                    : fmt::format("the device '{}', which SCANMILL_GL_DEVICE names", named));
}

}  // namespace

int runList(const std::vector<std::string>& arguments) {
  CommandOptions options("list");
  const Arguments parsed = parseArguments(
      options, arguments, "  scanmill list\n  scanmill list effects\n  scanmill list footprint   # one of them\n");
  const std::string kind = !parsed.has("input") ? "" : parsed.positional("KIND");  // empty: all kinds
  if (printNamed("effect", effects(), kind) || printNamed("format", formats(), kind) ||
      printNamed("method", methods(), kind)) {
    return 0;
  }
  const std::vector<std::pair<std::string, Rows (*)()>> kinds{
      {"methods", [] { return entryRows(methods()); }},
      {"sensors", sensorRows},
      {"effects", [] { return entryRows(effects()); }},
      {"corruptions", corruptionRows},
      {"formats", [] { return entryRows(formats()); }},
      {"layouts", [] { return entryRows(layouts()); }},
      {"inputs", inputRows},
      {"columns", columnRows},
      {"ontologies", ontologyRows},
      {"materials", materialRows},
      {"scenes", sceneRows},
      {"pipelines", [] { return fileRows("pipelines"); }},
  };
  constexpr const char* kDevices = "devices";  // devices are listed only on request, since opening them takes time
  std::vector<std::string> names{kDevices};
  for (const auto& [name, rows] : kinds) names.push_back(name);
  for (const EffectEntry& entry : effects()) names.emplace_back(entry.name);
  if (!kind.empty() && std::ranges::find(names, kind) == names.end()) {
    throw InputError(
        fmt::format("list: there is no kind, effect, format or method '{}'{}", kind, suggestion(kind, names)));
  }
  for (const auto& [name, rows] : kinds) {
    if (kind.empty() || kind == name) printText("{}:\n{}", name, formatTable(rows()));
  }
  if (kind == kDevices) printDevices();
  if (kind == "sensors") {
    printText(
        "\norigins 'stated': the file says where beams start; otherwise they start at the sensor's origin.\n"
        "effects 'its own': the file says what the sensor's receiver makes of its hits; `effects: sensor` uses it.\n"
        "intensity 'estimate': the curve follows a manual and estimates, and was not compared with scans of the "
        "sensor.\n"
        "A pipeline may change any key beside `preset`, such as columns and rate_hz.\n");
  }
  if (kind == "methods") printCapabilities();
  if (kind == "methods") printKeys(methods());
  if (kind == "effects") printKeys(effects());
  if (kind == "formats") printKeys(formats());
  if (kind == "inputs") printElements();
  return 0;
}

}  // namespace scanmill
