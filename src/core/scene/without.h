#pragma once

// Takes objects out of a scene, to get the same scans with and without them: the key `without` of a pipeline's scene.

#include <vector>

#include "config/value.h"
#include "scene/scene.h"

namespace scanmill {

// Each item of `what` is either a number, which takes out the thing with this instance id, or a word, which takes out
// the objects of this name, with all their copies, and the triangles of this class. All other things keep their ids,
// and all other hits stay the same to the last bit. Throws an InputError at the place of an item that is neither a
// class of the scene's ontology nor in the scene.
void takeOut(Scene& scene, const std::vector<Value>& what);

}  // namespace scanmill
