#pragma once

// Extruded outlines: the <polyline>s of SDF.

#include "assets/worlds/xml.h"
#include "scene/scene.h"

namespace scanmill {

// Returns the floor, the ceiling and the walls of all <polyline>s of a <geometry>, extruded along z from 0 to the
// <height> of the first one. An outline within another one is a hole, an outline within a hole is solid. Throws
// InputError for a height that is not above 0, and for outlines that intersect, have no area or have too many points.
Mesh extrudedPolylines(const XmlNode& geometry);

}  // namespace scanmill
