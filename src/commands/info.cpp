#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <set>

#include "assets/asset.h"
#include "assets/meshes/gltf/reader.h"
#include "base/file.h"
#include "base/short_text.h"
#include "base/terminal.h"
#include "commands/arguments.h"
#include "commands/info_sensor.h"
#include "commands/table.h"
#include "config/file_kind.h"
#include "dataset/manifest.h"
#include "dataset/reader.h"
#include "dataset/recording.h"
#include "dataset/scan_store.h"
#include "formats/cloud_file.h"
#include "imports/scan_folder.h"
#include "pipeline/checks/warnings.h"
#include "pipeline/read/pipeline.h"
#include "scene/scene.h"
#include "scenefile/part_traits.h"
#include "scenefile/scene_file.h"
#include "town/map.h"

namespace scanmill {

namespace {

void printDataset(const std::filesystem::path& folder) {
  std::map<std::uint32_t, std::string> undescribed;
  const Manifest m = readManifest(folder, undescribed);
  printText("dataset {}: {} samples, columns {}{}\n", oneLine(m.name), m.samples.size(),
            oneLine(fmt::format("{}", fmt::join(m.columns, ", "))), m.organised ? ", organised" : "");
  printText("made by scanmill {}, seed {} (of the noise; seeds of scenes are in the samples' names)\n\n",
            oneLine(m.programVersion), m.seed);
  Rows shards{{"shard", "split", "samples", "size"}};
  for (const ShardRecord& s : m.shards) {
    shards.push_back({s.file, s.split, grouped(s.samples), shortBytes(static_cast<double>(s.bytes))});
  }
  printText("{}\n", formatTable(shards));
  Rows sensors{{"sensor", "model", "rings", "columns", "method"}};
  for (const SensorRecord& s : m.sensors) {
    std::set<std::string> usedMethods;
    for (const SampleRecord& sample : m.samples) {
      for (const ScanRecord& scan : sample.scans) {
        if (scan.sensor == s.name) usedMethods.insert(scan.method);
      }
    }
    sensors.push_back({s.name, s.beams.model, std::to_string(s.beams.rings), std::to_string(s.beams.columns),
                       fmt::format("{}", fmt::join(usedMethods, ", "))});
  }
  printText("{}\n", formatTable(sensors));
  std::map<std::uint16_t, std::uint64_t> perClass;
  std::uint64_t points = 0;
  std::uint64_t beams = 0;
  std::uint64_t unresolved = 0;
  for (const SampleRecord& sample : m.samples) {
    for (const ScanRecord& scan : sample.scans) {
      points += scan.points;
      beams += scan.beams;
      unresolved += scan.unresolved;
      for (const auto& [id, count] : scan.pointsPerClass) perClass[id] += count;
    }
  }
  Rows classes{{"class", "id", "points", "share"}};
  for (const auto& [id, count] : perClass) {
    const SemanticClass* c = m.ontology.find(id);
    classes.push_back({c == nullptr ? "?" : c->name, std::to_string(id), grouped(count),
                       percent(static_cast<double>(count), static_cast<double>(points))});
  }
  printText("{}\n", formatTable(classes));
  printText("{} points of {} beams ({})\n", grouped(points), grouped(beams),
            percent(static_cast<double>(points), static_cast<double>(beams)));
  if (unresolved > 0) {
    printText("the method gave up {} beams ({}): they count neither as hits nor as misses\n", grouped(unresolved),
              percent(static_cast<double>(unresolved), static_cast<double>(beams)));
  }
  for (const FormatRecord& f : m.formats) {
    printText("format {} (.{}): {}\n", f.name, f.suffix,
              f.maxErrorMetres > 0 ? fmt::format("positions within {:.3g} mm", f.maxErrorMetres * 1000) : "lossless");
  }
  printText("\nmodelled and left out:\n");
  for (const ModelledItem& item : m.modelled) printText("  {}\n", oneLine(lineOf(item)));
  for (const auto& [shard, problem] : undescribed) warn(problem);
  if (undescribed.empty()) return;
  warn(
      fmt::format("the points and beams of {} of {} shards are not counted: `scanmill regenerate {}` makes the damaged "
                  "files again",
                  undescribed.size(), m.shards.size(), folder.string()));
}

struct Span {
  double low = INFINITY, high = -INFINITY;
  void add(double v) {
    if (std::isnan(v)) return;
    low = std::fmin(low, v);
    high = std::fmax(high, v);
  }
};

void printScan(const Scan& scan, const std::string& what) {
  printText("scan {}: {} points, {}\n\n", what, grouped(scan.size()),
            scan.organised ? fmt::format("organised {} rings x {} columns{}", scan.rings, scan.columns,
                                         scan.planes == 1 ? "" : fmt::format(" x {} returns", scan.planes))
                           : std::string("dense"));
  Rows rows{{"column", "min", "max"}};
  const auto add = [&](std::string_view name, std::string_view unit, const auto& at) {
    if (scan.size() == 0) return;
    Span span;
    for (std::size_t i = 0; i < scan.size(); ++i) span.add(static_cast<double>(at(i)));
    rows.push_back({withUnit(name, unit), fmt::format("{:.6g}", span.low), fmt::format("{:.6g}", span.high)});
  };
  add("x", "m", [&](std::size_t i) { return scan.position[i].x; });
  add("y", "m", [&](std::size_t i) { return scan.position[i].y; });
  add("z", "m", [&](std::size_t i) { return scan.position[i].z; });
  add("distance", "m", [&](std::size_t i) { return length(Vec3d(scan.position[i])); });
  visitColumns(scan, [&](std::string_view name, const auto& values) {
    const std::size_t index = columnIndex(name);
    add(name, index < kColumnCount ? kColumns[index].unit : "", [&](std::size_t i) { return values[i]; });
  });
  printText("{}", formatTable(rows));
}

void printScanFolder(const std::filesystem::path& folder, const ScanFolder& found) {
  printText("{} recorded scans in the layout {}{}\n", grouped(found.scans.size()), found.layout,
            found.ontology ? ", labelled with the classes of " + found.ontology->name : "");
  const FolderScan& middle = found.scans[found.scans.size() / 2];
  printText(
      "{}{}\n\n", found.scans.front().key,
      found.scans.size() == 1 ? "" : fmt::format(" to {}; the table shows {}", found.scans.back().key, middle.key));
  const std::filesystem::path whole = std::filesystem::absolute(middle.points);
  printScan(readFolderScan(middle), whole.lexically_relative(std::filesystem::absolute(folder)).string());
}

void printShard(const std::filesystem::path& file) {
  Rows rows{{"member", "bytes", "points"}};
  readTar(file, [&](const std::string& name, std::string_view bytes) {
    const std::size_t dot = name.rfind('.');
    const bool scan = dot != std::string::npos && formatBySuffix(name.substr(dot + 1)) != nullptr;
    const std::string place = file.string() + ": " + name;
    rows.push_back({name, grouped(bytes.size()), scan ? grouped(decodeMember(place, bytes).size()) : ""});
  });
  printText("shard {}\n\n{}", file.string(), formatTable(rows));
}

std::string sizeText(const Box& box) {
  const Vec3d size = box.high - box.low;
  return fmt::format("{:.5g} x {:.5g} x {:.5g}", size.x, size.y, size.z);
}

// Prints the first kMostObjects meshes that are placed, to reveal a wrong unit or axis. Each has one row, which shows
// its first copy.
void printObjects(const Scene& scene) {
  constexpr std::size_t kMostObjects = 30;
  std::map<std::uint32_t, std::uint64_t> placed;
  std::vector<const Instance*> firsts;
  for (const Instance& instance : scene.instances) {
    if (++placed[instance.mesh] == 1) firsts.push_back(&instance);
  }
  Rows rows{{"object", "size x, y, z (m)", "lowest z (m)", "triangles", "placed"}};
  for (std::size_t i = 0; i < std::min(firsts.size(), kMostObjects); ++i) {
    const Mesh& mesh = scene.meshes[firsts[i]->mesh];
    Box box;
    for (const Vec3f& p : mesh.positions) box.add(firsts[i]->worldFromMesh * Vec3d(p));
    if (box.empty()) continue;
    rows.push_back({firsts[i]->name, sizeText(box), fmt::format("{:.5g}", box.low.z), grouped(mesh.triangles.size()),
                    grouped(placed[firsts[i]->mesh])});
  }
  printText("\n{} meshes, placed {} times\n{}", grouped(scene.meshes.size()), grouped(scene.instances.size()),
            formatTable(rows));
  if (firsts.size() > kMostObjects) printText("and {} more meshes\n", grouped(firsts.size() - kMostObjects));
}

// Returns the bounds of the static instances, since moving instances may be far away before they appear. If no instance
// is static, returns the bounds of all instances.
Box boundsAtRest(const Scene& scene) {
  Box box;
  for (const Instance& instance : scene.instances) {
    if (instance.moves()) continue;
    for (const Vec3f& p : scene.meshes[instance.mesh].positions) box.add(instance.worldFromMesh * Vec3d(p));
  }
  return box.empty() ? scene.bounds() : box;
}

void printScene(const std::filesystem::path& file, std::uint64_t seed) {
  SceneOptions options;
  options.seed = seed;
  const Scene scene = readScene(file, options);
  const Box box = boundsAtRest(scene);
  printText("scene {}: {} triangles in memory, {} placed; {} instances, {} things\n", scene.name,
            grouped(scene.triangles()), grouped(scene.placedTriangles()), grouped(scene.instances.size()),
            grouped(scene.things()));
  printText("from [{:.2f}, {:.2f}, {:.2f}] to [{:.2f}, {:.2f}, {:.2f}] m; ontology {}\n", box.low.x, box.low.y,
            box.low.z, box.high.x, box.high.y, box.high.z, scene.ontology.name);
  if (scene.dropped.total() > 0) {
    printText("triangles left out: {} without area, {} with NaN or infinite corners, {} with indices out of range\n",
              grouped(scene.dropped.degenerate), grouped(scene.dropped.nonFinite), grouped(scene.dropped.outOfRange));
  }
  printObjects(scene);
  struct PerClass {
    std::uint64_t triangles = 0;
    std::set<std::uint32_t> instances;
  };
  std::map<std::uint16_t, PerClass> perClass;
  for (const Instance& instance : scene.instances) {
    const Mesh& mesh = scene.meshes[instance.mesh];
    for (const std::uint16_t s : mesh.surfaceOf) ++perClass[mesh.surfaces[s].semantic].triangles;
    for (const Surface& s : mesh.surfaces) {
      if (s.object != 0) perClass[s.semantic].instances.insert(instanceId(instance, s));
    }
  }
  Rows rows{{"class", "id", "triangles", "instances"}};
  for (const auto& [id, c] : perClass) {
    const SemanticClass* known = scene.ontology.find(id);
    rows.push_back({known == nullptr ? "?" : known->name, std::to_string(id), grouped(c.triangles),
                    c.instances.empty() ? "" : grouped(c.instances.size())});
  }
  printText("\n{}", formatTable(rows));
  Rows materials{{"material", "reflectance", "roughness", "metallic", "texture", "source"}};
  for (const Material& m : scene.materials) {
    materials.push_back({m.name, fmt::format("{:.3f}", m.reflectance), fmt::format("{:.2f}", m.roughness),
                         fmt::format("{:.0f}", m.metallic),
                         m.texture == nullptr ? ""
                         : m.alphaTested      ? "alpha"
                                              : "colour",
                         m.source});
  }
  printText("\n{}", formatTable(materials));
  if (!scene.rules.empty()) {
    Rows rules{{"rule", "matches", "gives", "triangles"}};
    for (const RuleUse& r : scene.rules) rules.push_back({r.where.text(), r.match, r.gives, grouped(r.decided)});
    printText("\n{}", formatTable(rules));
  }
  for (const std::string& line : sizeWarnings(scene)) warn(line);
  for (const std::string& line : ruleWarnings(scene)) warn(line);
}

void printClips(const std::filesystem::path& file) {
  const std::vector<gltf::Clip> clips = gltf::readClips(file);
  if (clips.empty()) return;
  Rows rows{{"animation", "from s", "to s"}};
  for (const gltf::Clip& c : clips)
    rows.push_back({c.name, fmt::format("{:.4g}", c.first), fmt::format("{:.4g}", c.last)});
  printText("\n{}", formatTable(rows));
  printText(
      "in a scene, `animation: {{clip: NAME}}` of the object plays an animation, and `time_s` holds it at that time\n");
}

// Prints the colours of triangles that rules of a scene can match, by material and texture. Similar colours share one
// row, which shows the most frequent of them.
void printColors(const Asset& asset) {
  constexpr std::size_t kMostColors = 12;  // greatest number of colours to print per material and texture
  using Counts = std::map<Rgb, std::uint64_t>;
  std::map<std::pair<std::string, std::string>, Counts> byMaterial;
  const auto count = [&](const AssetPart& part) {
    const PartTraits traits(part, {}, false);
    Counts& counts = byMaterial[{part.material, part.texture}];
    for (std::size_t t = 0; t < part.triangles.size(); ++t) ++counts[traits.at(t).color];
  };
  for (const AssetPart& part : asset.parts) count(part);
  for (const InstancedParts& instanced : asset.instanced) {
    for (const AssetPart& part : instanced.parts) count(part);
  }
  Rows rows{{"material", "texture", "color", "triangles"}};
  for (const auto& [names, counts] : byMaterial) {
    std::vector<std::pair<Rgb, std::uint64_t>> sorted(counts.begin(), counts.end());
    std::stable_sort(sorted.begin(), sorted.end(), [](const auto& a, const auto& b) { return a.second > b.second; });
    std::vector<std::pair<Rule, std::uint64_t>> groups;
    for (const auto& [color, triangles] : sorted) {
      TriangleTraits traits;
      traits.color = color;
      auto group =
          std::find_if(groups.begin(), groups.end(), [&](const auto& g) { return matchesTriangle(g.first, traits); });
      if (group == groups.end()) {
        if (groups.size() == kMostColors) continue;
        groups.emplace_back(Rule{}, 0);
        group = groups.end() - 1;
        group->first.colors = {color};
      }
      group->second += triangles;
    }
    for (const auto& [rule, triangles] : groups) {
      const Rgb& c = rule.colors.front();
      rows.push_back(
          {names.first, names.second, fmt::format("#{:02x}{:02x}{:02x}", c[0], c[1], c[2]), grouped(triangles)});
    }
  }
  printText("\n{}", formatTable(rows));
}

// A part of a 3D file in the list of its names.
struct ListedPart {
  std::string node, material, texture;
  std::uint64_t triangles = 0;  // as the file has them
  std::uint64_t placed = 0;     // number of copies that the file places
};

// Prints the names that rules can match. If there are more than kMostParts parts, prints their sums by material and
// texture, and only the parts with most triangles unless `all` is set.
void printParts(std::vector<ListedPart> parts, bool instanced, bool all) {
  constexpr std::size_t kMostParts = 30;
  const auto most = [](const auto& a, const auto& b) { return a.triangles > b.triangles; };
  const std::size_t listed = all ? parts.size() : std::min(parts.size(), kMostParts);
  if (parts.size() > kMostParts) {
    struct Sum {
      std::uint64_t triangles = 0, parts = 0;
    };
    std::map<std::pair<std::string, std::string>, Sum> sums;  // by material and texture
    for (const ListedPart& p : parts) {
      Sum& sum = sums[{p.material, p.texture}];
      sum.triangles += p.triangles * p.placed;
      ++sum.parts;
    }
    std::vector<std::pair<std::pair<std::string, std::string>, Sum>> sorted(sums.begin(), sums.end());
    std::stable_sort(sorted.begin(), sorted.end(),
                     [&](const auto& a, const auto& b) { return most(a.second, b.second); });
    Rows rows{{"material", "texture", "triangles", "parts"}};
    for (const auto& [names, sum] : sorted) {
      rows.push_back({names.first, names.second, grouped(sum.triangles), grouped(sum.parts)});
    }
    printText("{}\n", formatTable(rows));
    std::stable_sort(parts.begin(), parts.end(), most);
  }
  Rows rows{{"node", "material", "texture", "triangles", "placed"}};
  for (std::size_t i = 0; i < listed; ++i) {
    const ListedPart& p = parts[i];
    rows.push_back({p.node, p.material, p.texture, grouped(p.triangles), grouped(p.placed)});
  }
  for (std::vector<std::string>& row : rows) row.resize(instanced ? 5 : 4);
  printText("{}\n", formatTable(rows));
  if (listed < parts.size()) printText("... and {} more parts: --all lists them\n\n", grouped(parts.size() - listed));
}

void printAsset(const std::filesystem::path& file, const AssetOptions& options, bool all) {
  constexpr std::size_t kMostNodes = 20;
  const Asset asset = readAsset(file, options);
  struct Node {
    std::string name;
    Box box;
  };
  std::vector<ListedPart> parts;
  std::uint64_t triangles = 0;
  std::uint64_t notFinite = 0;
  Box whole;
  std::map<std::uint32_t, Node> byIndex;
  const auto add = [&](const AssetPart& part, const std::vector<Affine>& places) {
    parts.push_back({part.node, part.material, part.texture, part.triangles.size(), places.size()});
    triangles += part.triangles.size() * places.size();
    for (const Triangle& t : part.triangles) {
      const auto bad = [&](std::uint32_t corner) { return !isFinite(part.positions[corner]); };
      notFinite += std::any_of(t.begin(), t.end(), bad) ? 1 : 0;
    }
    Node& node = byIndex[part.nodeIndex];
    node.name = part.node;
    for (const Vec3f& p : part.positions) {
      if (!isFinite(p)) continue;
      for (const Affine& place : places) {
        node.box.add(place * Vec3d(p));
        whole.add(place * Vec3d(p));
      }
    }
  };
  for (const AssetPart& part : asset.parts) add(part, {Affine{{}, asset.origin}});
  for (const InstancedParts& instanced : asset.instanced) {
    for (const AssetPart& part : instanced.parts) add(part, instanced.assetFromParts);
  }
  printText("asset {}: {} triangles; labelling rules of a scene can match these names\n\n", file.string(),
            grouped(triangles));
  printParts(std::move(parts), !asset.instanced.empty(), all);
  if (notFinite > 0 || asset.dropped.outOfRange > 0) {
    warn(fmt::format("{}: scenes leave out {} triangles with NaN or infinite corners and {} with indices out of range",
                     file.string(), grouped(notFinite), grouped(asset.dropped.outOfRange)));
  }
  std::vector<Node> nodes;
  for (auto& [index, node] : byIndex) {
    if (!node.box.empty()) nodes.push_back(std::move(node));
  }
  if (nodes.empty()) return;
  printText("from [{:.8g}, {:.8g}, {:.5g}] to [{:.8g}, {:.8g}, {:.5g}]: {} m\n", whole.low.x, whole.low.y, whole.low.z,
            whole.high.x, whole.high.y, whole.high.z, sizeText(whole));
  printText(
      "read with unit: {:g} ({}) and up: {}; change them by --unit and --up here, and by the keys `unit` and "
      "`up` of the object in a scene\n",
      options.metresPerUnit,
      asset.statedUnit > 0 ? fmt::format("times {:g} m per unit, as stated by the file or its kind", asset.statedUnit)
                           : "m per unit",
      options.up
          ? std::string(1, asset.up)
          : fmt::format("{} ({})", asset.up,
                        asset.upDeclared ? "stated by the file or its kind" : "assumed, the file does not state it"));
  if (asset.ownMiddle) printText("z up, x east and y north around {}\n", asset.system);
  if (options.textures) printColors(asset);
  if (nodes.size() < 2) return;
  const auto diagonal = [](const Node& n) { return length(n.box.high - n.box.low); };
  std::stable_sort(nodes.begin(), nodes.end(), [&](const Node& a, const Node& b) { return diagonal(a) > diagonal(b); });
  Rows sizes{{"node", "size x, y, z (m)", "lowest z (m)"}};
  const std::size_t listed = all ? nodes.size() : std::min(nodes.size(), kMostNodes);
  for (std::size_t i = 0; i < listed; ++i) {
    sizes.push_back({nodes[i].name, sizeText(nodes[i].box), fmt::format("{:.5g}", nodes[i].box.low.z)});
  }
  printText("\n{}", formatTable(sizes));
  if (listed < nodes.size()) printText("... and {} smaller nodes\n", grouped(nodes.size() - listed));
}

void printYaml(const std::filesystem::path& file, std::uint64_t seed) {
  const Value value = readYaml(file);
  if (value.find("lasers") != nullptr) return printCalibration(file);
  switch (fileKind(value)) {
    case FileKind::Pipeline: {
      runPlan({file.string()});
      return;
    }
    case FileKind::Scene:
      return printScene(file, seed);
    case FileKind::Sensor:
      return printSensor(value);
    case FileKind::Ontology:
    case FileKind::Materials:
      throw InputError({file.string()},
                       "is a list of classes or materials, which any editor shows: `scanmill list "
                       "ontologies` and `scanmill list materials` name those of the program");
    case FileKind::Unknown:
      break;
  }
  throw InputError(
      {file.string()},
      "is of no known kind: a scene has the key `objects`, a sensor `elevation_deg`, a pipeline `sensors`, an ontology "
      "`classes`, a material table `materials`, a calibration `lasers`");
}

AssetOptions assetOptions(const Arguments& parsed) {
  AssetOptions options;
  options.textures = parsed.has("colors");
  options.metresPerUnit = parsed.number("unit", 1e-9, 1e9);
  options.unitStated = parsed.has("unit");
  if (parsed.has("up")) {
    const std::string up = parsed.text("up");
    if (up != "x" && up != "y" && up != "z") throw InputError(fmt::format("--up must be x, y or z, not '{}'", up));
    options.up = up[0];
  }
  options.allowOutside = parsed.has("allow-outside");
  options.leaveOutMissing = parsed.has("leave-out-missing");
  return options;
}

}  // namespace

int runInfo(const std::vector<std::string>& arguments) {
  CommandOptions options("info");
  cxxopts::OptionAdder add = options.add_options();
  add("unit", "metres per unit of a 3D file", textValue()->default_value("1"));
  add("up", "up axis of a 3D file: x, y or z (default: as the file or its kind says)", textValue());
  add("seed", "seed of a procedural scene", cxxopts::value<std::uint64_t>()->default_value("1"), "N");
  add("colors", "list the colours of a 3D file's triangles, which labelling rules can match");
  add("all", "list all parts and nodes of a 3D file, however many");
  add("allow-outside", "allow a glTF or OBJ file to name files outside its folder");
  add("leave-out-missing", "go on without models and meshes that a world names and that are missing");
  addInputLimit(options);
  const Arguments parsed =
      parseArguments(options, arguments,
                     "  scanmill info out/quickstart\n"
                     "  scanmill info out/quickstart/train/train-000000.tar\n"
                     "  scanmill info scenes/street.yaml\n"
                     "  scanmill info pipelines/sensors/os1_128.yaml\n"
                     "  scanmill info SemanticKITTI/sequences/08      # recorded scans: a folder or one file\n"
                     "  scanmill info out/passes      # a recording, or one of its EXR images\n"
                     "  scanmill info model.glb       # names that labelling rules can match, sizes, animations\n"
                     "  scanmill info model.obj --unit 0.01 --up y\n"
                     "  scanmill info metadata.json   # a sensor's calibration: Ouster's, Velodyne's or Hesai's\n");
  if (parsed.help) return 0;
  const InputLimitFactor limits(inputLimit(parsed));
  const InputBudget budget;
  const std::filesystem::path file =
      parsed.fileOrName("FILE|DIR", {"scenes", "pipelines/sensors", "pipelines", "labels"});
  std::string suffix = file.extension().string();
  if (!suffix.empty()) suffix.erase(0, 1);
  std::error_code failure;
  if (!std::filesystem::exists(file, failure)) {
    throw InputError({file.string()}, failure ? "cannot be read: " + failure.message() : "does not exist");
  }
  if (std::filesystem::is_directory(file) && recordingIn(file)) {
    printRecording(file);
  } else if (file.filename() == "recording.json") {
    printRecording(file.has_parent_path() ? file.parent_path() : ".");
  } else if (suffix == "exr") {
    printExr(file);
  } else if (std::filesystem::is_directory(file)) {
    const bool dataset = std::filesystem::exists(file / "manifest.json", failure);
    if (const auto recorded = dataset ? std::nullopt : scanFolderIn(file)) {
      printScanFolder(file, *recorded);
      return 0;
    }
    if (!dataset) const ScanStore refused(file);  // throws; the message states what a folder may contain
    printDataset(file);
  } else if (file.filename() == "manifest.json") {
    printDataset(file.parent_path());
  } else if (suffix == "tar") {
    printShard(file);
  } else if (isCalibration(file)) {
    printCalibration(file);
  } else if (isMap(file)) {
    throw InputError({file.string()},
                     "is a map: name it in a scene by `town: {map: FILE}`, and give the scene to info");
  } else if (suffix == "yaml" || suffix == "yml") {
    printYaml(file, parsed.options["seed"].as<std::uint64_t>());
  } else if (formatBySuffix(suffix) != nullptr) {
    printScan(decodeMember(file.string(), readFile(file)), file.string());
  } else if (suffix == "bin" || suffix == "npz") {
    printScan(scanOf(readCloud(file), file.string()), file.string());
  } else {
    printAsset(file, assetOptions(parsed), parsed.has("all"));
    if (suffix == "glb" || suffix == "gltf") printClips(file);
  }
  return 0;
}

}  // namespace scanmill
