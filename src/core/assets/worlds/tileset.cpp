#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <utility>

#include "assets/meshes/asset_parts.h"
#include "assets/meshes/gltf/pose.h"
#include "assets/meshes/gltf/reader.h"
#include "assets/meshes/references.h"
#include "assets/worlds/world_asset.h"
#include "base/earth.h"
#include "base/error.h"
#include "base/file.h"
#include "base/format_support.h"
#include "base/input_budget.h"
#include "config/text.h"

namespace scanmill {
namespace {

using Json = nlohmann::json;
constexpr int kDeepestTile = 64;  // largest depth of nested tiles, including those of nested tilesets

class TilesetReader {
 public:
  explicit TilesetReader(const AssetOptions& options)
      : options_(options), metresFromUnits_{Mat3::scale(Vec3d{1, 1, 1} * options.metresPerUnit), {}} {}

  Asset read(const std::filesystem::path& file) {
    if (options_.up) fail(file, "states its up axis: leave out `up`");
    asset_.upDeclared = true;
    asset_.statedUnit = 1;
    readTileset(file, {}, {}, Refine::Replace, 0);
    reportMissing(missing_, options_.leaveOutMissing, leftOut_);
    leftOut_.warn(file.string());
    leftOutOfTiles_.warn(file.string());
    return std::move(asset_);
  }

 private:
  enum class Refine { Replace, Add };  // Add: a tile is kept beside its children

  struct Tileset {
    std::filesystem::path file;
    std::filesystem::path folder;  // folder of `file`, relative to the outermost tileset's folder
    Mat3 zUpFromGltf;
  };

  [[noreturn]] static void fail(const std::filesystem::path& file, const std::string& problem) {
    throw InputError({file.string()}, problem);
  }

  // Adds the tiles of a tileset.json. `folder`: see Tileset. `earthFromParent`: the transform of the tile that names
  // the tileset. `inherited`: the refinement of tiles that state none. `depth`: the number of tiles around the tileset.
  void readTileset(const std::filesystem::path& file, const std::filesystem::path& folder,
                   const Affine& earthFromParent, Refine inherited, int depth) {
    const std::filesystem::path canonical = std::filesystem::weakly_canonical(file);
    if (!openTilesets_.insert(canonical).second) fail(file, "is a tileset that includes itself");
    try {
      const Json json = Json::parse(readFile(file));
      const auto asset = json.find("asset");
      if (asset == json.end() || !json.contains("root"))
        fail(file, "is not a tileset: the keys asset and root are missing");
      const std::string version = asset->value("version", std::string());
      if (version != "1.0" && version != "1.1")
        fail(file, fmt::format("is a tileset of the version '{}': only 1.0 and 1.1 are read", version));
      const std::string up = asset->value("gltfUpAxis", std::string("Y"));
      if (up != "X" && up != "Y" && up != "Z")
        fail(file, fmt::format("has the gltfUpAxis '{}', but it must be X, Y or Z", up));
      countUnread(json);
      countUnread(*asset);
      const Tileset tileset{file, folder, zUpFrom(up == "X" ? 'x' : up == "Y" ? 'y' : 'z')};
      readTile(json.at("root"), tileset, earthFromParent, inherited, depth);
    } catch (const Json::exception& e) {
      fail(file, fmt::format("is not a tileset: {}", reasonOf(e)));
    }
    openTilesets_.erase(canonical);
  }

  // Counts the keys and extensions of an object that are left out.
  void countUnread(const Json& object) {
    for (const auto& [key, value] : object.items()) {
      if (key != "extensions") leftOut_.addKeyword(kTilesetFormat, key);
    }
    const auto extensions = object.find("extensions");
    if (extensions == object.end()) return;
    for (const auto& [name, value] : extensions->items()) leftOut_.addKeyword(kTilesetFormat, name);
  }

  // Returns the middle (earth frame) of a region, box or sphere; the tile's origin if the volume is none of these; the
  // earth's centre if a region is too large to be projected onto one plane.
  static Vec3d middleOf(const Json& volume, const Affine& earthFromTile) {
    if (const auto region = volume.find("region"); region != volume.end()) {
      auto [west, south, east, north, lowest, highest] = region->get<std::array<double, 6>>();  // rad, m
      if (std::max({west, south, east, north}) > 2 * kPi || std::min({west, south, east, north}) < -2 * kPi) {
        throw Error("the region of a bounding volume must be in radians, but has numbers of more than a turn");
      }
      if (east < west) east += 2 * kPi;  // the region crosses the date line
      constexpr double kLargest = 2;     // rad, chosen by eye: a continent
      if (east - west > kLargest || north - south > kLargest) return {};
      return earthCentred((west + east) / 2, (south + north) / 2, (lowest + highest) / 2);
    }
    if (const auto box = volume.find("box"); box != volume.end()) {
      const auto numbers = box->get<std::vector<double>>();  // middle and half axes
      if (numbers.size() != 12) throw Error("a bounding box of 3D Tiles must have 12 numbers");
      return earthFromTile * Vec3d{numbers[0], numbers[1], numbers[2]};
    }
    const auto [x, y, z, radius] = volume.value("sphere", std::array<double, 4>{});
    return earthFromTile * Vec3d{x, y, z};
  }

  // Adds a tile: its meshes if it has no children or is refined by ADD, its nested tilesets, and all tiles below it.
  // The first tile on the earth sets assetFromEarth_. Parameters: see readTileset().
  void readTile(const Json& tile, const Tileset& tileset, const Affine& earthFromParent, Refine inherited, int depth) {
    if (depth > kDeepestTile)
      fail(tileset.file, fmt::format("has tiles that are nested more than {} levels deep", kDeepestTile));
    chargeCopies(1, {tileset.file.string()});
    const Json extensions = tile.value("extensions", Json::object());
    if (tile.contains("implicitTiling") || extensions.contains("3DTILES_implicit_tiling")) {
      fail(tileset.file,
           "has implicit tiling, which is not supported: convert it to explicit tiles, for example by 3d-tiles-tools");
    }
    constexpr std::array<double, 16> kIdentity{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
    const Affine earthFromTile = earthFromParent * gltf::toAffine(tile.value("transform", kIdentity).data());
    if (!assetFromEarth_) {
      const Vec3d middle = middleOf(tile.value("boundingVolume", Json::object()), earthFromTile);
      if (isOnEarth(middle)) {
        assetFromEarth_ = metresFromUnits_ * eastNorthUp(middle);
        asset_.ownMiddle = true;
        asset_.system = fmt::format("earth-centred [{:.2f}, {:.2f}, {:.2f}] m", middle.x, middle.y, middle.z);
      }
    }
    const std::string statedRefine = tile.value("refine", std::string());
    const std::string refineName = lowerCase(statedRefine);
    if (!refineName.empty() && refineName != "add" && refineName != "replace") {
      fail(tileset.file, fmt::format("has the refine '{}', but it must be ADD or REPLACE", statedRefine));
    }
    const Refine refine = refineName.empty() ? inherited : refineName == "add" ? Refine::Add : Refine::Replace;
    countUnread(tile);
    const auto children = tile.find("children");
    const bool isLeaf = children == tile.end() || children->empty();
    for (const std::string& uri : contentsOf(tile, extensions)) {
      const bool isTileset = uri.substr(0, uri.find('?')).ends_with(".json");
      if (isLeaf || isTileset || refine == Refine::Add) readContent(uri, tileset, earthFromTile, refine, depth);
    }
    if (isLeaf) return;
    for (const Json& child : *children) readTile(child, tileset, earthFromTile, refine, depth + 1);
  }

  // Returns the URIs of a tile's contents. Counts the keys and extensions of these contents that are left out.
  std::vector<std::string> contentsOf(const Json& tile, const Json& extensions) {
    std::vector<std::string> uris;
    const auto addContent = [&](const Json& content) {
      countUnread(content);
      uris.push_back(content.at(content.contains("uri") ? "uri" : "url").get<std::string>());
    };
    if (const auto content = tile.find("content"); content != tile.end()) addContent(*content);
    for (const Json& content : tile.value("contents", Json::array())) addContent(content);
    const Json multiple = extensions.value("3DTILES_multiple_contents", Json::object());
    for (const char* key : {"content", "contents"}) {  // the names in drafts and in the extension
      for (const Json& content : multiple.value(key, Json::array())) addContent(content);
    }
    return uris;
  }

  // Adds the content of a tile: a mesh, or the tiles of a nested tileset. Counts contents that are missing or not read.
  void readContent(const std::string& uri, const Tileset& tileset, const Affine& earthFromTile, Refine refine,
                   int depth) {
    const Location where{tileset.file.string()};
    if (uri.starts_with("http://") || uri.starts_with("https://")) {
      return missing_.push_back(
          {where, uri, fmt::format("names '{}', which is not a local file: download the tileset", uri)});
    }
    const std::string relativePath = decodeUri(uri.substr(0, uri.find('?')));
    const std::filesystem::path file = tileset.file.parent_path() / relativePath;
    if (!isFile(file)) {
      return missing_.push_back({where, uri, fmt::format("names '{}', but this file does not exist", uri)});
    }
    const std::string kind = lowerExtension(file);
    const std::filesystem::path name = tileset.folder / relativePath;
    if (kind == ".json") return readTileset(file, name.parent_path(), earthFromTile, refine, depth + 1);
    if (kind != ".b3dm" && kind != ".glb" && kind != ".gltf") return leftOut_.addKeyword(kTilesetFormat, kind);
    if (!assetFromEarth_) assetFromEarth_ = metresFromUnits_;
    Asset mesh = gltf::readTile(file, *assetFromEarth_ * earthFromTile, tileset.zUpFromGltf, options_, leftOutOfTiles_);
    // Without a middle, assetFromEarth_ only scales, so that meshes on the earth are far from the asset's origin.
    if (!asset_.ownMiddle && isOnEarth(inverse(*assetFromEarth_) * boundsOf(mesh).center())) {
      fail(tileset.file,
           "its bounding volumes do not say where on the earth it lies: add a region, box or sphere to its root");
    }
    addParts(std::move(mesh), file, name.string());
  }

  // Adds the parts of a tile's content. The names of their nodes get the prefix `name`, the name of the content.
  void addParts(Asset mesh, const std::filesystem::path& file, const std::string& name) {
    asset_.dropped += mesh.dropped;
    flatten(mesh);
    std::uint32_t nodes = 0;
    for (AssetPart& part : mesh.parts) {
      nodes = std::max(nodes, part.nodeIndex + 1);
      part.nodeIndex += nodes_;
      part.node = part.node.empty() ? name : fmt::format("{}/{}", name, part.node);
      chargeBytes(kBytesPerTriangle * static_cast<double>(part.triangles.size()), {file.string()});
      asset_.parts.push_back(std::move(part));
    }
    nodes_ += nodes;
  }

  const AssetOptions& options_;
  Affine metresFromUnits_;
  // The transform from the earth frame to east, north, up at the middle of the first tile on the earth (usually the
  // root; not if the root's volume is the globe). If a mesh comes before such a tile, metresFromUnits_ instead.
  std::optional<Affine> assetFromEarth_;
  Asset asset_;
  std::set<std::filesystem::path> openTilesets_;  // the tileset that is being read, and all tilesets around it
  LeftOut leftOut_;
  LeftOut leftOutOfTiles_;  // what is left out of the tiles' contents
  std::vector<MissingFileError> missing_;
  std::uint32_t nodes_ = 0;  // number of node indices used so far
};

}  // namespace

const FormatSupport kTilesetFormat{
    "3D Tiles",
    "tileset.json",
    "Tiles (.glb, .gltf, .b3dm), nested tilesets and their places. With the refine REPLACE the finest tiles alone, "
    "with ADD coarser tiles too. Implicit tilings are refused",
    "",
    {.read = {"asset version gltfUpAxis root boundingVolume transform children refine content contents uri url",
              "3DTILES_multiple_contents 3DTILES_content_gltf"},
     .unused = {"geometricError viewerRequestVolume properties statistics tilesetVersion extras",
                "3DTILES_bounding_volume_S2 extensionsUsed extensionsRequired"},
     .leftOut = {{".i3dm", "instanced models (.i3dm)"},
                 {".pnts", "point clouds (.pnts)"},
                 {".cmpt", "composite tiles (.cmpt)"},
                 {".geom", "tiles of simple shapes (.geom)"},
                 {".vctr", "vector tiles (.vctr)"},
                 {"metadata group groups schema schemaUri 3DTILES_metadata", "metadata"}}}};

Asset readTileset(const std::filesystem::path& file, const AssetOptions& options) {
  try {
    return TilesetReader(options).read(file);
  } catch (const InputError&) {
    throw;
  } catch (const Error& e) {
    throw InputError({file.string()}, e.what());
  }
}

}  // namespace scanmill
