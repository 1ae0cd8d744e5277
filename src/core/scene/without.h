#pragma once

// Takes objects out of a scene, to get the same scans with and without them: the key `without` of a pipeline's scene.

#include <vector>

#include "config/value.h"
#include "scene/scene.h"

namespace scanmill {

// Takes out of the scene what the items of `what` name. A number takes out the thing with this instance id. A word
// takes out the objects with this name and all their copies, the copy with this name (NAME#1), and the triangles of the
// class with this name. All other things keep their ids, and all other hits stay the same to the last bit. Throws an
// InputError at the place of an item that is neither a class of the scene's ontology nor in the scene.
void takeOut(Scene& scene, const std::vector<Value>& what);

}  // namespace scanmill
