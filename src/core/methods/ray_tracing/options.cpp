#include "methods/ray_tracing/options.h"

#include <string>

#include "base/error.h"

namespace scanmill {

RayTracingOptions readRayTracingOptions(Fields& fields) {
  RayTracingOptions options;
  const std::string packet = fields.choice("packet", {"16", "1"}, "16");
  options.packet = packet == "1" ? 1 : 16;
  const std::string tile = fields.choice("tile_columns", {"auto", "1", "2", "4", "8", "16"}, "auto");
  options.tileColumns = tile == "auto" ? 0 : std::stoi(tile);
  options.robust = fields.boolean("robust", true);
  const std::string quality = fields.choice("bvh", {"low", "medium", "high"}, "medium");
  options.quality = quality == "low"    ? HierarchyQuality::Low
                    : quality == "high" ? HierarchyQuality::High
                                        : HierarchyQuality::Medium;
  const std::string instancing = fields.choice("instancing", {"auto", "always", "never"}, "auto");
  options.instancing = instancing == "always"  ? Instancing::Always
                       : instancing == "never" ? Instancing::Never
                                               : Instancing::Auto;
  options.simplify = fields.number("simplify", {0.01, 1}, 1);
  fields.finish();
  return options;
}

}  // namespace scanmill
