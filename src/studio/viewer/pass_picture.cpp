#include <fmt/core.h>
#include <fmt/ranges.h>

#include "base/error.h"
#include "config/fields.h"
#include "dataset/names.h"
#include "dataset/recording.h"
#include "evaluate/spread.h"
#include "passes/exr/exr_file.h"
#include "passes/exr/hits_exr.h"
#include "passes/exr/pass_exr.h"
#include "viewer/panels/panel_rects.h"
#include "viewer/panels/widgets.h"
#include "viewer/picture.h"

namespace scanmill {

namespace fs = std::filesystem;

namespace {

// The contents of an EXR file: the render passes of a camera, or the hits of a sensor.
struct ExrImage {
  int width = 0, height = 0;
  std::string size;       // size as text, such as "40 x 20 pixels, 90.0 x 53.1 degrees"
  bool ofSensor = false;  // true: the file has the hits of a sensor, whose ranges are stored as depths
  PassPlanes planes;
  std::vector<float> incidence{};  // cosine of the incidence angle; only for hits

  // True if the pixel or beam shows a surface.
  bool showsSurface(std::size_t pixel) const { return std::isfinite(planes.depth[pixel]); }
};

// A plane of an EXR file, such as its depths or its class ids, as an image.
struct PassPlane {
  std::string name;  // quantity in the plane, such as "depth" or "semantic"
  std::string note;  // what the colours show, such as "0 to 1" or "a colour each"; may be empty
  Image image;
  Legend legend{};  // names and colours of classes or materials, or the scale of fractions; empty for other planes
};

// Reads an EXR file. Files of hits have a channel "range"; files of passes have none.
ExrImage readExr(const std::filesystem::path& file) {
  const ExrReader header(file);
  ExrImage image;
  if (std::ranges::count(header.channels(), "range", &ExrChannel::name) == 0) {
    PassImage passes = readPasses(file, passesIn(file));
    const Camera& c = passes.camera;
    image.width = static_cast<int>(c.width);
    image.height = static_cast<int>(c.height);
    image.size = fmt::format("{} x {} pixels, {:.1f} x {:.1f} degrees", c.width, c.height, degrees(c.horizontalField()),
                             degrees(c.verticalField()));
    image.planes = std::move(passes.planes);
    return image;
  }
  Hits hits;
  readHits(file, channelsIn(file), hits);
  image.width = static_cast<int>(hits.columns);
  image.height = static_cast<int>(hits.rings);
  image.size = fmt::format("{} rings x {} columns", hits.rings, hits.columns);
  image.ofSensor = true;
  forEachPass([&](const ChannelRow&, auto plane, auto column) { image.planes.*plane = std::move(hits.*column); });
  image.incidence = std::move(hits.incidence);
  return image;
}

// Returns the 1st and 99th percentile of the positive finite values (of every 97th in large images); {1, 1} if none.
ScaleRange percentilesOf(const std::vector<float>& values) {
  const std::size_t step = values.size() > 100'000 ? 97 : 1;
  std::vector<float> positive;
  for (std::size_t i = 0; i < values.size(); i += step) {
    if (std::isfinite(values[i]) && values[i] > 0) positive.push_back(values[i]);
  }
  return positive.empty() ? ScaleRange{1, 1} : ScaleRange{quantileOf(positive, 0.01), quantileOf(positive, 0.99)};
}

// Converts an EXR image's channels (depth or range, normals, ids, reflectance) to coloured pictures with legends.
class PlaneMaker {
 public:
  PlaneMaker(const ExrImage& image, const ExrSource& source) : image_(image), source_(source) {}

  std::vector<PassPlane> make() {
    const PassPlanes& p = image_.planes;
    const Ontology* const ontology = source_.ontology ? &*source_.ontology : nullptr;
    const auto [low, high] = percentilesOf(p.depth);
    const double scale = high > low ? 1 / std::log(high / low) : 0;
    add(image_.ofSensor ? "range" : "depth", fmt::format("{:.2g} to {:.3g} m, by its logarithm", low, high),
        [&, low = low](std::size_t i) { return viridis(std::log(std::max(double{p.depth[i]}, 1e-9) / low) * scale); });
    if (!p.normal.empty()) {
      const auto byte = [](float c) { return static_cast<std::uint8_t>(std::lround(127.5 + 127.5 * c)); };
      add("normal", "x red, y green, z blue", [&](std::size_t i) {
        return Rgb{byte(p.normal[i].x), byte(p.normal[i].y), byte(p.normal[i].z)};
      });
    }
    const auto semanticColor = [=](std::uint32_t id) { return classColor(ontology, static_cast<std::uint16_t>(id)); };
    addIds("semantic", p.semantic, semanticColor,
           [=](std::uint32_t id) { return className(ontology, static_cast<std::uint16_t>(id)); });
    addIds("instance", p.instance, instanceColor);
    // 0 is the id of a material or primitive, but instanceColor(0) is the colour for no instance.
    const auto colorEach = [](std::uint32_t id) { return instanceColor(id + 1); };
    addIds("material", p.material, colorEach, [&](std::uint32_t id) {
      return id < source_.materials.size() ? source_.materials[id] : fmt::format("material {}", id);
    });
    addIds("primitive", p.primitive, colorEach);
    addNumbers("reflectance", p.reflectance);
    addNumbers("roughness", p.roughness);
    addNumbers("metallic", p.metallic);
    addNumbers("retroreflectance", p.retroreflectance);
    addNumbers("cosine of the incidence", image_.incidence);
    return std::move(planes_);
  }

 private:
  // Adds a plane. colorOf(pixel) is called only for pixels that show a surface.
  void add(const std::string& name, std::string note, const auto& colorOf) {
    PassPlane plane{name, std::move(note), Image(image_.width, image_.height, kBackground)};
    plane.legend.title = name;
    for (std::size_t i = 0; i < plane.image.pixels.size(); ++i) {
      if (image_.showsSurface(i)) plane.image.pixels[i] = colorOf(i);
    }
    planes_.push_back(std::move(plane));
  }

  // Adds a plane of ids if there are any. Its legend lists named ids, the most frequent first; empty without `nameOf`.
  template <class Id>
  void addIds(const char* name, const std::vector<Id>& ids, const auto& colorOf,
              const std::function<std::string(std::uint32_t)>& nameOf = {}) {
    if (ids.empty()) return;
    std::vector<Rgb> colors;
    const auto counted = paint(
        ids.size(), [&](std::size_t i) { return ids[i]; }, colorOf,
        [&](std::size_t i) { return image_.showsSurface(i); }, colors);
    add(name, nameOf ? "" : "a colour each", [&](std::size_t i) { return colors[i]; });
    if (!nameOf) return;
    std::vector<LegendEntry>& entries = planes_.back().legend.entries;
    for (const auto& [id, pixels] : counted) {
      entries.push_back({nameOf(id), pixels.color, std::int64_t{id}, pixels.count});
    }
    std::ranges::stable_sort(entries, std::greater<>(), &LegendEntry::points);
  }

  // Adds a plane of numbers with a scale from 0 to 1, or to the largest number if this exceeds 1.
  void addNumbers(const char* name, const std::vector<float>& values) {
    if (values.empty()) return;
    const double high = std::max(1.0, double{*std::ranges::max_element(values)});
    add(name, fmt::format("0 to {:.3g}", high), [&](std::size_t i) { return viridis(values[i] / high); });
    planes_.back().legend.scale = true;
    planes_.back().legend.high = high;
  }

  const ExrImage& image_;
  const ExrSource& source_;
  std::vector<PassPlane> planes_;
};

// Removes all planes except the plane with this name. Throws InputError if there is no such plane.
void keepPlane(std::vector<PassPlane>& planes, const std::string& name, const std::filesystem::path& file) {
  const std::vector<std::string> names = namesOf(planes);
  if (std::ranges::find(names, name) == names.end()) {
    throw InputError({file.string()}, "has no plane '{}'; it has {}", name, fmt::join(names, ", "));
  }
  std::erase_if(planes, [&](const PassPlane& p) { return p.name != name; });
}

// Returns the names of the materials in an image of the recording, by material id; empty if they are unknown.
std::vector<std::string> materialsOf(const Recording& recording, const std::string& image) {
  // Each scene and seed has a table of materials. If an image's name starts with the names of two scenes ("town" and
  // "town-s1-old"), the longer name is right.
  const RecordedSequence* sequence = nullptr;
  std::size_t longestPrefix = 0;
  for (const RecordedSequence& s : recording.sequences) {
    const std::string prefix = fmt::format("{}-s{}-", s.scene, s.seed);
    if (!image.starts_with(prefix) || prefix.size() <= longestPrefix) continue;
    sequence = &s;
    longestPrefix = prefix.size();
  }
  if (sequence == nullptr || sequence->materials >= recording.materials.size()) return {};
  return namesOf(recording.materials[sequence->materials]);
}

}  // namespace

ExrSource findExr(const fs::path& path, const std::string& imageName) {
  const bool isFolder = fs::is_directory(path);
  const fs::path folder = isFolder ? path : path.has_parent_path() ? path.parent_path() : fs::path(".");
  ExrSource source;
  source.file = path;
  if (isFolder) {
    std::vector<fs::path> files;
    for (const fs::directory_entry& entry : fs::directory_iterator(path)) {
      if (entry.path().extension() == ".exr") files.push_back(entry.path());
    }
    if (files.empty()) throw InputError({path.string()}, "holds no EXR image: is the recording whole?");
    // Sort by name such that "a.9.exr" comes before "a.10.exr".
    std::ranges::sort(files, [](const fs::path& a, const fs::path& b) {
      return ::strverscmp(a.stem().c_str(), b.stem().c_str()) < 0;
    });
    std::vector<std::string> names;
    for (const fs::path& file : files) names.push_back(file.stem().string());
    source.file = files[findKey(names, imageName, path.string())];
  }
  if (const auto kind = recordingIn(folder)) {
    const Recording recording = readRecording(folder, *kind);
    if (!recording.ontology.classes.empty()) source.ontology = recording.ontology;
    source.materials = materialsOf(recording, source.file.stem().string());
  }
  return source;
}

// Planes are enlarged without interpolation, since ids must not be interpolated.
Image drawExr(const ExrSource& source, const std::string& planeName, int width) {
  constexpr double kReadableShare = 1.0 / 7;  // least height of a plane of hits divided by its width
  constexpr int kInOneRow = 4;                // largest number of planes in one row; more are in two rows
  constexpr double kLetter = 18;              // height of letters in pixels
  constexpr int kTitleHeight = 30;            // height of the title in pixels
  constexpr int kCaptionHeight = 26;          // height of the caption above each plane in pixels
  constexpr int kGap = 8;                     // space between planes in pixels
  const ExrImage image = readExr(source.file);
  std::vector<PassPlane> planes = PlaneMaker(image, source).make();
  if (!planeName.empty()) keepPlane(planes, planeName, source.file);
  const auto count = static_cast<int>(planes.size());
  const int columns = image.ofSensor ? 1 : count <= kInOneRow ? count : (count + 1) / 2;
  const int rows = (count + columns - 1) / columns;
  const Legend legend = count > 1 ? Legend{} : planes.front().legend;
  // A narrow picture has its legend below the plane.
  const bool beside = (legend.scale || !legend.entries.empty()) && 2 * sideWidth(kLetter) <= width;
  const int planesWidth = beside ? width - sideWidth(kLetter) : width;
  const int tileWidth = (planesWidth - kGap * (columns + 1)) / columns;
  const double share = static_cast<double>(image.height) / image.width;
  const double shownShare = image.ofSensor ? std::max(kReadableShare, share) : share;
  const int tileHeight = std::clamp(static_cast<int>(std::lround(tileWidth * shownShare)), 1, kMostPictureSide);
  const int rowHeight = kCaptionHeight + tileHeight + kGap;
  LegendPicture picture{.title = fmt::format("{}, {}", source.file.filename().string(), image.size),
                        .details = "",
                        .body = {0, kTitleHeight, planesWidth, rows * rowHeight},
                        .lineHeight = kLetter,
                        .maxWidth = width};
  for (const PassPlane& plane : planes) picture.images.push_back(&plane.image);
  return drawWithLegend(picture, legend, [&] {
    for (int i = 0; i < count; ++i) {
      const PassPlane& plane = planes[static_cast<std::size_t>(i)];
      const int x = kGap + i % columns * (tileWidth + kGap);
      const int y = kTitleHeight + i / columns * rowHeight;
      textAt(x, y + 4, tileWidth, plane.note.empty() ? plane.name : fmt::format("{}, {}", plane.name, plane.note));
      imageAt(static_cast<ImageId>(i), {x, y + kCaptionHeight, tileWidth, tileHeight});
    }
  });
}

}  // namespace scanmill
