#pragma once

// Takes objects out of a scene, to get the same scans with and without them: the key `without` of a pipeline's scene.

#include <vector>

#include "config/value.h"
#include "scene/scene.h"

namespace scanmill {

// Takes out of the scene what the items of `what` name. A number is the instance id of a thing. A word is the
// name of objects, which are taken out with all their copies, and of a class, whose triangles are taken out. All other
// things keep their ids, and all other hits stay the same to the last bit. Throws an InputError at the place of an item
// that is neither a class of the scene's ontology nor in the scene.
void takeOut(Scene& scene, const std::vector<Value>& what);

}  // namespace scanmill
