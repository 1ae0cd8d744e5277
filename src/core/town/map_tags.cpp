// Interprets tags of OpenStreetMap.

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <iterator>

#include "base/text_scan.h"
#include "config/text.h"
#include "town/map.h"
#include "town/osm.h"

namespace scanmill::town {
namespace {

const std::initializer_list<std::string_view> kParkingKeys = {
    "parking:both", "parking:left", "parking:right", "parking:lane:both", "parking:lane:left", "parking:lane:right"};
const std::initializer_list<std::string_view> kParked = {"lane",     "street_side", "on_kerb",  "half_on_kerb",
                                                         "shoulder", "parallel",    "diagonal", "perpendicular",
                                                         "marked",   "yes"};
const std::initializer_list<std::string_view> kNotParked = {"no",          "none",        "separate", "no_parking",
                                                            "no_stopping", "no_standing", "fire_lane"};
const std::initializer_list<std::string_view> kPaved = {"both", "left", "right", "yes", "separate"};
const std::initializer_list<std::string_view> kNotPaved = {"no", "none"};

// Tags of elements that do not exist yet or no longer exist, are not on the ground, or have no shape.
constexpr std::string_view kShapeless =
    "highway=proposed highway=planned highway=construction highway=razed highway=demolished highway=abandoned "
    "highway=disused highway=services highway=rest_area highway=crossing highway=turning_circle highway=turning_loop "
    "highway=motorway_junction highway=mini_roundabout highway=passing_place railway=abandoned railway=razed "
    "railway=dismantled railway=disused railway=proposed railway=construction railway=subway railway=level_crossing "
    "railway=crossing railway=tram_level_crossing railway=tram_crossing railway=switch railway=railway_crossing "
    "railway=stop railway=halt railway=station railway=tram_stop railway=subway_entrance power=cable "
    "parking=underground aeroway=abandoned aeroway=aerodrome landuse=residential landuse=commercial landuse=retail "
    "landuse=industrial landuse=education landuse=institutional landuse=religious leisure=nature_reserve "
    "natural=valley natural=cape natural=peninsula natural=strait natural=peak natural=saddle natural=spring "
    "man_made=survey_point";
// Tags that stand for objects with a shape, although their keys are in kPlaceKeys.
constexpr std::string_view kObjects =
    "amenity=parking amenity=parking_space amenity=bench amenity=waste_basket amenity=recycling amenity=post_box "
    "amenity=fountain amenity=shelter amenity=telephone amenity=vending_machine amenity=bicycle_parking "
    "amenity=charging_station emergency=fire_hydrant golf=bunker military=bunker parking=rooftop place=square "
    "public_transport=platform tourism=artwork";

// Keys that mostly stand for places without a shape; kObjects lists the exceptions.
const std::initializer_list<std::string_view> kPlaceKeys = {
    "amenity", "emergency", "golf", "military", "parking", "place", "public_transport", "tourism"};

// Returns whether a road has a feature, from tags with keys such as `sidewalk`, `parking:lane:both` or `parking:left`:
// true if the value of a key is in `yes`; otherwise false if a value is in `no`; nullopt if no value is in either list.
std::optional<bool> featureOf(const OsmTags& tags, std::initializer_list<std::string_view> keys,
                              std::initializer_list<std::string_view> yes, std::initializer_list<std::string_view> no) {
  std::optional<bool> feature;
  for (const std::string_view key : keys) {
    if (isOneOf(tags[key], yes)) return true;
    if (isOneOf(tags[key], no)) feature = false;
  }
  return feature;
}

// Removes the unsigned number at the start of `text` and the blanks around it. Returns the number; nullopt if none.
std::optional<double> takeNumber(std::string_view& text) {
  text = trimmed(text);
  if (text.empty() || std::string_view("0123456789.").find(text.front()) == text.npos) return std::nullopt;
  double number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number, std::chars_format::fixed);
  if (error != std::errc()) return std::nullopt;
  text = trimmed({end, text.data() + text.size()});
  return number;
}

}  // namespace

std::optional<RoadClass> roadClassOf(const OsmTags& tags) {
  std::string_view value = tags["highway"];
  if (value.ends_with("_link")) value.remove_suffix(5);
  if (isOneOf(value, {"motorway", "trunk", "primary"})) return RoadClass::Primary;
  if (value == "secondary") return RoadClass::Secondary;
  if (value == "tertiary") return RoadClass::Tertiary;
  if (isOneOf(value, {"residential", "unclassified", "living_street", "road"})) return RoadClass::Residential;
  if (value == "service") return RoadClass::Service;
  if (value == "track") return RoadClass::Track;
  return std::nullopt;
}

bool isSidewalk(const OsmTags& tags) {
  return isOneOf(tags["footway"], {"sidewalk", "crossing", "traffic_island"}) || tags["path"] == "sidewalk" ||
         tags["is_sidepath"] == "yes";
}

bool isPath(const OsmTags& tags) {
  return isOneOf(tags["highway"], {"footway", "path", "cycleway", "steps", "bridleway"});
}

bool onGround(const OsmTags& tags) {
  const std::string& level = tags["level"];
  return isOneOf(tags["tunnel"], {"", "no"}) && isOneOf(tags["indoor"], {"", "no"}) &&
         isOneOf(tags["bridge"], {"", "no"}) && !tags["layer"].starts_with("-") &&
         (!level.starts_with("-") || level.find(';') != std::string::npos) &&
         !isOneOf(tags["location"], {"underground", "overground", "indoor", "roof", "rooftop"});
}

bool isAbsent(const OsmTags& tags) {
  return isOneOf(tags["building"], {"proposed", "planned", "demolished", "razed", "removed", "destroyed"}) ||
         tags["demolished"] == "yes" || tags["razed"] == "yes" || tags["removed"] == "yes" || tags["proposed"] == "yes";
}

bool hasSurface(const OsmTags& tags, std::initializer_list<std::string_view> values) {
  return tags["surface"].empty() ? !isOneOf(tags["tracktype"], {"grade2", "grade3", "grade4", "grade5"})
                                 : isOneOf(tags["surface"], values);
}

bool isHighwayArea(const OsmTags& tags) {
  return !tags["highway"].empty() && (tags["area"] == "yes" || tags.element.starts_with("relation"));
}

// Returns the first kind that matches, in the order Wood, Water, Lot, Park, Grass, Paved.
std::optional<Land> landOf(const OsmTags& tags) {
  if (isOneOf(tags["landuse"], {"forest", "orchard"}) || isOneOf(tags["natural"], {"wood", "scrub"}) ||
      tags["landcover"] == "trees") {
    return Land::Wood;
  }
  if (isOneOf(tags["natural"], {"water"}) || isOneOf(tags["landuse"], {"basin", "reservoir"}) ||
      isOneOf(tags["waterway"], {"riverbank", "dock"})) {
    return Land::Water;
  }
  const bool builtOver =
      isOneOf(tags["parking"], {"multi-storey", "underground", "rooftop", "carports", "garage_boxes", "sheds"});
  if (tags["amenity"] == "parking" && !builtOver) return Land::Lot;
  if (isOneOf(tags["leisure"], {"park", "garden", "dog_park"}) || tags["amenity"] == "grave_yard" ||
      isOneOf(tags["landuse"], {"village_green", "recreation_ground", "cemetery"})) {
    return Land::Park;
  }
  if (isOneOf(tags["leisure"], {"pitch", "playground", "golf_course"}) ||
      isOneOf(tags["landuse"], {"grass", "meadow", "farmland"}) || isOneOf(tags["natural"], {"grassland", "heath"}) ||
      tags["landcover"] == "grass") {
    return Land::Grass;
  }
  // OpenStreetMap represents squares as areas of roads and paths, or as marketplaces.
  const bool forPedestrians =
      isOneOf(tags["highway"], {"pedestrian", "footway", "path", "cycleway", "bridleway", "steps"});
  if ((isHighwayArea(tags) && (forPedestrians || roadClassOf(tags))) ||
      isOneOf(tags["amenity"], {"marketplace", "fuel"}) ||
      isOneOf(tags["aeroway"], {"apron", "helipad", "runway", "taxiway"})) {
    return Land::Paved;
  }
  return std::nullopt;
}

std::optional<models::Fencing> fencingOf(const std::string& barrier) {
  if (barrier == "hedge") return models::Fencing::Hedge;
  if (isOneOf(barrier, {"wall", "retaining_wall"})) return models::Fencing::Brick;
  if (barrier == "fence") return models::Fencing::Pickets;
  return std::nullopt;
}

bool isOpenRoof(const OsmTags& tags) {
  const bool hangs = !tags["min_height"].empty() || !tags["building:min_level"].empty();
  const auto isOpen = [&](const std::string& value) {
    return isOneOf(value, {"roof", "carport"}) || (!value.empty() && tags["wall"] == "no");
  };
  return isOpen(tags["building"]) || (tags["building"].empty() && isOpen(tags["building:part"]) && !hangs);
}

std::optional<bool> sidewalkOf(const OsmTags& tags) {
  return featureOf(tags, {"sidewalk", "sidewalk:both", "sidewalk:left", "sidewalk:right"}, kPaved, kNotPaved);
}

std::optional<bool> parkingOf(const OsmTags& tags) {
  return featureOf(tags, kParkingKeys, kParked, kNotParked);
}

bool hasLook(const OsmTags& tags) {
  constexpr const char* kStates[] = {"abandoned", "ruins", "collapsed", "construction"};
  constexpr const char* kLooks[] = {"building:material", "building:colour", "roof:material", "roof:colour"};
  return std::ranges::any_of(kLooks, [&](const char* key) { return !tags[key].empty(); }) ||
         std::ranges::any_of(kStates, [&](const char* key) { return tags[key] == "yes" || tags["building"] == key; });
}

bool differsFromTownRoads(const OsmTags& tags) {
  const auto hasAny = [&](std::initializer_list<const char*> keys, std::initializer_list<std::string_view> values) {
    return std::ranges::any_of(keys, [&](const char* key) { return isOneOf(tags[key], values); });
  };
  // True if exactly one of the keys `left` and `right` has one of the values.
  const auto onlyOneHas = [&](const char* left, const char* right, std::initializer_list<std::string_view> values) {
    return isOneOf(tags[left], values) != isOneOf(tags[right], values);
  };
  const bool oneSidewalk =
      isOneOf(tags["sidewalk"], {"left", "right"}) ||
      (!hasAny({"sidewalk", "sidewalk:both"}, kPaved) && onlyOneHas("sidewalk:left", "sidewalk:right", kPaved));
  const bool parkingAtOneSide = !hasAny({"parking:both", "parking:lane:both"}, kParked) &&
                                (onlyOneHas("parking:left", "parking:right", kParked) ||
                                 onlyOneHas("parking:lane:left", "parking:lane:right", kParked));
  // True if the tags give a kind of parking that towns do not have: any kind but parking lanes along the road.
  const bool otherParking = std::ranges::any_of(tags.pairs, [](const auto& tag) {
    const auto& [key, value] = tag;
    return (key.starts_with("parking:") && isOneOf(value, {"perpendicular", "diagonal"})) ||
           (isOneOf(key, kParkingKeys) && !isOneOf(value, kParked) && !isOneOf(value, kNotParked));
  });
  return oneSidewalk || parkingAtOneSide || otherParking ||
         hasAny({"embankment", "cutting"}, {"yes", "left", "right", "both"}) ||
         hasAny({"cycleway", "cycleway:left", "cycleway:right", "cycleway:both"},
                {"track", "lane", "opposite_track", "opposite_lane"});
}

std::string shapeTagOf(const OsmTags& tags) {
  if (!isOneOf(tags["tunnel"], {"", "no"})) return {};
  if (tags["location"] == "underground" || tags["parking"] == "underground") return {};
  const bool node = tags.element.starts_with("node");
  for (const auto& [key, value] : tags.pairs) {
    if (std::ranges::find(kMappedKeys, key) == std::end(kMappedKeys) || value == "no") continue;
    // The key traffic_sign of a way is a rule and not a sign; the key place of a node is only the name of a place.
    if (key == (node ? "place" : "traffic_sign")) continue;
    if (node && isOneOf(key, {"landuse", "landcover", "leisure"})) continue;
    std::string tag = key + "=" + value;
    if (containsWord(kShapeless, tag)) continue;
    if (!isOneOf(key, kPlaceKeys) || containsWord(kObjects, tag)) return tag;
  }
  return {};
}

bool isOneOf(std::string_view value, std::initializer_list<std::string_view> words) {
  return std::ranges::find(words, value) != words.end();
}

std::optional<double> metresOf(std::string_view value) {
  constexpr double kFoot = 0.3048;  // m
  static const std::map<std::string_view, double> kUnits = {
      {"", 1},       {"m", 1},      {"km", 1000}, {"cm", 0.01},       {"mi", 1609.344},
      {"nmi", 1852}, {"ft", kFoot}, {"'", kFoot}, {"in", kFoot / 12}, {"\"", kFoot / 12}};
  const std::optional<double> number = takeNumber(value);
  if (!number) return std::nullopt;
  if (const auto unit = kUnits.find(value); unit != kUnits.end()) return unit->second * *number;
  if (!value.starts_with("'")) return std::nullopt;
  value.remove_prefix(1);
  const std::optional<double> inches = takeNumber(value);
  return inches && value == "\"" ? std::optional(kFoot * (*number + *inches / 12)) : std::nullopt;
}

std::optional<double> numberOf(std::string_view value) {
  const std::optional<double> number = takeNumber(value);
  return value.empty() ? number : std::nullopt;
}

std::optional<double> compassOf(std::string_view value) {
  constexpr std::string_view kPoints[] = {"N", "NNE", "NE", "ENE", "E", "ESE", "SE", "SSE",
                                          "S", "SSW", "SW", "WSW", "W", "WNW", "NW", "NNW"};
  const auto* const point = std::find(std::begin(kPoints), std::end(kPoints), value);
  if (point != std::end(kPoints)) return 22.5 * static_cast<double>(point - kPoints);
  return numberOf(value);
}

std::optional<double> TagNumbers::read(const OsmTags& tags, const char* key, Parse parse, double least, double most) {
  const std::string& value = tags[key];
  if (value.empty()) return std::nullopt;
  const std::optional<double> number = parse(value);
  if (number && *number >= least && *number <= most) return number;
  Unusable& unusable = unusable_[key];
  if (unusable.count++ == 0) unusable.example = fmt::format("{} of {}", quotedForMessage(value), tags.element);
  return std::nullopt;
}

void TagNumbers::report(LeftOut& leftOut) const {
  for (const auto& [key, unusable] : unusable_) {
    leftOut.add(fmt::format("values of {} that cannot be used, such as {}", key, unusable.example), unusable.count);
  }
}

}  // namespace scanmill::town
