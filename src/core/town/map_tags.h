#pragma once

// What the tags of OpenStreetMap mean for a town.

#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>

#include "town/map.h"

namespace scanmill::town {

// These functions return nullopt for tags that are not of such a thing, or do not say.
std::optional<RoadClass> roadClassOf(const OsmTags& tags);
std::optional<Land> landOf(const OsmTags& tags);
std::optional<models::Fencing> fencingOf(const std::string& barrier);
std::optional<bool> sidewalkOf(const OsmTags& tags);
std::optional<bool> parkingOf(const OsmTags& tags);

bool isPath(const OsmTags& tags);
// True if a path is the pavement of a road, with which it is built.
bool isSidewalk(const OsmTags& tags);
// True if an object is on the ground. Objects that are not, such as tunnels and bridges, are left out.
bool onGround(const OsmTags& tags);
// True if the map says of an object that it does not exist yet, or no longer.
bool isAbsent(const OsmTags& tags);
// True if the map gives one of these values of surface, or no surface.
bool hasSurface(const OsmTags& tags, std::initializer_list<std::string_view> values);
// True if an element with the key highway is an area, unless its outline is not closed.
bool isHighwayArea(const OsmTags& tags);
// True for roofs without walls, which are left out, since they would get walls. A part of a building that hangs has no
// walls on the ground.
bool isOpenRoof(const OsmTags& tags);
// True if the map gives the look or the state of a building.
bool hasLook(const OsmTags& tags);
// True if a town has something else beside a road than the map: both sides of its roads are alike, cars stand along
// them, and they have neither cycleways nor embankments.
bool differsFromTownRoads(const OsmTags& tags);

enum class OsmElement { Node, WayOrRelation };
// Returns the first tag, such as "highway=street_lamp", that stands for a shape on the ground; empty: no tag does.
std::string shapeTagOf(const OsmTags& tags, OsmElement element);

}  // namespace scanmill::town
