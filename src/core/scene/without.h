#pragma once

// Takes things out of a scene, for the same scans with and without them: the key `without` of a pipeline's scene.

#include <vector>

#include "config/value.h"
#include "scene/scene.h"

namespace scanmill {

// Each item of `what` names what goes: a number the thing with this instance id; a word the objects of this name, with
// all their copies, and the triangles of this class. All other things keep their ids, and all that else is traced stays
// what it was to the last bit. Throws an InputError at an item's place
// where it is neither a class of the scene's ontology nor in the scene.
void takeOut(Scene& scene, const std::vector<Value>& what);

}  // namespace scanmill
