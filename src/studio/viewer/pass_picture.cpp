#include "viewer/pass_picture.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <optional>
#include <utility>

#include "passes/exr/exr_file.h"
#include "passes/exr/hits_exr.h"
#include "passes/exr/pass_exr.h"
#include "viewer/color_map.h"
#include "viewer/panels/board.h"
#include "viewer/panels/parts.h"

namespace scanmill {

namespace {

// The contents of an EXR file, either of a camera's render passes or of a sensor's hits.
struct ExrImage {
  int width = 0;
  int height = 0;
  std::string size;       // size as text, such as "40 x 20 pixels, 90.0 x 53.1 degrees"
  bool ofSensor = false;  // true: the file has the hits of a sensor, whose ranges are stored as depths
  PassPlanes planes;
  std::vector<float> incidence{};           // cosine of the incidence angle; only for hits
  std::vector<std::uint32_t> unresolved{};  // indices of pixels that are unresolved, ascending
  std::optional<Ontology> ontology{};
  std::vector<std::string> materials{};

  bool sees(std::size_t pixel) const { return std::isfinite(planes.depth[pixel]); }
  std::string materialName(std::uint16_t id) const {
    return id < materials.size() ? materials[id] : fmt::format("material {}", id);
  }
};

std::shared_ptr<const ExrImage> readExr(const std::filesystem::path& file, const Ontology* ontology,
                                        const std::vector<std::string>& materials) {
  const ExrReader header(file);
  const auto& channels = header.channels();
  const auto has = [&](const char* name) {
    return std::ranges::any_of(channels, [&](const ExrChannel& c) { return c.name == name; });
  };
  auto image = std::make_shared<ExrImage>();
  if (ontology != nullptr) image->ontology = *ontology;
  image->materials = materials;
  if (!has("range")) {
    PassImage passes = readPasses(file, passesIn(file));
    const Camera& c = passes.camera;
    image->width = static_cast<int>(c.width);
    image->height = static_cast<int>(c.height);
    image->size = fmt::format("{} x {} pixels, {:.1f} x {:.1f} degrees", c.width, c.height,
                              degrees(c.horizontalField()), degrees(c.verticalField()));
    image->planes = std::move(passes.planes);
    return image;
  }
  Hits hits;
  readHits(file, channelsIn(file), hits);
  image->width = static_cast<int>(hits.columns);
  image->height = static_cast<int>(hits.rings);
  image->size = fmt::format("{} rings x {} columns", hits.rings, hits.columns);
  image->ofSensor = true;
  forEachPass([&](const ChannelRow&, auto plane, auto column) { image->planes.*plane = std::move(hits.*column); });
  image->incidence = std::move(hits.incidence);
  image->unresolved = std::move(hits.unresolved);
  return image;
}

// Returns the 1st and 99th percentile of the positive finite values. In large images only every 97th pixel is used.
ScaleRange spanOf(const std::vector<float>& values) {
  std::vector<float> seen;
  for (std::size_t i = 0; i<values.size(); i += values.size()> 100'000 ? 97 : 1) {
    if (std::isfinite(values[i]) && values[i] > 0) seen.push_back(values[i]);
  }
  if (seen.empty()) return {1, 1};
  std::ranges::sort(seen);
  const auto at = [&](double share) {
    return double{seen[static_cast<std::size_t>(share * static_cast<double>(seen.size() - 1))]};
  };
  return {at(0.01), at(0.99)};
}

// Creates the planes of an image. The planes' functions `value` keep the image in memory.
class PlaneMaker {
 public:
  explicit PlaneMaker(std::shared_ptr<const ExrImage> image) : image_(std::move(image)) {}

  std::vector<PassPlane> make() {
    const PassPlanes& p = image_->planes;
    const Ontology* const ontology = image_->ontology ? &*image_->ontology : nullptr;
    addDistance();
    if (!p.normal.empty()) {
      const auto byte = [](float c) { return static_cast<std::uint8_t>(std::lround(127.5 + 127.5 * c)); };
      add(
          "normal", "x red, y green, z blue",
          [&](std::size_t i) {
            return Rgb{byte(p.normal[i].x), byte(p.normal[i].y), byte(p.normal[i].z)};
          },
          [&p](std::size_t i) {
            return fmt::format("{:.3f}, {:.3f}, {:.3f}", p.normal[i].x, p.normal[i].y, p.normal[i].z);
          });
    }
    const auto semanticColor = [=](std::uint16_t id) { return classColor(ontology, id); };
    const auto semanticName = [=](std::uint16_t id) { return className(ontology, id); };
    addIds("semantic", ontology == nullptr ? "a colour each" : "", p.semantic, semanticColor, [=](std::uint16_t id) {
      const bool named = ontology != nullptr && ontology->find(id) != nullptr;
      return named ? fmt::format("{} ({})", semanticName(id), id) : semanticName(id);
    });
    addEntries(p.semantic, semanticColor, semanticName);
    addIds("instance", "a colour each", p.instance, instanceColor,
           [](std::uint32_t id) { return id == 0 ? std::string("none") : std::to_string(id); });
    // 0 is the id of a material or primitive, but instanceColor(0) is the colour for no instance.
    const auto colorEach = [](std::uint32_t id) { return instanceColor(id + 1); };
    addIds("material", image_->materials.empty() ? "a colour each" : "", p.material, colorEach,
           [image = image_.get()](std::uint16_t id) {
             return image->materials.empty() ? std::to_string(id) : fmt::format("{} ({})", image->materialName(id), id);
           });
    addEntries(p.material, colorEach, [&](std::uint16_t id) { return image_->materialName(id); });
    addIds("primitive", "a colour each", p.primitive, colorEach, [](std::uint32_t id) { return std::to_string(id); });
    addShare("reflectance", p.reflectance);
    addShare("roughness", p.roughness);
    addShare("metallic", p.metallic);
    addShare("retroreflectance", p.retroreflectance);
    addShare("cosine of the incidence", image_->incidence);
    return std::move(planes_);
  }

 private:
  // Adds a plane. colorOf(pixel) and valueOf(pixel) are called only for pixels that show a surface.
  void add(const std::string& name, std::string note, const auto& colorOf, const auto& valueOf) {
    PassPlane plane{name, Image(image_->width, image_->height, kBackground), {}, std::move(note), {}};
    plane.legend.title = name;
    for (std::size_t i = 0; i < plane.image.pixels.size(); ++i) {
      if (image_->sees(i)) plane.image.pixels[i] = colorOf(i);
    }
    plane.value = [image = image_, valueOf](int column, int row) {
      if (column < 0 || row < 0 || column >= image->width || row >= image->height) return std::string();
      const auto i =
          static_cast<std::size_t>(row) * static_cast<std::size_t>(image->width) + static_cast<std::size_t>(column);
      if (image->sees(i)) return valueOf(i);
      const bool gaveUp = std::binary_search(image->unresolved.begin(), image->unresolved.end(), i);
      return std::string(gaveUp ? "unresolved" : "nothing");
    };
    planes_.push_back(std::move(plane));
  }

  void addDistance() {
    const std::vector<float>& distance = image_->planes.depth;
    const ScaleRange span = spanOf(distance);
    const double scale = span.high > span.low ? 1 / std::log(span.high / span.low) : 0;
    add(
        image_->ofSensor ? "range" : "depth", fmt::format("{:.2g} to {:.3g} m, by its logarithm", span.low, span.high),
        [&](std::size_t i) { return viridis(std::log(std::max(double{distance[i]}, 1e-9) / span.low) * scale); },
        [&distance](std::size_t i) { return fmt::format("{:.2f} m", distance[i]); });
  }

  template <class Id, class ColorOf, class ValueOf>
  void addIds(const char* name, const char* note, const std::vector<Id>& ids, const ColorOf& colorOf,
              const ValueOf& valueOf) {
    if (ids.empty()) return;
    add(
        name, note, [&](std::size_t i) { return colorOf(ids[i]); },
        [&ids, valueOf](std::size_t i) { return valueOf(ids[i]); });
  }

  // Adds to the legend of the last plane the ids that occur in the image, the most frequent first.
  template <class Id, class ColorOf, class NameOf>
  void addEntries(const std::vector<Id>& ids, const ColorOf& colorOf, const NameOf& nameOf) {
    if (ids.empty()) return;
    std::map<Id, std::uint64_t> seen;
    for (std::size_t i = 0; i < ids.size(); ++i) {
      if (image_->sees(i)) ++seen[ids[i]];
    }
    std::vector<LegendEntry>& entries = planes_.back().legend.entries;
    for (const auto& [id, pixels] : seen) entries.push_back({nameOf(id), colorOf(id), std::int64_t{id}, pixels});
    std::ranges::stable_sort(entries, std::greater<>(), &LegendEntry::points);
  }

  void addShare(const char* name, const std::vector<float>& values) {
    if (values.empty()) return;
    const double most = std::max(1.0, double{*std::ranges::max_element(values)});
    add(
        name, fmt::format("0 to {:.3g}", most), [&](std::size_t i) { return viridis(values[i] / most); },
        [&values](std::size_t i) { return fmt::format("{:.3g}", values[i]); });
    planes_.back().legend.scale = true;
    planes_.back().legend.high = most;
  }

  std::shared_ptr<const ExrImage> image_;
  std::vector<PassPlane> planes_;
};

}  // namespace

std::vector<PassPlane> readExrPlanes(const std::filesystem::path& file, const Ontology* ontology,
                                     const std::vector<std::string>& materials) {
  return PlaneMaker(readExr(file, ontology, materials)).make();
}

// Draws all planes of the file. Scales them without interpolation, since ids must not be interpolated.
Image drawExr(const std::filesystem::path& file, const Ontology* ontology, int width) {
  constexpr double kReadableShare = 1.0 / 7;  // least height of a plane of hits divided by its width
  constexpr int kInOneRow = 4;
  constexpr double kLetter = 18;      // height of letters in pixels
  constexpr int kTitleHeight = 30;    // height of the title in pixels
  constexpr int kCaptionHeight = 26;  // height of the caption above each plane in pixels
  constexpr int kGap = 8;             // space between planes in pixels
  const auto image = readExr(file, ontology, {});
  const std::vector<PassPlane> planes = PlaneMaker(image).make();
  const auto count = static_cast<int>(planes.size());
  const int columns = image->ofSensor ? 1 : count <= kInOneRow ? count : (count + 1) / 2;
  const int rows = (count + columns - 1) / columns;
  const int tileWidth = (width - kGap * (columns + 1)) / columns;
  const double share = static_cast<double>(image->height) / image->width;
  const double shownShare = image->ofSensor ? std::max(kReadableShare, share) : share;
  const int tileHeight = std::clamp(static_cast<int>(std::lround(tileWidth * shownShare)), 1, 8192);
  const int rowHeight = kCaptionHeight + tileHeight + kGap;
  const int height = kTitleHeight + rows * rowHeight;
  PictureBoard board(width, height, kLetter);
  for (std::size_t i = 0; i < planes.size(); ++i) board.setImage(static_cast<ImageId>(i), planes[i].image);
  return board.draw([&] {
    titleRow({0, 0, width, kTitleHeight}, fmt::format("{}, {}", file.filename().string(), image->size), "");
    panelAt("##planes", {0, kTitleHeight, width, height - kTitleHeight}, false, [&] {
      for (int i = 0; i < count; ++i) {
        const PassPlane& plane = planes[static_cast<std::size_t>(i)];
        const int x = kGap + i % columns * (tileWidth + kGap);
        const int y = kTitleHeight + i / columns * rowHeight;
        wordsAt(x, y + 4, tileWidth, plane.note.empty() ? plane.name : fmt::format("{}, {}", plane.name, plane.note));
        imageAt(static_cast<ImageId>(i), {x, y + kCaptionHeight, tileWidth, tileHeight});
      }
    });
  });
}

}  // namespace scanmill
