#pragma once

// Warns of vehicles whose boxes point sideways.

#include <string>
#include <vector>

#include "scene/scene.h"
#include "scene/thing_boxes.h"

namespace scanmill {

// Returns a warning for each vehicle model whose front is not on the side that the scene file states; at most five,
// then a line with the number of further ones. Checks object instances whose heading is known and whose class has
// wheels according to labels/words.yaml. A heading counts as wrong if the box is wider than long, or if the vehicle
// drives sideways. `boxes`: the bounding boxes of the scene's objects.
std::vector<std::string> headingWarnings(const Scene& scene, const ThingBoxes& boxes);

}  // namespace scanmill
