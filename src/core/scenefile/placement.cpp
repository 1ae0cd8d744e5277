#include "scenefile/placement.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/memory.h"
#include "base/short_text.h"

namespace scanmill {
namespace {

constexpr double kFarthest = 1e9;  // m, largest coordinate; UTM coordinates reach 1e7 m
constexpr double kLeastScale = 1e-9;
constexpr double kLargestScale = 1e9;

// Reads a number, or [x, y, z].
Vec3d readScale(const Value& value) {
  Vec3d scale;
  if (value.kind == Value::Kind::Sequence) {
    scale = readVec3(value, "scale");
  } else {
    const double factor = readNumber(value, "scale");
    scale = {factor, factor, factor};
  }
  for (const double factor : {scale.x, scale.y, scale.z}) {
    if (std::abs(factor) < kLeastScale || std::abs(factor) > kLargestScale) {
      throw InputError(value.where, fmt::format("scale must have an absolute value from 1e-9 to 1e9, not {}", factor));
    }
  }
  return scale;
}

Placement::Copy readCopy(Fields& f) {
  Placement::Copy copy;
  copy.pose = f.pose();
  const Vec3d& p = copy.pose.translation;
  if (std::abs(p.x) > kFarthest || std::abs(p.y) > kFarthest || std::abs(p.z) > kFarthest) {
    throw InputError(f.require("position").where, "position is more than 1e9 m from the origin");
  }
  if (const Value* scale = f.find("scale")) copy.scale = readScale(*scale);
  return copy;
}

void readGrid(const Value& value, Placement& placement) {
  Fields f(value, "grid");
  const Value& count = f.require("count");
  if (count.kind != Value::Kind::Sequence || count.items.size() != 3) {
    throw InputError(count.where, "count must be [nx, ny, nz]");
  }
  for (std::size_t i = 0; i < 3; ++i) {
    placement.gridCount[i] = readInteger(count.items[i], "count", 1, 1'000'000'000);
  }
  placement.gridSpacing = readVec3(f.require("spacing"), "spacing");
  f.finish();
}

void readCopies(const Value& value, Placement& placement) {
  Fields f(value, "copies");
  if (const Value* list = f.find("at")) {
    placement.at.clear();
    for (const Value& item : readList(*list, "at")) {
      Fields fields(item, "copy");
      placement.at.push_back(readCopy(fields));
      fields.finish();
    }
  }
  if (const Value* grid = f.find("grid")) readGrid(*grid, placement);
  f.also({"scatter", "along"}).finish();  // object_placer.h describes these
  const auto& cells = placement.gridCount;
  const double copies = double(cells[0]) * double(cells[1]) * double(cells[2]) * double(placement.at.size());
  if (copies > double(Placement::mostCopies())) {
    throw InputError(value.where,
                     fmt::format("{} x {} x {} grid cells x {} places = {:.4g} copies, but {}", cells[0], cells[1],
                                 cells[2], placement.at.size(), copies, Placement::mostCopiesText()));
  }
}

}  // namespace

std::uint64_t Placement::mostCopies() {
  constexpr std::uint64_t kMost = 10'000'000;
  constexpr std::uint64_t kCopyBytes = 1000;  // of an instance: its name, its poses, and its part of Embree's hierarchy
  return std::min(kMost, memoryLimitBytes() / 2 / kCopyBytes);
}

std::string Placement::mostCopiesText() {
  return fmt::format("at most {} are possible with {} of memory (--memory-limit, the machine or its container)",
                     grouped(mostCopies()), shortBytes(static_cast<double>(memoryLimitBytes())));
}

std::uint64_t Placement::count() const {
  return static_cast<std::uint64_t>(gridCount[0] * gridCount[1] * gridCount[2]) * at.size();
}

void Placement::forEach(const std::function<void(const Affine&)>& visit) const {
  const auto visitCell = [&](const Vec3d& cell) {
    for (const Copy& copy : at) {
      const Pose worldFromCopy = object.pose * Pose{{}, cell} * copy.pose;
      const Vec3d scale{object.scale.x * copy.scale.x, object.scale.y * copy.scale.y, object.scale.z * copy.scale.z};
      visit(toAffine(worldFromCopy) * Affine{Mat3::scale(scale), {}});
    }
  };
  for (std::int64_t k = 0; k < gridCount[2]; ++k) {
    for (std::int64_t j = 0; j < gridCount[1]; ++j) {
      for (std::int64_t i = 0; i < gridCount[0]; ++i) {
        visitCell({double(i) * gridSpacing.x, double(j) * gridSpacing.y, double(k) * gridSpacing.z});
      }
    }
  }
}

Placement readPlacement(Fields& object) {
  Placement placement;
  placement.object = readCopy(object);
  if (const Value* copies = object.find("copies")) readCopies(*copies, placement);
  return placement;
}

std::array<double, 4> readRectangle(const Value& value, std::string_view key) {
  std::vector<double> limits;
  for (const Value& corner : value.items) {
    for (const double coordinate : readNumbers(corner, key)) limits.push_back(coordinate);
  }
  if (value.kind != Value::Kind::Sequence || limits.size() != 4 || limits[0] >= limits[2] || limits[1] >= limits[3]) {
    throw InputError(value.where, fmt::format("{} must be [[x, y], [x, y]]: the corner with the least coordinates, "
                                              "then the one with the greatest",
                                              key));
  }
  return {limits[0], limits[1], limits[2], limits[3]};
}

}  // namespace scanmill
