#include "commands/info.h"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "base/file.h"
#include "base/short_text.h"
#include "base/terminal.h"
#include "commands/arguments.h"
#include "commands/table.h"
#include "config/resources.h"
#include "dataset/card.h"
#include "dataset/names.h"
#include "dataset/reader.h"
#include "dataset/recording.h"
#include "dataset/scan_store.h"
#include "formats/cloud_file.h"
#include "formats/format.h"
#include "imports/scan_folder.h"
#include "passes/exr/exr_file.h"
#include "pipeline/read/effects.h"
#include "sensors/sensor.h"
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
    shards.push_back({s.file, s.split, grouped(s.samples), shortBytes(s.bytes)});
  }
  printText("{}\n", formatTable(shards));
  ScanTotals totals = totalsOf(m);
  Rows sensors{{"sensor", "model", "rings", "columns", "method"}};
  for (const SensorRecord& s : m.sensors) {
    sensors.push_back({s.name, s.beams.model, std::to_string(s.beams.rings), std::to_string(s.beams.columns),
                       fmt::format("{}", fmt::join(totals.methods[s.name], ", "))});
  }
  printText("{}\n", formatTable(sensors));
  Rows classes{{"class", "id", "points", "share"}};
  for (const auto& [id, count] : totals.perClass) {
    const SemanticClass* c = m.ontology.find(id);
    classes.push_back(
        {c == nullptr ? "?" : c->name, std::to_string(id), grouped(count), percent(count, totals.points)});
  }
  printText("{}\n", formatTable(classes));
  printText("{} points of {} beams ({})\n", grouped(totals.points), grouped(totals.beams),
            percent(totals.points, totals.beams));
  if (totals.unresolved > 0) {
    printText("the method gave up {} beams ({}): they count neither as hits nor as misses\n",
              grouped(totals.unresolved), percent(totals.unresolved, totals.beams));
  }
  for (const FormatRecord& f : m.formats) {
    printText("format {} (.{}): {}\n", f.name, f.suffix,
              f.maxErrorMetres > 0 ? fmt::format("positions within {:.3g} mm", f.maxErrorMetres * 1000) : "lossless");
  }
  printText("\nmodelled and left out:\n");
  for (const ModelledItem& item : m.modelled) printText("  {}\n", oneLine(lineOf(item)));
  for (const auto& [shard, problem] : undescribed) warn(problem);
  if (undescribed.empty()) return;
  warn("the points and beams of {} of {} shards are not counted: `scanmill verify {}` says how to make them again",
       undescribed.size(), m.shards.size(), folder.string());
}

// Prints the size of a scan, and the least and greatest value of each column. `what`: the scan's name.
void printScan(const Scan& scan, const std::string& what) {
  printText("scan {}: {} points, {}\n\n", what, grouped(scan.size()),
            scan.organised ? fmt::format("organised {} rings x {} columns{}", scan.rings, scan.columns,
                                         scan.planes == 1 ? "" : fmt::format(" x {} returns", scan.planes))
                           : std::string("dense"));
  Rows rows{{"column", "min", "max"}};
  const auto addRow = [&](std::string_view name, std::string_view unit, const auto& valueOfPoint) {
    if (scan.size() == 0) return;
    double low = INFINITY, high = -INFINITY;
    for (std::size_t i = 0; i < scan.size(); ++i) {
      const auto value = static_cast<double>(valueOfPoint(i));
      low = std::fmin(low, value);  // fmin() and fmax() leave out NaN
      high = std::fmax(high, value);
    }
    rows.push_back({withUnit(name, unit), fmt::format("{:.6g}", low), fmt::format("{:.6g}", high)});
  };
  addRow("x", "m", [&](std::size_t i) { return scan.position[i].x; });
  addRow("y", "m", [&](std::size_t i) { return scan.position[i].y; });
  addRow("z", "m", [&](std::size_t i) { return scan.position[i].z; });
  addRow("distance", "m", [&](std::size_t i) { return length(Vec3d(scan.position[i])); });
  visitColumns(scan, [&](std::string_view name, const auto& values) {
    const std::size_t index = columnIndex(name);
    addRow(name, index < kColumnCount ? kColumns[index].unit : "", [&](std::size_t i) { return values[i]; });
  });
  printText("{}", formatTable(rows));
}

// Prints the number of the folder's scans and the middle scan.
void printScanFolder(const std::filesystem::path& folder, const ScanFolder& recorded) {
  printText("{} recorded scans in the layout {}{}\n", grouped(recorded.scans.size()), recorded.layout,
            recorded.ontology ? ", labelled with the classes of " + recorded.ontology->name : "");
  const FolderScan& middle = recorded.scans[recorded.scans.size() / 2];
  printText("{}{}\n\n", recorded.scans.front().key,
            recorded.scans.size() == 1
                ? ""
                : fmt::format(" to {}; the table shows {}", recorded.scans.back().key, middle.key));
  const std::filesystem::path points = std::filesystem::absolute(middle.points);
  printScan(readFolderScan(middle), points.lexically_relative(std::filesystem::absolute(folder)).string());
}

void printShard(const std::filesystem::path& file) {
  Rows rows{{"member", "bytes", "points"}};
  readTar(file, [&](const std::string& name, std::string_view bytes) {
    const std::size_t dot = name.rfind('.');
    const bool isScan = dot != std::string::npos && formatBySuffix(name.substr(dot + 1)) != nullptr;
    const auto countPoints = [&] { return decodeMember(file.string() + ": " + name, bytes).size(); };
    rows.push_back({name, grouped(bytes.size()), isScan ? grouped(countPoints()) : ""});
  });
  printText("shard {}\n\n{}", file.string(), formatTable(rows));
}

void printRecording(const std::filesystem::path& folder) {
  const Recording r = readRecording(folder, recordingIn(folder).value_or(RecordingKind::Hits));
  std::uintmax_t bytes = 0;
  std::uint64_t images = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (!entry.is_regular_file()) continue;
    bytes += entry.file_size();
    images += entry.path().extension() == ".exr" ? 1 : 0;
  }
  printText("recording of {}{}: {} images, {}\n\n", nameOf(r.kind),
            r.programVersion.empty() ? std::string(", not made by scanmill")
                                     : fmt::format(", made by {}, scanmill {}", r.method, r.programVersion),
            grouped(images), shortBytes(bytes));
  Rows sensors{{"sensor", "rings", "columns"}};
  for (const RecordedSensor& s : r.sensors) {
    sensors.push_back({s.name, std::to_string(s.rings), std::to_string(s.columns)});
  }
  printText("{}\n", formatTable(sensors));
  Rows sequences{{"scene", "seed", "trajectory", "frames", "materials"}};
  for (const RecordedSequence& s : r.sequences) {
    sequences.push_back({s.scene, std::to_string(s.seed), s.trajectory, std::to_string(s.frames),
                         std::to_string(r.materials[s.materials].size())});
  }
  printText("{}\n", formatTable(sequences));
  if (r.ontology.classes.empty()) {
    printText("no ontology: name one in the pipeline by the key `labels`\n");
  } else {
    printText("ontology {}: {} classes\n", r.ontology.name, r.ontology.classes.size());
  }
  for (const ModelledItem& item : r.modelled) printText("  {}\n", oneLine(lineOf(item)));
  printText("next: scanmill generate PIPELINE -o DIR --from-{} {}\n", nameOf(r.kind), folder.string());
}

void printExr(const std::filesystem::path& file) {
  const ExrReader exr(file);
  printText("{}: {} x {} pixels\n\n", file.filename().string(), exr.width(), exr.height());
  Rows rows{{"channel", "type"}};
  for (const ExrChannel& c : exr.channels()) rows.push_back({c.name, std::string(exrTypeName(c.type))});
  printText("{}\n", formatTable(rows));
  const auto& channels = exr.channels();
  if (std::ranges::any_of(channels, [](const ExrChannel& c) { return c.name == "range"; })) {
    printText("hits: an image row for each ring, an image column for each column of the sensor\n");
    return;
  }
  try {
    const Camera c = readCamera(exr);
    const Vec3d& t = c.worldFromCamera.translation;
    const Vec3d forward = toMatrix(c.worldFromCamera.rotation).z;
    printText("camera {}: {:.2f} x {:.2f} degrees, focal length {:.2f} x {:.2f} px, principal point {:.2f}, {:.2f}\n",
              c.name.empty() ? "without a name" : c.name, degrees(c.horizontalField()), degrees(c.verticalField()),
              c.fx, c.fy, c.cx, c.cy);
    printText("at {:.3f}, {:.3f}, {:.3f} m, looking along {:.4f}, {:.4f}, {:.4f}\n", t.x, t.y, t.z, forward.x,
              forward.y, forward.z);
  } catch (const InputError& e) {
    printText("the image cannot be used as a pass: {}\n", e.what());
  }
}

void printBeams(const BeamTable& beams) {
  Rows rows{{"ring", "elevation deg", "azimuth offset deg", "firing us"}};
  const bool ownOrigins = !beams.originLeft.empty() || !beams.originUp.empty();
  if (ownOrigins) rows.front().insert(rows.front().end(), {"origin left mm", "origin up mm"});
  for (std::uint32_t r = 0; r < beams.rings; ++r) {
    // Returns the value of ring `r`; 0 if `values` is too short.
    const auto ofRing = [&](const std::vector<double>& values) { return r < values.size() ? values[r] : 0.0; };
    rows.push_back({std::to_string(r), fmt::format("{:.3f}", degrees(ofRing(beams.elevation))),
                    fmt::format("{:.3f}", degrees(ofRing(beams.azimuthOffset))),
                    fmt::format("{:.3f}", ofRing(beams.firingOffset) * 1e6)});
    if (!ownOrigins) continue;
    rows.back().push_back(fmt::format("{:.1f}", ofRing(beams.originLeft) * 1000));
    rows.back().push_back(fmt::format("{:.1f}", ofRing(beams.originUp) * 1000));
  }
  printText("{}", formatTable(rows));
}

void printSensor(const Value& sensor) {
  checkSensorEffects(sensor, nullptr);
  const auto beams = makeBeams(sensor);
  printText("sensor {}: {} rings x {} columns, {:.3g} revolutions/s, {}, ring 0 is the {} beam\nsource: {}\n",
            beams->model, beams->rings, beams->columns * beams->sectors, 1 / (beams->period * beams->sectors),
            beams->clockwise ? "clockwise" : "counter-clockwise", beams->topDown ? "top" : "bottom", beams->source);
  printText("range {:.3g} to {:.3g} m; column 0 at {:.2f} deg; beams start {:.2f} mm off the axis\n\n", beams->minRange,
            beams->maxRange, degrees(beams->firstAzimuth), beams->originOffset * 1000);
  if (beams->sectors > 1) printText("a turn is made in {} sectors\n\n", beams->sectors);
  if (beams->onCones()) return printBeams(*beams);
  const std::array<double, 2> field = fieldOf(*beams);
  printText("directions differ from beam to beam in a field of {:.3g} x {:.3g} deg\n", field[0], field[1]);
}

void printYaml(const std::filesystem::path& file, std::uint64_t seed) {
  const Value value = readYaml(file);
  switch (fileKind(value)) {
    case FileKind::Pipeline:
      runPlan({file.string()});
      return;
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
      "`classes`, a material table `materials`");
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

// Prints a folder: a recording, a dataset or a folder of recorded scans.
void printFolder(const std::filesystem::path& folder) {
  if (recordingIn(folder)) return printRecording(folder);
  if (pathExists(folder / kManifestName)) return printDataset(folder);
  if (const auto recorded = scanFolderIn(folder)) return printScanFolder(folder, *recorded);
  const ScanStore refused(folder);  // throws; the message states what a folder may contain
}

// Prints a file. Its name and, for some suffixes, its contents determine its kind.
void printFile(const std::filesystem::path& file, const Arguments& parsed) {
  const std::string name = file.filename().string();
  const std::filesystem::path folder = file.has_parent_path() ? file.parent_path() : ".";
  const std::string suffix = file.extension().empty() ? "" : file.extension().string().substr(1);
  if (name == "recording.json") return printRecording(folder);
  if (name == kManifestName) return printDataset(folder);
  if (suffix == "exr") return printExr(file);
  if (suffix == "tar") return printShard(file);
  if (isMap(file)) {
    throw InputError({file.string()},
                     "is a map: name it in a scene by `town: {map: FILE}`, and give the scene to info");
  }
  if (suffix == "yaml" || suffix == "yml") return printYaml(file, parsed.options["seed"].as<std::uint64_t>());
  if (formatBySuffix(suffix) != nullptr) return printScan(decodeMember(file.string(), readFile(file)), file.string());
  if (suffix == "bin" || suffix == "npz") return printScan(scanOf(readCloud(file), file.string()), file.string());
  printAsset(file, assetOptions(parsed));
}

}  // namespace

std::array<double, 2> fieldOf(const BeamTable& beams) {
  std::vector<double> azimuths;
  double lowest = kPi / 2;
  double highest = -kPi / 2;
  for (const Vec3d& d : beams.direction) {
    const double elevation = std::asin(std::clamp(d.z, -1.0, 1.0));
    lowest = std::min(lowest, elevation);
    highest = std::max(highest, elevation);
    azimuths.push_back(std::atan2(d.y, d.x));
  }
  std::ranges::sort(azimuths);
  double largestGap = azimuths.front() + 2 * kPi - azimuths.back();
  for (std::size_t i = 1; i < azimuths.size(); ++i) largestGap = std::max(largestGap, azimuths[i] - azimuths[i - 1]);
  return {largestGap < radians(5) || beams.sectors > 1 ? 360 : degrees(2 * kPi - largestGap),
          degrees(highest - lowest)};
}

int runInfo(const std::vector<std::string>& arguments) {
  CommandOptions options("info");
  options.add("unit", "metres per unit of a 3D file", textValue()->default_value("1"));
  options.add("up", "up axis of a 3D file: x, y or z (default: as the file or its kind says)", textValue());
  options.add("seed", "seed of a procedural scene", cxxopts::value<std::uint64_t>()->default_value("1"), "N");
  options.add("colors", "list the colours of a 3D file's triangles, which labelling rules can match");
  options.add("allow-outside", "allow a glTF or OBJ file to name files outside its folder");
  options.add("leave-out-missing", "go on without models and meshes that a world names and that are missing");
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
                     "  scanmill info model.obj --unit 0.01 --up y\n");
  const InputBudget budget;
  const std::filesystem::path file =
      parsed.fileOrName("FILE|DIR", {"scenes", "pipelines/sensors", "pipelines", "labels"});
  std::error_code failure;
  if (!std::filesystem::exists(file, failure)) {
    throw InputError({file.string()}, failure ? "cannot be read: " + failure.message() : "does not exist");
  }
  if (std::filesystem::is_directory(file)) {
    printFolder(file);
  } else {
    printFile(file, parsed);
  }
  return 0;
}

}  // namespace scanmill
