#pragma once

// Vehicles whose boxes lie across them.

#include <string>
#include <vector>

#include "scene/scene.h"
#include "scene/thing_boxes.h"

namespace scanmill {

// Things of classes that have wheels by labels/words.yaml, whose heading is known and whose boxes are wider than long,
// or which drive sideways: their models look along another axis than the scene's file says. A line for each model, the
// first few of them. `boxes` are the scene's.
std::vector<std::string> headingWarnings(const Scene& scene, const ThingBoxes& boxes);

}  // namespace scanmill
