#pragma once

// Warns of vehicles whose boxes point sideways.

#include <string>
#include <vector>

#include "scene/scene.h"
#include "scene/thing_boxes.h"

namespace scanmill {

// Returns a warning for each model of a vehicle that faces along another axis than the scene file says; for the first
// few models alone. A vehicle is an object instance whose class has wheels by labels/words.yaml and whose heading is
// known. Its model faces another way if its box is wider than long or if it drives sideways. `boxes` are the scene's.
std::vector<std::string> headingWarnings(const Scene& scene, const ThingBoxes& boxes);

}  // namespace scanmill
