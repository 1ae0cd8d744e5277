#include "viewer/window/mesh_coloring.h"

#include <fmt/core.h>

#include <algorithm>
#include <cstdint>
#include <functional>
#include <ranges>
#include <unordered_map>

#include "base/short_text.h"
#include "viewer/window/picked_rows.h"
#include "viewer/window/session_context.h"

namespace scanmill {

namespace {

Legend classLegend(const ViewMesh& mesh) {
  std::vector<std::uint64_t> triangles(std::size_t{UINT16_MAX} + 1, 0);
  for (const std::uint16_t id : mesh.semantic) ++triangles[id];
  Legend legend;
  for (std::size_t id = 0; id < triangles.size(); ++id) {
    if (triangles[id] == 0) continue;
    const auto semantic = static_cast<std::uint16_t>(id);
    legend.entries.push_back({className(&mesh.ontology, semantic), classColor(&mesh.ontology, semantic),
                              static_cast<std::int64_t>(id), triangles[id]});
  }
  return legend;
}

Legend instanceLegend(const ViewMesh& mesh) {
  std::unordered_map<std::uint32_t, std::uint64_t> triangles;
  for (const std::uint32_t id : mesh.instance) ++triangles[id];
  const std::uint64_t without = triangles[0];
  triangles.erase(0);
  Legend legend;
  if (!triangles.empty()) {
    const std::uint32_t first = std::ranges::min(std::views::keys(triangles));
    legend.entries.push_back(
        {fmt::format("{} instance{}, a colour each", grouped(triangles.size()), triangles.size() == 1 ? "" : "s"),
         instanceColor(first), -1, mesh.size() - without});
  }
  legend.entries.push_back({"no instance", instanceColor(0), -1, without});
  return legend;
}

Legend objectLegend(const ViewMesh& mesh) {
  Legend legend;
  if (mesh.parts.empty()) return legend;
  legend.entries.push_back(
      {fmt::format("{} object{}, a colour each", grouped(mesh.parts.size()), mesh.parts.size() == 1 ? "" : "s"),
       instanceColor(1), -1, mesh.size()});
  return legend;
}

// Returns the legend of the names (materials, textures or rules) that surfaces refer to by `which`. The most frequent
// name comes first; rules keep the order of `names`. names[i] has the colour instanceColor(firstColor + i).
Legend nameLegend(const ViewMesh& mesh, const std::vector<std::string>& names, std::uint32_t ViewSurface::*which,
                  std::uint32_t firstColor) {
  std::vector<std::uint64_t> triangles(names.size(), 0);
  for (const std::uint32_t surface : mesh.surface) ++triangles[mesh.surfaces[surface].*which];
  Legend legend;
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (triangles[i] == 0) continue;
    legend.entries.push_back({names[i], instanceColor(firstColor + static_cast<std::uint32_t>(i)), -1, triangles[i]});
  }
  if (which == &ViewSurface::rule) return legend;
  std::ranges::stable_sort(legend.entries, std::greater<>(), &LegendEntry::points);
  return legend;
}

}  // namespace

Coloring colorMesh(const ViewMesh& mesh, MeshColor by) {
  Coloring coloring;
  coloring.colors.reserve(mesh.size());
  const auto paint = [&](const auto& colorOf) {
    for (std::size_t t = 0; t < mesh.size(); ++t) coloring.colors.push_back(colorOf(t));
  };
  switch (by) {
    case MeshColor::Class:
      paint([&](std::size_t t) { return classColor(&mesh.ontology, mesh.semantic[t]); });
      coloring.legend = classLegend(mesh);
      break;
    case MeshColor::Instance:
      paint([&](std::size_t t) { return instanceColor(mesh.instance[t]); });
      coloring.legend = instanceLegend(mesh);
      break;
    case MeshColor::Object:
      paint([&](std::size_t t) { return instanceColor(mesh.surfaceOf(t).part + 1); });
      coloring.legend = objectLegend(mesh);
      break;
    case MeshColor::Material:
      paint([&](std::size_t t) { return instanceColor(mesh.surfaceOf(t).material + 1); });
      coloring.legend = nameLegend(mesh, mesh.materials, &ViewSurface::material, 1);
      break;
    case MeshColor::Texture:
      paint([&](std::size_t t) { return instanceColor(mesh.surfaceOf(t).texture); });
      coloring.legend = nameLegend(mesh, mesh.textures, &ViewSurface::texture, 0);
      break;
    case MeshColor::Rule:
      paint([&](std::size_t t) { return instanceColor(mesh.surfaceOf(t).rule); });
      coloring.legend = nameLegend(mesh, mesh.rules, &ViewSurface::rule, 0);
      break;
    case MeshColor::Reflectance:
      paint([&](std::size_t t) { return viridis(double{mesh.reflectance[mesh.surfaceOf(t).material]}); });
      coloring.legend.scale = true;
      coloring.legend.high = 1;
      break;
  }
  coloring.legend.title = std::string(kMeshColorNames[static_cast<std::size_t>(by)]);
  return coloring;
}

}  // namespace scanmill
