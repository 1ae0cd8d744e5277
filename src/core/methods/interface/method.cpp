#include "methods/interface/method.h"

#include <algorithm>
#include <tuple>
#include <utility>

#include "scene/reflectance.h"

namespace scanmill {

void TraceAccount::warn(BeamWarning warning) {
  const auto place =
      std::lower_bound(warnings.begin(), warnings.end(), warning, [](const BeamWarning& a, const BeamWarning& b) {
        return std::tie(a.sensor, a.kind) < std::tie(b.sensor, b.kind);
      });
  if (place == warnings.end() || place->sensor != warning.sensor || place->kind != warning.kind) {
    warnings.insert(place, std::move(warning));
  } else if (place->count < warning.count) {
    *place = std::move(warning);
  }
}

TraceAccount& TraceAccount::operator+=(const TraceAccount& other) {
  addSeconds(other.seconds, seconds);
  for (const BeamWarning& warning : other.warnings) warn(warning);
  return *this;
}

std::vector<std::string> TraceAccount::warningTexts() const {
  std::vector<std::string> texts;
  texts.reserve(warnings.size());
  for (const BeamWarning& warning : warnings) texts.push_back(warning.text);
  return texts;
}

ModelledItem cutOutItem(const Scene& scene) {
  const bool any = std::ranges::any_of(scene.materials, [](const Material& m) { return m.alphaTested; });
  return {"alpha cut-outs", any ? "modelled, some materials have them" : "no material has one", !any};
}

ModelledItem textureItem(const Scene& scene) {
  const bool any =
      std::ranges::any_of(scene.materials, [](const Material& m) { return compact(m).texture != nullptr; });
  return {"reflectance textures", any ? "modelled" : "no material has one", !any};
}

}  // namespace scanmill
