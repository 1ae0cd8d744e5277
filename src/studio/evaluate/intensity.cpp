#include "evaluate/intensity.h"

namespace scanmill {

std::function<std::vector<float>(const Shot&, const Hits&)> noiseFreeIntensity(const Pipeline& pipeline,
                                                                               const Scene& scene) {
  if (!setsIntensity(pipeline)) return {};
  return [&pipeline, &scene](const Shot& shot, const Hits& hits) {
    Returns returns;
    returns.start(hits);
    for (const auto& effect : *pipeline.sensors[shot.sensor].effects) {
      if (effect->setsIntensity()) effect->apply(hits, shot, scene.materials, returns);
    }
    return std::move(returns.intensity);
  };
}

}  // namespace scanmill
