#pragma once

// Buildings of a map by OpenStreetMap's scheme "Simple 3D Buildings".

#include <vector>

#include "town/map.h"
#include "town/osm_tags.h"

namespace scanmill::town {

// Returns the building, or part of a building, with these tags. `mirrored`: y points south.
MapBuilding makeBuilding(const OsmTags& tags, Polygon outline, std::vector<Polygon> courts, bool mirrored,
                         TagNumbers& numbers);

// True if the outline covers at least 90 % of the rectangle about it, or 98 % if it has more than four corners, since a
// corner that is cut out covers little.
bool isRectangular(const Polygon& outline, const models::Footprint& about);

// Puts parts into the buildings that contain them, by relations or by place; a part outside of all buildings becomes a
// building. If the parts of a building do not cover its outline, adds the rest of the outline as a further part.
// Removes what has no height, and counts in `leftOut` what is built otherwise than the map says.
void joinParts(std::vector<MapBuilding>& buildings, std::vector<MapBuilding> parts, LeftOut& leftOut);

}  // namespace scanmill::town
