#include "viewer/picture.h"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "base/error.h"
#include "base/file.h"
#include "base/terminal.h"
#include "commands/arguments.h"
#include "commands/picture_options.h"
#include "config/text.h"
#include "dataset/recording.h"
#include "dataset/scan_source.h"
#include "scene/scene.h"
#include "scenefile/scene_file.h"
#include "viewer/contact_sheet.h"
#include "viewer/frames/scene_lookup.h"
#include "viewer/pass_picture.h"

namespace scanmill {

namespace {

constexpr double kFarthestPlace = 1e5;  // m, from the sensor
constexpr double kMostFactor = 100;

// Reads X,Y,Z.
Vec3d readPlace(const std::string& text) {
  const auto place = readNumbers<double, 3>(text);
  if (place && std::ranges::all_of(*place, [](double value) { return std::abs(value) <= kFarthestPlace; })) {
    return {(*place)[0], (*place)[1], (*place)[2]};
  }
  throw InputError(
      fmt::format("--at is X,Y,Z in m in the sensor's frame (x forward, y left, z up), at most {} each, such as "
                  "8,-3.5,-1, not '{}'",
                  kFarthestPlace, text));
}

std::optional<CloseUp> readCloseUp(const Arguments& parsed) {
  const bool at = parsed.options.count("at") > 0;
  if (at != (parsed.options.count("within") > 0)) {
    throw InputError("a close-up takes both --at X,Y,Z (where, in m) and --within R (so far around it, in m)");
  }
  if (!at) return {};
  if (parsed.options.count("range-image") > 0) {
    throw InputError("--at looks at points in space; a range image has no place to look at: leave one of them out");
  }
  constexpr double kLeast = 0.01;
  const double within = parsed.options["within"].as<double>();
  if (!(within >= kLeast && within <= kFarthestPlace)) {
    throw InputError(fmt::format("--within must be from {} to {} m, not {}", kLeast, kFarthestPlace, within));
  }
  return CloseUp{readPlace(parsed.options["at"].as<std::string>()), within};
}

// Returns the folder's or the file's name: "ray_tracing" for out/ray_tracing/.
std::string shortName(const std::filesystem::path& path) {
  const std::filesystem::path normal = path.lexically_normal();
  return normal.has_filename() ? normal.stem().string() : normal.parent_path().filename().string();
}

Image drawOver(ScanSource& source, const Arguments& parsed, const std::filesystem::path& file,
               const PictureOptions& options) {
  std::vector<NamedScan> scans;
  scans.push_back({shortName(file), std::move(source.scan)});
  for (const std::string& other : parsed.options["over"].as<std::vector<std::string>>()) {
    scans.push_back(
        {shortName(other), findScan(other, textOption(parsed, "sample"), textOption(parsed, "sensor")).scan});
  }
  return drawOverlay(scans, options, source.title);
}

}  // namespace

int runPicture(const std::vector<std::string>& arguments) {
  const Command& command = commandNamed("picture");
  cxxopts::Options options = describe(command);
  const auto text = [](const char* fallback) { return cxxopts::value<std::string>()->default_value(fallback); };
  options.add_options()("o,out", "the picture, a PNG", cxxopts::value<std::string>(), "FILE")(
      "sample", "key or index of a sample, the middle one where not given; a part of the name of a recording's image",
      cxxopts::value<std::string>(),
      "KEY")("sensor", "sensor on the vehicle; the first where not given", cxxopts::value<std::string>(), "NAME")(
      "color", fmt::format("{}; the first that the scan has where not given", fmt::join(colorNames(), ", ")),
      cxxopts::value<std::string>(), "WHAT")("view", fmt::format("{}", fmt::join(kViewNames, ", ")), text("chase"),
                                             "NAME")("size", "width and height in pixels", text("1600x900"), "WxH")(
      "at", "a close-up of this place, in m in the sensor's frame (x forward, y left, z up), looking as the view does",
      cxxopts::value<std::string>(), "X,Y,Z")(
      "within", "of a close-up: only points so near the place, in m, filling the picture", cxxopts::value<double>(),
      "R")("zoom", "factor on the size of everything", cxxopts::value<double>()->default_value("1"), "F")(
      "point-size", "factor on the size of the points", cxxopts::value<double>()->default_value("1"), "N")(
      "flat", "no darkening of depth edges")(
      "range-image",
      "rings x columns instead of a view: straight ahead in the middle, left on the left, the rings shifted by their "
      "azimuth offsets")("sensor-order", "of a range image: columns as the sensor orders them, nothing shifted")(
      "over", "a further scan to draw over it, found like the first; each gets a colour (may be repeated)",
      cxxopts::value<std::vector<std::string>>(), "DATASET|SHARD|SCAN")(
      "ontology",
      "names and colours of the classes, in place of the dataset's: a file, or a name of `scanmill list ontologies`",
      cxxopts::value<std::string>(), "FILE");
  const Arguments parsed = parseArguments(
      command, options, arguments,
      "  scanmill picture out/quickstart -o street.png\n"
      "  scanmill picture out/quickstart -o street.png --sample 12 --color intensity --view above\n"
      "  scanmill picture out/quickstart/train/train-000000.tar -o ranges.png --range-image\n"
      "  scanmill picture scan.pcd -o scan.png --color height --size 3840x2160 --zoom 2\n"
      "  scanmill picture out/ray_tracing --over out/nearest -o rings.png --view above --zoom 3\n"
      "  scanmill picture out/quickstart -o car.png --sample street-s1-lane-000009 --at 6.5,-2.7,-1 --within 2.5\n"
      "  scanmill picture out/passes/street-s1-lane-000010.top.0.front.exr -o passes.png\n"
      "  scanmill picture out/passes -o passes.png --sample 000010\n"
      "  scanmill picture scenes/town.yaml -o sheet.png   # a cell for each object, with its size and classes\n");
  if (parsed.help) return 0;
  const std::filesystem::path file = parsed.fileOrName("DATASET|SHARD|SCAN|EXR|RECORDING|SCENE", {"scenes"});
  if (parsed.options.count("out") == 0) throw InputError("-o FILE is missing: where should the picture go?");
  const std::filesystem::path out = parsed.options["out"].as<std::string>();
  if (out.extension() != ".png") throw InputError({out.string()}, "pictures are PNG: let the name end in .png");

  PictureOptions picture;
  if (const auto color = textOption(parsed, "color"); hasOption(parsed, "color")) {
    picture.colorBy = readColor(color);
  }
  picture.view = static_cast<View>(wordAmong(parsed.options["view"].as<std::string>(), "view", kViewNames));
  const PictureSize size = readPictureSize(parsed.options["size"].as<std::string>());
  picture.width = size.width;
  picture.height = size.height;
  picture.zoom = numberWithin(parsed, "zoom", 1 / kMostFactor, kMostFactor);
  picture.closeUp = readCloseUp(parsed);
  picture.pointSize = numberWithin(parsed, "point-size", 1 / kMostFactor, kMostFactor);
  picture.depthEdges = parsed.options.count("flat") == 0;

  if (isExr(file) || recordingIn(file)) {
    if (picture.closeUp) throw InputError({file.string()}, "is an image: --at is for scans, in which there are places");
    const ImageList images = imagesOption(file, parsed);
    const std::filesystem::path& shown = images.files[images.first];
    const Image image = drawExr(shown, images.ontology ? &*images.ontology : nullptr, picture.width);
    writeFile(out, encodePng(image));
    printText("{}: {} x {}, {}\n", out.string(), image.width, image.height, shown.filename().string());
    return 0;
  }
  if (const std::string kind = lowerExtension(file); kind == ".yaml" || kind == ".yml") {
    requireScene(file);
    for (const char* const option : {"sample", "sensor", "color", "view", "size", "at", "within", "zoom", "point-size",
                                     "flat", "range-image", "sensor-order", "over"}) {
      if (parsed.options.count(option) > 0) {
        throw InputError({file.string()}, fmt::format("is a scene, of whose objects a sheet is made: --{} is for scans "
                                                      "(`scanmill view` looks at a scene as a whole)",
                                                      option));
      }
    }
    SceneOptions plain;
    plain.textures = false;
    plain.ontology = ontologyOption(parsed);
    const Image sheet = drawContactSheet(readScene(file, plain));
    writeFile(out, encodePng(sheet));
    printText("{}: {} x {}, a cell for each object of {}\n", out.string(), sheet.width, sheet.height, file.string());
    return 0;
  }
  ScanSource source = findScan(file, textOption(parsed, "sample"), textOption(parsed, "sensor"));
  if (const auto ontology = ontologyOption(parsed); !ontology.empty()) {
    source.ontology = readOntology(ontology);
  }
  const Ontology* ontology = source.ontology ? &*source.ontology : nullptr;
  Image image;
  try {
    image = parsed.options.count("over") > 0 ? drawOver(source, parsed, file, picture)
            : parsed.options.count("range-image") > 0
                ? drawRangeImage(source.scan, ontology, picture.colorBy, source.title,
                                 hasOption(parsed, "sensor-order") ? StripOrder::Sensor : StripOrder::Outward)
                : drawPicture(source.scan, ontology, picture, source.title);
  } catch (const InputError& e) {
    throw InputError({file.string()}, e.what());
  }
  writeFile(out, encodePng(image));
  printText("{}: {} x {}, {}\n", out.string(), image.width, image.height, source.title);
  return 0;
}

}  // namespace scanmill
