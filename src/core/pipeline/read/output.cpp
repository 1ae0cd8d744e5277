// Reads the key `output` of a pipeline: the contents and formats of samples, and their distribution over shards.

#include <array>
#include <cmath>
#include <optional>
#include <set>

#include "config/fields.h"
#include "pipeline/read/pipeline.h"

namespace scanmill {

namespace {

// Reads the voxel grid. Its keys and their defaults (m) are {size: 0.2, from: [0, -25.6, -2], to: [51.2, 25.6, 4.4]}.
VoxelGrid readVoxelGrid(const Value& value) {
  VoxelGrid grid;
  Fields fields(value, "voxels");
  fields.also({"size", "from", "to"}).finish();
  grid.size = fields.number("size", {0.01, 100}, grid.size);
  grid.low = fields.vec3("from", grid.low);
  const Vec3d high = fields.vec3("to", {51.2, 25.6, 4.4});
  const std::array<double, 3> lengths{high.x - grid.low.x, high.y - grid.low.y, high.z - grid.low.z};
  constexpr double kRounding = 1e-6;  // tolerance for rounding errors, as a fraction of the grid's length
  double voxelCount = 1;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (lengths[axis] <= 0) {
      throw InputError(value.where, "voxels: `to` must be greater than `from` along x, y and z, but is not along {}",
                       "xyz"[axis]);
    }
    const double count = std::round(lengths[axis] / grid.size);
    if (count < 1 || std::abs(count * grid.size - lengths[axis]) > kRounding * grid.size * count) {
      throw InputError(value.where,
                       "voxels: the {:g} m along {} are not a whole number of voxels of {:g} "
                       "m: change `from`, `to` or `size`",
                       lengths[axis], "xyz"[axis], grid.size);
    }
    voxelCount *= count;
    constexpr double kMostVoxels = 64e6;
    if (voxelCount > kMostVoxels)
      throw InputError(value.where,
                       "voxels: the grid has more than 64 million voxels: take larger voxels, or a smaller grid");
    grid.counts[axis] = static_cast<std::uint32_t>(count);
  }
  return grid;
}

// Reads true (the default grid), false (none) or a grid.
std::optional<VoxelGrid> readVoxels(const Value& value) {
  if (value.kind == Value::Kind::Map) return readVoxelGrid(value);
  if (value.kind == Value::Kind::Scalar && value.text != "true" && value.text != "false") {
    throw InputError(value.where,
                     "voxels must be true, false or a grid such as {size: 0.2, from: [0, -25.6, -2], to: "
                     "[51.2, 25.6, 4.4]}");
  }
  return readBool(value, "output: voxels") ? std::optional(VoxelGrid()) : std::nullopt;
}

// Reads true (road users), false (none) or {classes: all or a list}.
std::optional<ListedObjects> readObjects(const Value& value) {
  if (value.kind != Value::Kind::Map) {
    if (value.kind != Value::Kind::Scalar || (value.text != "true" && value.text != "false")) {
      throw InputError(value.where, "objects must be true, false or {{classes: all}}, or a list in place of `all`");
    }
    return value.text == "true" ? std::optional(ListedObjects{.where = value.where}) : std::nullopt;
  }
  Fields fields(value, "output: objects");
  ListedObjects listed{.where = fields.require("classes").where};
  listed.classes = fields.texts("classes");
  fields.finish();
  if (listed.classes.empty()) throw InputError(listed.where, "classes is empty: name some, or `all`");
  listed.all = listed.classes == std::vector<std::string>{"all"};
  if (listed.all) listed.classes.clear();
  return listed;
}

ColumnSet readColumns(const Value& list) {
  if (list.kind != Value::Kind::Sequence) throw InputError(list.where, "columns must be a list of names");
  ColumnSet columns;
  for (const Value& item : list.items) {
    const std::string name = readText(item, "columns");
    const std::size_t column = columnIndex(name);
    if (column == kColumnCount) {
      throw InputError(item.where, "unknown column '" + name + "'" + suggestion(name, ColumnSet::all().names()));
    }
    columns.add(column);
  }
  return columns;
}

}  // namespace

Output readOutput(const Value& value) {
  Output output;
  Fields fields(value, "output");
  fields.also({"layout", "columns", "formats", "shard_mb", "shard_samples", "shuffle", "reasons", "objects", "voxels"})
      .finish();
  output.layout.organised = fields.choice("layout", {"dense", "organised"}, "dense") == "organised";
  output.layout.reasons = fields.boolean("reasons", false);
  if (const Value* objects = fields.find("objects")) output.objects = readObjects(*objects);
  if (const Value* voxels = fields.find("voxels")) output.voxels = readVoxels(*voxels);
  if (const Value* list = fields.find("columns")) output.layout.columns = readColumns(*list);
  std::set<std::string> suffixes;
  for (const Value& item : readList(fields.require("formats"), "formats")) {
    const NamedOptions named = readNamed(item, "a format");
    const FormatEntry& entry = requireFormat(named.name, named.where);
    Fields options(named.options, "format " + named.name);
    options.alsoDescribed(entry.keys).finish();
    output.formats.push_back({&entry, entry.make(options)});
    if (!suffixes.insert(std::string(entry.suffix)).second) {
      throw InputError(named.where, "two formats write '.{}' files", entry.suffix);
    }
  }
  output.shards.bytes = static_cast<std::uint64_t>(fields.number("shard_mb", {1, 1e6}, 256) * 1e6);
  if (fields.has("shard_samples")) {
    fields.refuse({"shard_mb"}, "has no effect beside `shard_samples`: leave it out");
    output.shards.samples = static_cast<std::size_t>(fields.integer("shard_samples", 1, 1'000'000'000));
  }
  output.shards.shuffled = fields.boolean("shuffle", false);
  return output;
}

}  // namespace scanmill
