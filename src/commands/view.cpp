#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "base/error.h"
#include "base/file.h"
#include "base/terminal.h"
#include "commands/arguments.h"
#include "config/fields.h"
#include "config/resources.h"
#include "dataset/recording.h"
#include "dataset/scan_store.h"
#include "viewer/coloring.h"
#include "viewer/frames/frame_source.h"
#include "viewer/picture.h"
#include "viewer/window/scene_view.h"
#include "viewer/window/session.h"

namespace scanmill {

namespace {

constexpr std::array<std::string_view, 3> kLayoutNames{"one", "overlay", "split"};
constexpr int kTickMs = 15;              // ms between two Tick events of the window (CanvasEvent)
constexpr double kMostCoordinate = 1e5;  // largest coordinate (sensor's frame) and largest radius of a close-up (m)

// Reads kCount numbers with a separator between them, such as "8,-3.5,-1". Returns nothing for any other text.
template <class T, std::size_t kCount>
std::optional<std::array<T, kCount>> readNumbers(std::string_view text, char separator = ',') {
  std::array<T, kCount> values{};
  const char* begin = text.data();
  const char* const end = begin + text.size();
  for (std::size_t i = 0; i < kCount; ++i) {
    const auto [next, failure] = std::from_chars(begin, end, values[i]);
    const bool isLast = i + 1 == kCount;
    if (failure != std::errc() || (isLast ? next != end : next == end || *next != separator)) return {};
    begin = next + 1;
  }
  return values;
}

// The value of --size: width and height (pixels) of the window or picture.
struct PictureSize {
  int width = 0;
  int height = 0;
};

// Reads the value of --color: one of colorNames(), or the name of any other column that a recorded file may have.
// Throws InputError for a word that is empty or seems to be a misspelt entry of colorNames().
ColorBy readColor(const std::string& word) {
  for (const Column& column : kColumns) {
    if (column.name == word) return ColorBy(column);  // a column's name always means this column
  }
  const std::vector<std::string>& names = colorNames();
  const bool isKnown = std::ranges::find(names, word) != names.end();
  const std::string similar = nearest(word, names);
  if (word.empty() || (!isKnown && !similar.empty())) {
    throw InputError(fmt::format("--color is one of {}, or a column of a recorded file, not '{}'{}",
                                 fmt::join(names, ", "), word,
                                 similar.empty() ? "" : fmt::format(" (did you mean '{}'?)", similar)));
  }
  return ColorBy(word);
}

// Returns the index of a word in `names`. Throws an InputError that names the option if `names` does not contain the
// word.
std::size_t indexOfWord(const std::string& word, const std::string& option, std::span<const std::string_view> names) {
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (names[i] == word) return i;
  }
  throw InputError(fmt::format("--{} is one of {}, not '{}'", option, fmt::join(names, ", "), word));
}

PictureSize readPictureSize(const std::string& text) {
  const auto sides = readNumbers<int, 2>(text, 'x');
  const auto isAllowed = [](int side) { return side >= kLeastPictureSide && side <= kMostPictureSide; };
  if (sides && std::ranges::all_of(*sides, isAllowed) && (*sides)[0] * (*sides)[1] <= kMostPicturePixels) {
    return {.width = (*sides)[0], .height = (*sides)[1]};
  }
  throw InputError(
      fmt::format("--size is WIDTHxHEIGHT in pixels, {} to {} each and {} million in all, such as 1600x900, not '{}'",
                  kLeastPictureSide, kMostPictureSide, kMostPicturePixels / 1000000, text));
}

// Returns the file that --ontology gives by path or by a name in `scanmill list ontologies`; empty if it is not given.
std::filesystem::path ontologyOption(const Arguments& parsed) {
  const std::string name = parsed.text("ontology");
  return name.empty() ? std::filesystem::path() : namedResource(name, "labels");
}

// Outputs that replace the window, and their options. Without a screenshot or a pick, a window is opened.
struct Outputs {
  std::filesystem::path screenshot;
  std::optional<std::pair<int, int>> pick;  // pixel of the picture; the point or triangle there is printed
  bool wholeRangeImage = false;             // the screenshot is the range image alone, in full size

  bool window() const { return screenshot.empty() && !pick; }
};

std::pair<int, int> readPixel(const std::string& text, const PictureSize& size) {
  const auto pixel = readNumbers<int, 2>(text);
  const auto isInside = [](int index, int side) { return index >= 0 && index < side; };
  if (pixel && isInside((*pixel)[0], size.width) && isInside((*pixel)[1], size.height)) {
    return {(*pixel)[0], (*pixel)[1]};
  }
  throw InputError(
      fmt::format("--pick is X,Y: a pixel of the {} x {} picture, counted from the upper left corner, not '{}'",
                  size.width, size.height, text));
}

std::uint32_t readInstance(const std::string& text) {
  if (const auto id = readNumbers<std::uint32_t, 1>(text); id && id->front() != 0) return id->front();
  throw InputError(fmt::format("--instance is the number of an instance, from 1 on, such as 4711, not '{}'", text));
}

ScaleRange readScale(const std::string& text) {
  const auto ends = readNumbers<double, 2>(text);
  if (ends && std::isfinite(ends->front()) && std::isfinite(ends->back()) && ends->front() < ends->back()) {
    return {ends->front(), ends->back()};
  }
  throw InputError(
      fmt::format("--scale is LOW,HIGH: the values of the first and the last colour, such as 0,0.05, not '{}'", text));
}

// Reads X,Y,Z, the value of --at.
Vec3d readPosition(const std::string& text) {
  const auto position = readNumbers<double, 3>(text);
  if (position && std::ranges::all_of(*position, [](double value) { return std::abs(value) <= kMostCoordinate; })) {
    return {(*position)[0], (*position)[1], (*position)[2]};
  }
  throw InputError(
      fmt::format("--at is X,Y,Z in m in the sensor's frame (x forward, y left, z up), at most {} each, such as "
                  "8,-3.5,-1, not '{}'",
                  kMostCoordinate, text));
}

std::optional<CloseUp> readCloseUp(const Arguments& parsed) {
  const bool hasPosition = parsed.has("at");
  if (hasPosition != parsed.has("within")) {
    throw InputError("a close-up takes both --at X,Y,Z (where, in m) and --within R (so far around it, in m)");
  }
  if (!hasPosition) return {};
  return CloseUp{readPosition(parsed.text("at")), parsed.number("within", 0.01, kMostCoordinate)};
}

Outputs readOutputs(const Arguments& parsed, const PictureSize& size) {
  Outputs outputs;
  if (parsed.has("screenshot")) {
    outputs.screenshot = parsed.text("screenshot");
    if (outputs.screenshot.extension() != ".png") {
      throw InputError({outputs.screenshot.string()}, "pictures are PNG: let the name end in .png");
    }
  }
  outputs.wholeRangeImage = parsed.has("range-image-alone");
  if (outputs.wholeRangeImage && outputs.screenshot.empty()) {
    throw InputError("--range-image-alone makes a picture: add --screenshot FILE.png");
  }
  if (parsed.has("pick")) outputs.pick = readPixel(parsed.text("pick"), size);
  return outputs;
}

// Sets the views of a window or picture: their colours, layout and scale.
void readViews(const Arguments& parsed, ViewOptions& view) {
  for (const std::string& word : parsed.list("color")) view.colors.push_back(readColor(word));
  if (parsed.has("layout")) {
    view.layout = static_cast<ViewLayout>(indexOfWord(parsed.text("layout"), "layout", kLayoutNames));
  } else if (view.colors.size() > 1) {
    view.layout = ViewLayout::Split;
  } else if (parsed.has("over")) {
    view.layout = ViewLayout::Overlay;
  }
  if (view.colors.size() > 1 && view.layout != ViewLayout::Split) {
    throw InputError("--color was given more than once: only --layout split has several views");
  }
  if (!view.colors.empty() && view.layout == ViewLayout::Overlay) {
    throw InputError(
        "--color: an overlay shows each scan in a colour of its own; add --layout split or --layout one, "
        "or leave out --color");
  }
  if (parsed.has("scale")) {
    view.scale = readScale(parsed.text("scale"));
    const auto numericColors = std::ranges::count_if(view.colors, isNumeric);
    if (numericColors != 1) {
      throw InputError(
          fmt::format("--scale belongs to the one --color that shows numbers (intensity, range, ring, "
                      "time, height, incidence, error); {}",
                      numericColors == 0 ? "name that" : "more of them have different scales"));
    }
  }
}

// Reads the options of a window or, if `window` is false, of a picture of what the window would show.
ViewOptions readViewOptions(const Arguments& parsed, bool window) {
  ViewOptions view;
  readViews(parsed, view);
  if (parsed.has("camera")) view.camera = parseCamera(parsed.text("camera"));
  view.closeUp = readCloseUp(parsed);
  if (view.closeUp && view.camera.placed) {
    throw InputError("--at says where to look: leave X,Y,Z out of --camera beside it");
  }
  if (parsed.has("point-size")) view.pointSize = parsed.number("point-size", 0.5, 50);
  view.sample = parsed.text("sample");
  view.depthEdges = !parsed.has("flat");
  view.mesh = parsed.has("mesh");
  view.rangeRings = parsed.has("rings");
  view.rangeImage = parsed.has("range-image");
  view.still = !window;
  view.bare = parsed.has("bare");
  if (parsed.has("boxes")) {
    view.boxes = static_cast<BoxChoice>(indexOfWord(parsed.text("boxes"), "boxes", kBoxChoiceNames));
  } else if (view.bare) {
    view.boxes = BoxChoice::None;
  }
  if (view.bare) view.axes = view.trajectory = false;
  if (parsed.has("hide") && parsed.has("only")) throw InputError("--hide and --only exclude each other");
  view.only = parsed.has("only");
  view.hidden = parsed.list(view.only ? "only" : "hide");
  for (const std::string& text : parsed.list("instance")) view.instances.push_back(readInstance(text));
  return view;
}

// Prints names and values in two columns.
void printRows(const std::string& heading, const std::vector<std::pair<std::string, std::string>>& rows) {
  std::size_t widest = 0;
  for (const auto& [name, value] : rows) widest = std::max(widest, name.size());
  printText("{}\n", heading);
  for (const auto& [name, value] : rows) printText("  {:{}}  {}\n", name, widest, oneLine(value));
}

void writePicture(const std::filesystem::path& file, const Image& image, const std::string& what) {
  writeFile(file, encodePng(image));
  printText("{}: {} x {}, {}\n", file.string(), image.width, image.height, what);
}

// Throws InputError if the user has given an option that is not allowed. `subject`: the thing that does not accept the
// option, such as "an EXR image".
void requireOnly(const std::filesystem::path& file, const Arguments& parsed, const std::string& subject,
                 std::initializer_list<std::string_view> allowed) {
  for (const cxxopts::KeyValue& option : parsed.options.arguments()) {
    const std::string& name = option.key();
    if (name == "input" || std::ranges::find(allowed, name) != allowed.end()) continue;
    throw InputError({file.string()}, "{} takes no --{}: leave it out", subject, name);
  }
}

// Writes a picture of the scan's range image alone.
void drawWholeRangeImage(const std::filesystem::path& file, const Arguments& parsed, const Outputs& outputs) {
  requireOnly(file, parsed, "--range-image-alone",
              {"range-image-alone", "screenshot", "sample", "sensor", "color", "ontology"});
  const std::vector<std::string> colors = parsed.list("color");
  if (colors.size() > 1) throw InputError("--range-image-alone shows one --color");
  ScanSource source = findScan(file, parsed.text("sample"), parsed.text("sensor"));
  if (const auto ontology = ontologyOption(parsed); !ontology.empty()) source.ontology = readOntology(ontology);
  const auto colorBy = colors.empty() ? std::nullopt : std::optional(readColor(colors.front()));
  try {
    writePicture(outputs.screenshot,
                 drawRangeImage(source.scan, source.ontology ? &*source.ontology : nullptr, colorBy, source.title,
                                source.beams.get()),
                 source.title);
  } catch (const InputError& e) {
    throw InputError({file.string()}, e.what());
  }
}

// Writes a picture of an EXR image: the file `path` or, if `path` is a recording's folder, an image of its --sample.
void drawImage(const std::filesystem::path& path, const Arguments& parsed, const PictureSize& size,
               const std::filesystem::path& screenshot) {
  if (screenshot.empty()) {
    throw InputError({path.string()}, "is drawn as a picture, without a window: add --screenshot FILE.png");
  }
  requireOnly(path, parsed, "an EXR image", {"plane", "screenshot", "sample", "ontology", "size"});
  ExrSource source = findExr(path, parsed.text("sample"));
  if (const auto ontology = ontologyOption(parsed); !ontology.empty()) source.ontology = readOntology(ontology);
  const std::string plane = parsed.text("plane");
  writePicture(screenshot, drawExr(source, plane == "all" ? "" : plane, size.width), source.file.stem().string());
}

// Opens a window or, if `outputs` replaces it, prints what is picked and writes the screenshot. `showsMap`: --map.
void viewFrames(const ViewInput& input, bool showsMap, const ViewOptions& view, const PictureSize& size,
                const Outputs& outputs) {
  std::shared_ptr<const FrameSource> source = openFrames(input);
  if (showsMap) source = mapOf(source, view.sample);
  auto loader = std::make_unique<FrameLoader>(source);
  // Requests the frame first, so that it loads while the canvas opens.
  if (!source->keys().empty()) loader->want(source->find(view.sample), 0);
  const std::unique_ptr<Canvas> canvas =
      outputs.window() ? openWindow(fmt::format("scanmill view {}", input.path.string()), size.width, size.height)
                       : openOffscreen(size.width, size.height);
  ViewSession session(source, *canvas, view, std::move(loader));
  if (outputs.window()) return canvas->run(kTickMs, [&](const CanvasEvent& event) { return session.handle(event); });
  session.drawWhenLoaded();
  session.check();
  for (const std::string& problem : session.problems()) warn(problem);
  for (const std::string& text : session.hints()) warn(text);
  if (outputs.pick) {
    const auto& [x, y] = *outputs.pick;
    if (const auto picked = session.pick(x, y)) {
      printRows(picked->heading, picked->rows);
      session.pin(*picked);
    } else {
      printText("nothing lies at {},{}\n", x, y);
    }
  }
  if (outputs.screenshot.empty()) return;
  session.drawWhenLoaded();
  writePicture(outputs.screenshot, session.picture(), source->title());
}

void addOptions(CommandOptions& options) {
  options.add(
      "sample",
      "key, or index from 0, of a sample, the middle one where not given; a part of the name of a recording's image",
      textValue(), "KEY");
  options.add("map", "all samples of the sequence in one map, in place of the one sample");
  options.add("sensor", "only this sensor's scans", textValue(), "NAME");
  options.add("over", "further scans to lay over those: samples are joined by their keys (may be repeated)",
              listValue(), "DATASET|SHARD|SCAN");
  options.add("reference,twin", "the noise-free reference, for --color error", textValue(), "DATASET|SHARD|SCAN");
  options.add("scene", "the scene that was scanned, in place of the one that the dataset names", textValue(), "FILE");
  options.add("seed", "of a procedural scene that is viewed by itself (default: 1), or by --scene",
              cxxopts::value<std::uint64_t>(), "N");
  options.add(
      "ontology",
      "names and colours of the classes, in place of the dataset's: a file, or a name of `scanmill list ontologies`",
      textValue(), "FILE|NAME");
  options.add("color",
              fmt::format("{}; the first that the scan has where not given; once per view; of a scene by itself {}",
                          fmt::join(colorNames(), ", "), fmt::join(kMeshColorNames, ", ")),
              listValue(), "WHAT");
  options.add("scale", "first and last value of the colours that show numbers; follows from the values where not given",
              textValue(), "LOW,HIGH");
  options.add("layout", fmt::format("{}: how the scans of a sample are shown", fmt::join(kLayoutNames, ", ")),
              textValue(), "NAME");
  options.add("camera",
              fmt::format("{}, or YAW,PITCH,DISTANCE[,X,Y,Z] in deg and m, such as 30,20,25; of a "
                          "scene by itself X,Y,Z are its own coordinates, as --pick prints them",
                          fmt::join(kViewNames, ", ")),
              textValue(), "WHERE");
  options.add(
      "plane",
      "of an EXR image, with --screenshot: the one plane to draw, with its legend; all side by side where not given",
      textValue(), "NAME");
  options.add("at", "a close-up of this place, in m in the sensor's frame, from the direction of --camera", textValue(),
              "X,Y,Z");
  options.add("within", "only the points so near the place of --at, in m", textValue(), "R");
  options.add("size", "width and height in pixels: of the window 1280x800, of pictures 1600x900", textValue(), "WxH");
  options.add("point-size", "of the points, in pixels", textValue(), "PX");
  options.add("hide", "a class that is not shown: name or id (may be repeated)", listValue(), "CLASS");
  options.add("only", "a class that alone is shown (may be repeated)", listValue(), "CLASS");
  options.add("instance", "an instance that alone is shown (may be repeated)", listValue(), "ID");
  options.add("boxes",
              fmt::format("{}: the objects whose boxes are drawn, if the dataset lists objects (default: {})",
                          fmt::join(kBoxChoiceNames, ", "), kBoxChoiceNames.front()),
              textValue(), "WHICH");
  options.add("mesh", "the scene, faintly");
  options.add("rings", "range rings");
  options.add("range-image", "also as rings x columns, looking outward");
  options.add("range-image-alone", "the range image in full size in place of the view, with --screenshot");
  options.add("flat", "no darkening of depth edges");
  options.add("bare", "the points alone: no panels, axes, boxes or trajectory; beside --boxes these are kept");
  options.add("screenshot", "a picture in place of the window; needs no display", textValue(), "FILE.png");
  options.add("pick", "prints what lies at a pixel of the picture, and marks it in that", textValue(), "X,Y");
}

}  // namespace

int runView(const std::vector<std::string>& arguments) {
  CommandOptions options("view");
  addOptions(options);
  addInputLimit(options);
  std::string keyHelp = "\nKeys and pointer:\n";
  for (const auto& [keys, action] : viewKeys()) keyHelp += fmt::format("  {:42} {}\n", keys, action);
  const Arguments parsed =
      parseArguments(options, arguments,
                     "  scanmill view out/quickstart\n"
                     "  scanmill view out/quickstart --sample 12 --color intensity --camera above\n"
                     "  scanmill view out/quickstart --map --color height --screenshot map.png\n"
                     "  scanmill view out/noisy --reference out/clean --color error --scale 0,0.05\n"
                     "  scanmill view out/ray_tracing --over out/depth_camera --over out/particle\n"
                     "  scanmill view out/quickstart --color class --color range --mesh\n"
                     "  scanmill view out/quickstart --screenshot street.png --size 1920x1080 --hide road\n"
                     "  scanmill view out/quickstart --pick 800,450\n"
                     "  scanmill view out/quickstart --instance 4711 --color intensity\n"
                     "  scanmill view out/passes --sample 000010 --plane semantic --screenshot classes.png\n"
                     "  scanmill view out/quickstart --at 6.5,-2.7,-1 --within 2.5 --screenshot car.png\n"
                     "  scanmill view out/quickstart --range-image-alone --color range --screenshot ranges.png\n"
                     "  scanmill view scenes/street.yaml\n" +
                         keyHelp);
  ViewInput input{.path = parsed.fileOrName("DATASET|SHARD|SCAN|EXR|SCENE", {"scenes"})};
  const bool offscreen = parsed.has("screenshot") || parsed.has("pick");
  const PictureSize size = parsed.has("size") ? readPictureSize(parsed.text("size"))
                           : offscreen        ? PictureSize{1600, 900}
                                              : PictureSize{1280, 800};
  const Outputs outputs = readOutputs(parsed, size);
  const ViewOptions view = readViewOptions(parsed, outputs.window());
  if (input.path.extension() == ".exr" || recordingIn(input.path)) {
    drawImage(input.path, parsed, size, outputs.screenshot);
    return 0;
  }
  if (parsed.has("plane")) {
    throw InputError({input.path.string()}, "is no EXR image: --plane chooses one of such an image's planes");
  }
  if (outputs.wholeRangeImage) {
    drawWholeRangeImage(input.path, parsed, outputs);
    return 0;
  }
  for (const std::string& other : parsed.list("over")) input.over.emplace_back(other);
  input.reference = parsed.text("reference");
  input.sensor = parsed.text("sensor");
  input.ontology = ontologyOption(parsed);
  input.scene = parsed.text("scene");
  if (parsed.has("seed")) input.seed = parsed.options["seed"].as<std::uint64_t>();
  viewFrames(input, parsed.has("map"), view, size, outputs);
  return 0;
}

}  // namespace scanmill
