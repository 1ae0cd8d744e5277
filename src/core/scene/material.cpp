#include "scene/material.h"

#include <fmt/format.h>

#include <algorithm>

#include "config/fields.h"
#include "config/file_kind.h"

namespace scanmill {
namespace {

// Reads the reflectance at a wavelength: one number for all wavelengths, or a map from wavelength (nm) to number.
float readReflectance(const Value& value, int wavelengthNm) {
  if (value.kind != Value::Kind::Map) return static_cast<float>(readNumber(value, "reflectance", {0, 1}));
  Fields f(value, "reflectance");
  float chosen = 0;
  for (const int wavelength : {850, 905, 1064}) {
    const double r = f.number(std::to_string(wavelength), {0, 1});
    if (wavelength == wavelengthNm) chosen = static_cast<float>(r);
  }
  f.finish();
  return chosen;
}

// Reads `range`: the least and the greatest reflectance at 905 nm, from place to place. They are scaled to the
// wavelength of `material`. `mean`: the reflectance at 905 nm.
void readRange(Fields& m, float mean, Material& material) {
  material.least = material.greatest = material.reflectance;
  const Value* range = m.find("range");
  if (range == nullptr) return;
  m.text("range_source");
  const std::vector<double> ends = readNumbers(*range, "range", {0, 1});
  if (ends.size() != 2 || ends[0] <= 0 || static_cast<float>(ends[0]) > mean || static_cast<float>(ends[1]) < mean) {
    throw InputError(range->where,
                     fmt::format("range must be two reflectances at 905 nm, above 0, the first at most {0} "
                                 "and the second at least {0}, which is the material's reflectance",
                                 mean));
  }
  material.least = static_cast<float>(material.reflectance * ends[0] / mean);
  material.greatest = std::min(1.0f, static_cast<float>(material.reflectance * ends[1] / mean));
}

// Reads a list of maps that each hold `size_m` and one other number.
template <class Made>
std::vector<Made> readSizes(const Value* list, std::string_view key, std::string_view number, const Range& range,
                            std::size_t most, std::string_view example) {
  std::vector<Made> made;
  if (list == nullptr) return made;
  if (list->kind != Value::Kind::Sequence || list->items.size() > most) {
    throw InputError(list->where, fmt::format("{} must be a list of at most {} maps such as {}", key, most, example));
  }
  for (const Value& item : list->items) {
    Fields f(item, std::string(key));
    const auto size = static_cast<float>(f.number("size_m", {0.001, 1000}));
    made.push_back({size, static_cast<float>(f.number(number, range))});
    f.finish();
  }
  return made;
}

}  // namespace

const Material& MaterialLibrary::require(std::string_view name, const Location& where) const {
  std::vector<std::string> names;
  for (const Material& m : materials) {
    if (m.name == name) return m;
    names.push_back(m.name);
  }
  throw InputError(where, fmt::format("there is no material '{}'{}", name, suggestion(name, names)));
}

MaterialLibrary readMaterials(const std::filesystem::path& path, int wavelengthNm) {
  if (wavelengthNm != 850 && wavelengthNm != 905 && wavelengthNm != 1064) {
    throw InputError(fmt::format("materials are known at 850, 905 and 1064 nm, not at {} nm", wavelengthNm));
  }
  const Value root = readYaml(path);
  expectKind(root, FileKind::Materials);
  Fields f(root, "material table");
  f.text("name", "");
  const Value& list = f.require("materials");
  if (list.kind != Value::Kind::Sequence) throw InputError(list.where, "materials must be a list of materials");
  f.finish();
  MaterialLibrary library;
  for (const Value& item : list.items) {
    Fields m(item, "material");
    Material material;
    material.name = m.text("name");
    if (material.name.empty()) throw InputError(item.where, "a material has an empty name");
    material.reflectance = readReflectance(m.require("reflectance"), wavelengthNm);
    readRange(m, readReflectance(m.require("reflectance"), 905), material);
    material.source = m.text("source");
    material.roughness = static_cast<float>(m.number("roughness", {0, 1}, 1));
    material.metallic = static_cast<float>(m.number("metallic", {0, 1}, 0));
    material.retroreflectance = static_cast<float>(m.number("retroreflectance", {0, 1e4}, 0));
    material.transmission = static_cast<float>(m.number("transmission", {0, 1}, 0));
    material.index = static_cast<float>(m.number("index", {1, 4}, 1.52));
    material.textured = m.boolean("textured", false);
    material.variations = readSizes<Variation>(m.find("variations"), "variations", "contrast", {0, 2}, kMostVariations,
                                               "{size_m: 2, contrast: 0.15}");
    material.relief = readSizes<Relief>(m.find("relief"), "relief", "height_m", {0, 1}, kMostReliefs,
                                        "{size_m: 0.1, height_m: 0.02}");
    m.finish();
    for (const Material& other : library.materials) {
      if (other.name == material.name) {
        throw InputError(item.where, fmt::format("material '{}' is there twice", material.name));
      }
    }
    library.materials.push_back(std::move(material));
  }
  return library;
}

}  // namespace scanmill
