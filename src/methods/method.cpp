#include "methods/method.h"

#include <array>

#include "methods/ray_tracing/ray_tracing.h"

namespace scanmill {

namespace {

constexpr std::array kMethods{
    MethodEntry{"ray_tracing", "Embree on all cores: exact, the reference of the other methods",
                "packet: 16 or 1, rays a call; "
                "tile_columns: auto, 1, 2, 4, 8 or 16, columns of a packet; "
                "robust: true, watertight at the edges of triangles; "
                "bvh: medium, low or high, quality of the hierarchy; "
                "instancing: auto, always or never",
                makeRayTracing},
};

}  // namespace

std::span<const MethodEntry> methods() {
  return kMethods;
}

const MethodEntry& requireMethod(std::string_view name, const Location& where) {
  std::vector<std::string> names;
  for (const MethodEntry& entry : kMethods) {
    if (entry.name == name) return entry;
    names.emplace_back(entry.name);
  }
  throw InputError(where, "unknown method '" + std::string(name) + "'" + suggestion(name, names));
}

}  // namespace scanmill
