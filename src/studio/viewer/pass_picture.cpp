#include "viewer/pass_picture.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <optional>
#include <utility>
#include <variant>

#include "base/error.h"
#include "passes/exr/exr_file.h"
#include "passes/exr/hits_exr.h"
#include "passes/exr/pass_exr.h"
#include "viewer/color_map.h"
#include "viewer/panels/board.h"
#include "viewer/panels/parts.h"

namespace scanmill {

namespace {

// A plane of an image: its name, what its colours span, the colour of each pixel, and its value with its unit.
struct Plane {
  std::string name;
  std::string note;
  std::function<Rgb(std::size_t)> color;
  std::function<std::string(std::size_t)> value;
  double most = 0;  // of a scale from 0; 0: there is none
};

const char* const kNothing = "nothing";

struct Size {
  int width = 0;
  int height = 0;
};

constexpr double kLetter = 18;      // px
constexpr int kTitleHeight = 30;    // px
constexpr int kCaptionHeight = 26;  // px, above each plane
constexpr int kGap = 8;             // px

std::string captionOf(const Plane& plane) {
  return plane.note.empty() ? plane.name : fmt::format("{}, {}", plane.name, plane.note);
}

Image imageOf(const Plane& plane, const Size& size) {
  Image image(size.width, size.height, kBackground);
  for (std::size_t i = 0; i < image.pixels.size(); ++i) image.pixels[i] = plane.color(i);
  return image;
}

// Enlarged or not, each pixel is one of the plane's: an id must not be mixed with another.
Image drawPlanes(const std::vector<Plane>& planes, const Size& size, int across, int width, double stretch,
                 const std::string& title) {
  const int columns = std::min<int>(across, static_cast<int>(planes.size()));
  const int rows = (static_cast<int>(planes.size()) + columns - 1) / columns;
  const int tileWidth = (width - kGap * (columns + 1)) / columns;
  const double scale = static_cast<double>(tileWidth) / size.width;
  const int tileHeight = std::clamp(static_cast<int>(std::lround(size.height * scale * stretch)), 1, 8192);
  const int rowHeight = kCaptionHeight + tileHeight + kGap;
  const int height = kTitleHeight + rows * rowHeight;
  PictureBoard board(width, height, kLetter);
  for (std::size_t i = 0; i < planes.size(); ++i) board.setImage(static_cast<ImageId>(i), imageOf(planes[i], size));
  return board.draw([&] {
    titleRow({0, 0, width, kTitleHeight}, title, "");
    panelAt("##planes", {0, kTitleHeight, width, height - kTitleHeight}, false, [&] {
      for (std::size_t i = 0; i < planes.size(); ++i) {
        const int x = kGap + static_cast<int>(i) % columns * (tileWidth + kGap);
        const int y = kTitleHeight + static_cast<int>(i) / columns * rowHeight;
        wordsAt(x, y + 4, tileWidth, captionOf(planes[i]));
        imageAt(static_cast<ImageId>(i), {x, y + kCaptionHeight, tileWidth, tileHeight}, {}, {});
      }
    });
  });
}

struct Span {
  double low = 1;
  double high = 1;
};

// 1st and 99th percentile of what is seen; every 97th pixel will do.
Span spanOf(const std::vector<float>& values) {
  std::vector<float> seen;
  for (std::size_t i = 0; i<values.size(); i += values.size()> 100'000 ? 97 : 1) {
    if (std::isfinite(values[i]) && values[i] > 0) seen.push_back(values[i]);
  }
  if (seen.empty()) return {};
  std::sort(seen.begin(), seen.end());
  const auto at = [&](double share) {
    return double{seen[static_cast<std::size_t>(share * static_cast<double>(seen.size() - 1))]};
  };
  return {at(0.01), at(0.99)};
}

Plane distancePlane(const char* name, const std::vector<float>& distance) {
  const Span span = spanOf(distance);
  const double scale = span.high > span.low ? 1 / std::log(span.high / span.low) : 0;
  return {name, fmt::format("{:.2g} to {:.3g} m, by its logarithm", span.low, span.high),
          [=, &distance](std::size_t i) {
            const double d = distance[i];
            return std::isfinite(d) ? viridis(std::log(std::max(d, 1e-9) / span.low) * scale) : kBackground;
          },
          [&distance](std::size_t i) {
            return std::isfinite(distance[i]) ? fmt::format("{:.2f} m", distance[i]) : kNothing;
          }};
}

Plane normalPlane(const std::vector<Vec3f>& normal) {
  return {"normal", "x red, y green, z blue",
          [&normal](std::size_t i) {
            const Vec3f n = normal[i];
            if (n == Vec3f{}) return kBackground;
            const auto byte = [](float c) { return static_cast<std::uint8_t>(std::lround(127.5 + 127.5 * c)); };
            return Rgb{byte(n.x), byte(n.y), byte(n.z)};
          },
          [&normal](std::size_t i) {
            const Vec3f n = normal[i];
            return n == Vec3f{} ? kNothing : fmt::format("{:.3f}, {:.3f}, {:.3f}", n.x, n.y, n.z);
          }};
}

Plane semanticPlane(const std::vector<std::uint16_t>& ids, const std::vector<float>& distance,
                    const Ontology* ontology) {
  return {"semantic", ontology == nullptr ? "a colour each" : "",
          [&ids, &distance, ontology](std::size_t i) {
            return std::isfinite(distance[i]) ? classColor(ontology, ids[i]) : kBackground;
          },
          [&ids, &distance, ontology](std::size_t i) {
            if (!std::isfinite(distance[i])) return std::string(kNothing);
            const SemanticClass* known = ontology == nullptr ? nullptr : ontology->find(ids[i]);
            return known == nullptr ? fmt::format("class {}", ids[i]) : fmt::format("{} ({})", known->name, ids[i]);
          }};
}

template <class Id>
Plane idPlane(const char* name, const std::vector<Id>& ids, const std::vector<float>& distance, bool zeroIsNone) {
  return {name, "a colour each",
          [&ids, &distance, zeroIsNone](std::size_t i) {
            if (!std::isfinite(distance[i])) return kBackground;
            return instanceColor(zeroIsNone ? ids[i] : ids[i] + 1u);
          },
          [&ids, &distance, zeroIsNone](std::size_t i) {
            if (!std::isfinite(distance[i])) return std::string(kNothing);
            return zeroIsNone && ids[i] == 0 ? std::string("none") : fmt::format("{}", ids[i]);
          }};
}

Plane sharePlane(const char* name, const std::vector<float>& values, const std::vector<float>& distance) {
  double most = 1;
  for (const float v : values) most = std::max(most, double{v});
  return {name, fmt::format("0 to {:.3g}", most),
          [&values, &distance, most](std::size_t i) {
            return std::isfinite(distance[i]) ? viridis(values[i] / most) : kBackground;
          },
          [&values, &distance](std::size_t i) {
            return std::isfinite(distance[i]) ? fmt::format("{:.3g}", values[i]) : kNothing;
          },
          most};
}

// Planes that hits and pass images have in common, but for the distance.
template <class Planes>
void addPlanes(const Planes& p, const std::vector<float>& distance, const Ontology* ontology,
               std::vector<Plane>& planes) {
  if (!p.normal.empty()) planes.push_back(normalPlane(p.normal));
  if (!p.semantic.empty()) planes.push_back(semanticPlane(p.semantic, distance, ontology));
  if (!p.instance.empty()) planes.push_back(idPlane("instance", p.instance, distance, true));
  if (!p.material.empty()) planes.push_back(idPlane("material", p.material, distance, false));
  if (!p.primitive.empty()) planes.push_back(idPlane("primitive", p.primitive, distance, false));
  if (!p.reflectance.empty()) planes.push_back(sharePlane("reflectance", p.reflectance, distance));
  if (!p.roughness.empty()) planes.push_back(sharePlane("roughness", p.roughness, distance));
  if (!p.metallic.empty()) planes.push_back(sharePlane("metallic", p.metallic, distance));
  if (!p.retroreflectance.empty()) planes.push_back(sharePlane("retroreflectance", p.retroreflectance, distance));
}

// They refer to the image.
std::vector<Plane> planesOf(const PassImage& image, const Ontology* ontology) {
  std::vector<Plane> planes{distancePlane("depth", image.planes.depth)};
  addPlanes(image.planes, image.planes.depth, ontology, planes);
  return planes;
}

std::vector<Plane> planesOf(const Hits& hits, const Ontology* ontology) {
  std::vector<Plane> planes{distancePlane("range", hits.range)};
  planes[0].value = [&hits, known = planes[0].value](std::size_t i) {
    const bool gaveUp = std::binary_search(hits.unresolved.begin(), hits.unresolved.end(), i);
    return gaveUp ? std::string("unresolved") : known(i);
  };
  addPlanes(hits, hits.range, ontology, planes);
  if (!hits.incidence.empty()) planes.push_back(sharePlane("cosine of the incidence", hits.incidence, hits.range));
  return planes;
}

Size sizeOf(const PassImage& image) {
  return {static_cast<int>(image.camera.width), static_cast<int>(image.camera.height)};
}

Size sizeOf(const Hits& hits) {
  return {static_cast<int>(hits.columns), static_cast<int>(hits.rings)};
}

using PassesOrHits = std::variant<PassImage, Hits>;

PassesOrHits readExr(const std::filesystem::path& file) {
  const ExrReader header(file);
  const auto& channels = header.channels();
  const auto has = [&](const char* name) {
    return std::any_of(channels.begin(), channels.end(), [&](const ExrChannel& c) { return c.name == name; });
  };
  if (!has("range")) return readPasses(file, passesIn(file));
  Channels there = Channel::Range;
  const std::pair<const char*, Channel> known[] = {
      {"N.X", Channel::Normal},          {"instance", Channel::Instance},   {"semantic", Channel::Semantic},
      {"material", Channel::Material},   {"primitive", Channel::Primitive}, {"reflectance", Channel::Reflectance},
      {"incidence", Channel::Incidence},
  };
  for (const auto& [name, channel] : known) {
    if (has(name)) there |= channel;
  }
  Hits hits;
  readHits(file, there, hits);
  return hits;
}

// What the values of planes need for as long as somebody asks for them.
struct ExrContents {
  PassesOrHits image;
  std::optional<Ontology> ontology;
  std::vector<std::string> materials;
};

const PassPlanes& planesIn(const PassImage& image) {
  return image.planes;
}

const Hits& planesIn(const Hits& hits) {
  return hits;
}

const std::vector<float>& distancesOf(const PassPlanes& planes) {
  return planes.depth;
}

const std::vector<float>& distancesOf(const Hits& hits) {
  return hits.range;
}

std::string materialName(const std::vector<std::string>& materials, std::uint16_t id) {
  return id < materials.size() ? materials[id] : fmt::format("material {}", id);
}

// Values with names, where these are known.
template <class Image>
void nameMaterials(const Image& image, const std::vector<std::string>& materials, std::vector<Plane>& planes) {
  if (materials.empty()) return;
  for (Plane& plane : planes) {
    if (plane.name != "material") continue;
    plane.note = "";
    plane.value = [&image, &materials](std::size_t i) {
      if (!std::isfinite(distancesOf(image)[i])) return std::string(kNothing);
      return fmt::format("{} ({})", materialName(materials, image.material[i]), image.material[i]);
    };
  }
}

// Named colours of the ids that are seen, the most frequent first.
template <class Id, class NameOf, class ColorOf>
std::vector<LegendEntry> entriesOf(const std::vector<Id>& ids, const std::vector<float>& distance, const NameOf& nameOf,
                                   const ColorOf& colorOf) {
  std::map<Id, std::uint64_t> seen;
  for (std::size_t i = 0; i < ids.size(); ++i) {
    if (std::isfinite(distance[i])) ++seen[ids[i]];
  }
  std::vector<LegendEntry> entries;
  entries.reserve(seen.size());
  for (const auto& [id, pixels] : seen) entries.push_back({nameOf(id), colorOf(id), std::int64_t{id}, pixels});
  std::stable_sort(entries.begin(), entries.end(),
                   [](const LegendEntry& a, const LegendEntry& b) { return a.points > b.points; });
  return entries;
}

template <class Image>
Legend legendOf(const Plane& plane, const Image& image, const Ontology* ontology,
                const std::vector<std::string>& materials) {
  Legend legend;
  legend.title = plane.name;
  const std::vector<float>& distance = distancesOf(image);
  if (plane.name == "semantic") {
    legend.entries = entriesOf(
        image.semantic, distance,
        [&](std::uint16_t id) {
          const SemanticClass* known = ontology == nullptr ? nullptr : ontology->find(id);
          return known == nullptr ? fmt::format("class {}", id) : known->name;
        },
        [&](std::uint16_t id) { return classColor(ontology, id); });
  } else if (plane.name == "material") {
    legend.entries = entriesOf(
        image.material, distance, [&](std::uint16_t id) { return materialName(materials, id); },
        [](std::uint16_t id) { return instanceColor(id + 1u); });
  } else if (plane.most > 0) {
    legend.scale = true;
    legend.high = plane.most;
  }
  return legend;
}

}  // namespace

Image drawPasses(const PassImage& image, const Ontology* ontology, int width, const std::string& title) {
  constexpr std::size_t kInOneRow = 4;
  const std::vector<Plane> planes = planesOf(image, ontology);
  const Camera& c = image.camera;
  return drawPlanes(planes, sizeOf(image), planes.size() <= kInOneRow ? 4 : (static_cast<int>(planes.size()) + 1) / 2,
                    width, 1,
                    fmt::format("{}, {} x {} pixels, {:.1f} x {:.1f} degrees", title, c.width, c.height,
                                degrees(c.horizontalField()), degrees(c.verticalField())));
}

Image drawHits(const Hits& hits, const Ontology* ontology, int width, const std::string& title) {
  constexpr double kReadableShare = 1.0 / 7;  // height over width
  const double share = static_cast<double>(hits.rings) / hits.columns;
  return drawPlanes(planesOf(hits, ontology), sizeOf(hits), 1, width, std::max(kReadableShare / share, 1.0),
                    fmt::format("{}, {} rings x {} columns", title, hits.rings, hits.columns));
}

Image drawExr(const std::filesystem::path& file, const Ontology* ontology, int width) {
  const std::string title = file.filename().string();
  const PassesOrHits image = readExr(file);
  if (const Hits* hits = std::get_if<Hits>(&image)) return drawHits(*hits, ontology, width, title);
  return drawPasses(std::get<PassImage>(image), ontology, width, title);
}

std::vector<PassPlane> readExrPlanes(const std::filesystem::path& file, const Ontology* ontology,
                                     const std::vector<std::string>& materials) {
  const auto contents = std::make_shared<ExrContents>();
  contents->image = readExr(file);
  if (ontology != nullptr) contents->ontology = *ontology;
  contents->materials = materials;
  const Ontology* classes = contents->ontology ? &*contents->ontology : nullptr;
  const Size size = std::visit([](const auto& image) { return sizeOf(image); }, contents->image);
  std::vector<Plane> planes = std::visit([&](const auto& image) { return planesOf(image, classes); }, contents->image);
  std::visit([&](const auto& image) { nameMaterials(planesIn(image), contents->materials, planes); }, contents->image);
  std::vector<PassPlane> out;
  for (const Plane& plane : planes) {
    PassPlane& made =
        out.emplace_back(PassPlane{plane.name, Image(size.width, size.height, kBackground), {}, plane.note, {}});
    for (std::size_t i = 0; i < made.image.pixels.size(); ++i) made.image.pixels[i] = plane.color(i);
    std::visit([&](const auto& image) { made.legend = legendOf(plane, planesIn(image), classes, contents->materials); },
               contents->image);
    made.value = [contents, plane, from = size](int column, int row) {
      if (column < 0 || row < 0 || column >= from.width || row >= from.height) return std::string();
      const auto pixel = static_cast<std::size_t>(row) * static_cast<std::size_t>(from.width);
      return fmt::format("{}: {}", plane.name, plane.value(pixel + static_cast<std::size_t>(column)));
    };
  }
  return out;
}

}  // namespace scanmill
