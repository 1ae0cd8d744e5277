#include "scene/shares.h"

#include <fmt/format.h>

#include <algorithm>

#include "config/fields.h"

namespace scanmill {
namespace {

struct SupplyRow {
  std::string_view name;
  std::vector<std::string_view> classes;
};

const std::array<SupplyRow, kSupplies>& supplies() {
  static const std::array<SupplyRow, kSupplies> rows{{{"greenery", {"tree", "vegetation", "trunk"}},
                                                      {"vehicles", {"car", "truck", "bus", "other_vehicle"}},
                                                      {"people", {"pedestrian", "rider", "bicycle", "motorcycle"}}}};
  return rows;
}

// Returns the ids of a supply's classes in an ontology, each id once even if the ontology merges several of the
// classes.
std::vector<std::uint16_t> idsOf(const SupplyRow& row, const Ontology& ontology, const Location& where) {
  std::vector<std::uint16_t> ids;
  for (const std::string_view name : row.classes) {
    const std::uint16_t id = ontology.require(name, where).id;
    if (std::find(ids.begin(), ids.end(), id) == ids.end()) ids.push_back(id);
  }
  return ids;
}

// Returns the bound on a supply or on a class that belongs to a supply. Throws InputError at `where` for other names.
ShareBound ofClasses(const std::string& name, const Ontology& ontology, const Location& where) {
  std::string all;
  for (std::size_t s = 0; s < kSupplies; ++s) {
    const SupplyRow& row = supplies()[s];
    if (name == row.name) return {name, idsOf(row, ontology, where), static_cast<Supply>(s)};
    all += fmt::format("{}{} ({})", s > 0 ? ", " : "", row.name, fmt::join(row.classes, ", "));
  }
  const SemanticClass* const known = ontology.find(name);
  if (known == nullptr) {
    std::vector<std::string> names;
    for (const SupplyRow& row : supplies()) {
      names.emplace_back(row.name);
      names.insert(names.end(), row.classes.begin(), row.classes.end());
    }
    throw InputError(where,
                     fmt::format("ontology '{}' has no class '{}'{}", ontology.name, name, suggestion(name, names)));
  }
  for (std::size_t s = 0; s < kSupplies; ++s) {
    const std::vector<std::uint16_t> ids = idsOf(supplies()[s], ontology, where);
    if (std::find(ids.begin(), ids.end(), known->id) != ids.end()) return {name, {known->id}, static_cast<Supply>(s)};
  }
  throw InputError(
      where, fmt::format("the share of {} follows from the place that the seed draws; bounds are for {}", name, all));
}

}  // namespace

std::string_view nameOf(Supply supply) {
  return supplies()[static_cast<std::size_t>(supply)].name;
}

std::vector<ShareBound> readShares(const Value& value, const Ontology& ontology) {
  if (value.kind != Value::Kind::Map || value.entries.empty()) {
    throw InputError(value.where, "shares must be a map of bounds, such as {car: [0, 0.02], greenery: [0.2, 0.4]}");
  }
  std::vector<ShareBound> bounds;
  for (const auto& [name, range] : value.entries) {
    const std::vector<double> ends = readNumbers(range, "share", {0, 1});
    if (ends.size() != 2 || ends[0] > ends[1]) {
      throw InputError(range.where, fmt::format("the share of {} must be [least, most], both from 0 to 1", name));
    }
    ShareBound bound = ofClasses(name, ontology, range.where);
    bound.least = ends[0];
    bound.most = ends[1];
    bounds.push_back(std::move(bound));
  }
  return bounds;
}

}  // namespace scanmill
