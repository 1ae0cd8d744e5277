#pragma once

// The procedural street, and a sensor in it.

#include <memory>
#include <string>

#include "config/resources.h"
#include "config/value.h"
#include "scene/scene.h"
#include "scenefile/scene_file.h"
#include "sensors/sensor.h"
#include "sensors/shot.h"

namespace scanmill {

inline Scene proceduralStreet(std::uint64_t seed = 1) {
  SceneOptions options;
  options.seed = seed;
  return readScene(resourceFolder() / "scenes/street.yaml", options);
}

inline std::shared_ptr<const BeamTable> presetBeams(const std::string& preset) {
  return makeBeams(readYaml(resourceFolder() / "pipelines/sensors" / (preset + ".yaml")));
}

// On the right lane, `x` metres along the street, 1.9 m above the road.
inline Shot streetShot(std::shared_ptr<const BeamTable> beams, double x) {
  Shot shot;
  shot.seed = 1;
  shot.sensorName = "top";
  shot.beams = std::move(beams);
  shot.worldFromSensor = {{{}, {x, -1.75, 1.9}}};
  return shot;
}

}  // namespace scanmill
