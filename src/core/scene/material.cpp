#include "scene/material.h"

#include <fmt/format.h>

#include <algorithm>

#include "config/fields.h"
#include "config/resources.h"

namespace scanmill {
namespace {

constexpr int kWavelengths[] = {850, 905, 1064, 1550};  // nm

// Reads a material's reflectance at a wavelength: one number for all wavelengths, or a map from wavelength (nm) to
// number. Tables may leave out 1550 nm; then only reading them at 1550 nm throws.
float readReflectance(const Value& value, const std::string& material, int wavelengthNm) {
  if (value.kind != Value::Kind::Map) return static_cast<float>(readNumber(value, "reflectance", {0, 1}));
  Fields fields(value, "reflectance");
  float reflectance = 0;
  for (const int wavelength : kWavelengths) {
    const std::optional<double> ifAbsent = wavelength == 1550 ? std::optional(-1.0) : std::nullopt;
    const double wavelengthReflectance = fields.number(std::to_string(wavelength), {0, 1}, ifAbsent);
    if (wavelength == wavelengthNm) reflectance = static_cast<float>(wavelengthReflectance);
  }
  fields.finish();
  if (reflectance >= 0) return reflectance;
  throw InputError(value.where, "material '{}' has no reflectance at 1550 nm: add the key 1550 to the map", material);
}

// Sets Material::least and Material::greatest. The key `range` states both limits at 905 nm; they are scaled by the
// ratio of Material::reflectance (at the chosen wavelength) to `reflectanceAt905nm`. Without the key, both limits are
// Material::reflectance.
void readRange(Fields& fields, float reflectanceAt905nm, Material& material) {
  material.least = material.greatest = material.reflectance;
  const Value* range = fields.find("range");
  if (range == nullptr) return;
  fields.text("range_source");
  const std::vector<double> limits = readNumbers(*range, "range", {0, 1});
  if (limits.size() != 2 || limits[0] <= 0 || static_cast<float>(limits[0]) > reflectanceAt905nm ||
      static_cast<float>(limits[1]) < reflectanceAt905nm) {
    throw InputError(range->where,
                     "range must be two reflectances at 905 nm, above 0, the first at most {0} "
                     "and the second at least {0}, which is the material's reflectance",
                     reflectanceAt905nm);
  }
  material.least = static_cast<float>(material.reflectance * limits[0] / reflectanceAt905nm);
  material.greatest = std::min(1.0f, static_cast<float>(material.reflectance * limits[1] / reflectanceAt905nm));
}

// Returns the items of the list under a key, maps such as `example`; none if the key is absent. Beside `size_m`, each
// map has a number from 0 to `most` under `valueKey`.
template <class Item>
std::vector<Item> readSizes(const Fields& material, std::string_view key, std::size_t mostItems,
                            std::string_view example, std::string_view valueKey, double most) {
  std::vector<Item> items;
  const Value* const list = material.find(key);
  if (list == nullptr) return items;
  if (list->kind != Value::Kind::Sequence || list->items.size() > mostItems) {
    throw InputError(list->where, "{} must be a list of at most {} maps such as {}", key, mostItems, example);
  }
  for (const Value& value : list->items) {
    Fields fields(value, std::string(key));
    const auto size = static_cast<float>(fields.number("size_m", {0.001, 1000}));
    items.push_back({size, static_cast<float>(fields.number(valueKey, {0, most}))});
    fields.finish();
  }
  return items;
}

}  // namespace

const Material& MaterialLibrary::require(std::string_view name, const Location& where) const {
  const auto found = std::ranges::find(materials, name, &Material::name);
  if (found != materials.end()) return *found;
  throw InputError(where, "there is no material '{}'{}", name, suggestion(name, namesOf(materials)));
}

MaterialLibrary readMaterials(const std::filesystem::path& path, int wavelengthNm) {
  if (std::ranges::find(kWavelengths, wavelengthNm) == std::end(kWavelengths)) {
    throw InputError(fmt::format("materials are known at 850, 905, 1064 and 1550 nm, not at {} nm", wavelengthNm));
  }
  const Value root = readYaml(path);
  expectKind(root, FileKind::Materials);
  Fields table(root, "material table");
  table.text("name", "");
  const Value& list = table.require("materials");
  if (list.kind != Value::Kind::Sequence) throw InputError(list.where, "materials must be a list of materials");
  table.finish();
  MaterialLibrary library;
  for (const Value& item : list.items) {
    Fields fields(item, "material");
    Material material;
    material.name = fields.text("name");
    if (material.name.empty()) throw InputError(item.where, "a material has an empty name");
    material.reflectance = readReflectance(fields.require("reflectance"), material.name, wavelengthNm);
    readRange(fields, readReflectance(fields.require("reflectance"), material.name, 905), material);
    material.source = fields.text("source");
    material.roughness = static_cast<float>(fields.number("roughness", {0, 1}, 1));
    material.metallic = static_cast<float>(fields.number("metallic", {0, 1}, 0));
    material.retroreflectance = static_cast<float>(fields.number("retroreflectance", {0, 1e4}, 0));
    material.transmission = static_cast<float>(fields.number("transmission", {0, 1}, 0));
    material.index = static_cast<float>(fields.number("index", {1, 4}, 1.52));
    material.textured = fields.boolean("textured", false);
    material.variations =
        readSizes<Variation>(fields, "variations", kMostVariations, "{size_m: 2, contrast: 0.15}", "contrast", 2);
    material.relief = readSizes<Relief>(fields, "relief", kMostReliefs, "{size_m: 0.1, height_m: 0.02}", "height_m", 1);
    fields.finish();
    if (std::ranges::find(library.materials, material.name, &Material::name) != library.materials.end()) {
      throw InputError(item.where, "material '{}' is there twice", material.name);
    }
    library.materials.push_back(std::move(material));
  }
  return library;
}

}  // namespace scanmill
