#include "scenefile/survey_options.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "config/fields.h"
#include "scene/ontology.h"

namespace scanmill {

PointOptions readPointOptions(const Value& value) {
  Fields f(value, "points");
  f.also({"spacing", "neighbors", "cover", "radius", "reflectance", "full", "labels"}).finish();
  PointOptions options;
  if (f.has("spacing")) options.spacing = f.number("spacing", {1e-4, 1e3});
  options.surfels.neighbors = static_cast<int>(f.integer("neighbors", 3, 100, options.surfels.neighbors));
  options.surfels.cover = f.number("cover", {0.1, 10}, options.surfels.cover);
  if (const Value* radius = f.find("radius")) {
    const bool one = radius->kind == Value::Kind::Scalar;
    const std::vector<double> ends =
        one ? std::vector(2, f.number("radius", {1e-4, 100})) : f.numbers("radius", {1e-4, 100});
    if (ends.size() != 2 || ends[0] > ends[1]) {
      throw InputError(radius->where, "radius must be one length in m, or [least, most]");
    }
    options.surfels.radius = {ends[0], ends[1]};
  }
  const std::string source = f.choice("reflectance", {"auto", "intensity", "color", "none"}, "auto");
  using Reflectance = PointOptions::Reflectance;
  if (source == "intensity") options.reflectance = Reflectance::Intensity;
  if (source == "color") options.reflectance = Reflectance::Color;
  if (source == "none") options.reflectance = Reflectance::None;
  if (f.has("full")) options.full = f.number("full", {1e-9, 1e9});
  if (const auto file = f.optionalResource("labels", "labels")) {
    for (const SemanticClass& c : readOntology(*file).classes) options.labels[c.id] = c.name;
  }
  return options;
}

HeightOptions readHeightOptions(const Value& value) {
  Fields f(value, "heights");
  f.also({"every", "within", "classes", "image"}).finish();
  HeightOptions options;
  options.every = static_cast<int>(f.integer("every", 1, 10'000, 1));
  if (const Value* within = f.find("within")) {
    std::vector<double> ends;
    for (const Value& corner : within->items) {
      for (const double c : readNumbers(corner, "within")) ends.push_back(c);
    }
    if (within->kind != Value::Kind::Sequence || ends.size() != 4 || ends[0] >= ends[2] || ends[1] >= ends[3]) {
      throw InputError(
          within->where,
          "within must be [[x, y], [x, y]]: the corner with the least coordinates, then the one with the greatest");
    }
    options.within = {{ends[0], ends[1], ends[2], ends[3]}};
  }
  options.classes = f.optionalPath("classes").value_or("");
  options.image = f.optionalPath("image").value_or("");
  return options;
}

}  // namespace scanmill
