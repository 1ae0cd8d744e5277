#include "pipeline/intensity.h"

#include <algorithm>

namespace scanmill {

std::function<std::vector<float>(const Shot&, const Hits&)> noiseFreeIntensity(const Pipeline& pipeline,
                                                                               const Scene& scene) {
  const auto first = pipeline.effectsOf(0);  // all sensors' set it, or none's
  if (std::none_of(first.begin(), first.end(), [](const auto& effect) { return effect->setsIntensity(); })) return {};
  return [&pipeline, &scene](const Shot& shot, const Hits& hits) {
    Returns returns;
    returns.start(hits);
    for (const auto& effect : pipeline.effectsOf(shot.sensor)) {
      if (effect->setsIntensity()) effect->apply(hits, shot, scene.materials, returns);
    }
    return std::move(returns.intensity);
  };
}

}  // namespace scanmill
