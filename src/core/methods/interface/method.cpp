#include "methods/interface/method.h"

#include <algorithm>
#include <tuple>
#include <utility>

#include "scene/reflectance.h"

namespace scanmill {

void TraceAccount::warn(BeamWarning warning) {
  const auto keyOf = [](const BeamWarning& w) { return std::tie(w.sensor, w.kind); };
  const auto position = std::ranges::lower_bound(warnings, keyOf(warning), {}, keyOf);
  if (position == warnings.end() || keyOf(*position) != keyOf(warning)) {
    warnings.insert(position, std::move(warning));
  } else if (position->count < warning.count) {
    *position = std::move(warning);
  }
}

TraceAccount& TraceAccount::operator+=(const TraceAccount& other) {
  addSeconds(other.seconds, seconds);
  for (const BeamWarning& warning : other.warnings) warn(warning);
  return *this;
}

std::vector<std::string> TraceAccount::warningTexts() const {
  std::vector<std::string> texts;
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
