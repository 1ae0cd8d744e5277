// libscanmill_town.so: libosmium behind the interface of town/osm_interface.h.

#include <expat.h>
#include <fcntl.h>

#include <algorithm>
#include <cstring>
#include <osmium/area/assembler.hpp>
#include <osmium/builder/osm_object_builder.hpp>
#include <osmium/io/any_input.hpp>
#include <osmium/osm/object_comparisons.hpp>
#include <set>
#include <stdexcept>
#include <string>
#include <unordered_map>
#include <unordered_set>

#include "town/osm_interface.h"

namespace scanmill::town {

namespace {

using Id = osmium::object_id_type;
using Key = std::pair<osmium::item_type, Id>;

OsmTags tagsOf(const osmium::OSMObject& object) {
  OsmTags tags;
  tags.element = std::string(osmium::item_type_to_name(object.type())) + " " + std::to_string(object.id());
  for (const osmium::Tag& tag : object.tags()) tags.pairs.emplace_back(tag.key(), tag.value());
  return tags;
}

bool hasAny(const osmium::OSMObject& object, std::initializer_list<const char*> keys) {
  return std::any_of(keys.begin(), keys.end(), [&](const char* key) { return object.tags().has_key(key); });
}

bool isBuilding(const osmium::OSMObject& object) {
  return hasAny(object, {"building", "building:part"});
}

// True if an object has a key by which the town builds or counts it, whether it is a line or an area.
bool isLine(const osmium::OSMObject& object) {
  return std::any_of(std::begin(kMappedKeys), std::end(kMappedKeys),
                     [&](const char* key) { return object.tags().has_key(key); });
}

bool isArea(const osmium::OSMObject& object) {
  const osmium::TagList& tags = object.tags();
  const bool any = object.type() == osmium::item_type::relation && tags.has_tag("type", "multipolygon");
  return isBuilding(object) || hasAny(object, {"landuse", "landcover", "leisure", "natural", "amenity"}) ||
         (any && isLine(object)) ||
         (tags.has_tag("area", "yes") && hasAny(object, {"highway", "aeroway", "barrier"})) ||
         tags.has_tag("aeroway", "apron") || tags.has_tag("aeroway", "helipad") ||
         tags.has_tag("waterway", "riverbank") || tags.has_tag("waterway", "dock");
}

bool isMultipolygon(const osmium::Relation& relation) {
  return relation.tags().has_tag("type", "multipolygon") || relation.tags().has_tag("type", "boundary");
}

// True if the tags of a multipolygon only describe the data: until 2017 its outer ways had the tags of the area.
bool isOldStyle(const osmium::Relation& relation) {
  constexpr const char* kAbout[] = {"type",        "name",       "source",   "note",    "created_by", "attribution",
                                    "description", "fixme",      "ref",      "comment", "website",    "wikidata",
                                    "wikipedia",   "start_date", "operator", "addr",    "FIXME"};
  const osmium::TagList& tags = relation.tags();
  return tags.has_tag("type", "multipolygon") && std::all_of(tags.begin(), tags.end(), [&](const osmium::Tag& tag) {
           const std::string key(tag.key(), std::strcspn(tag.key(), ":"));
           return std::find(std::begin(kAbout), std::end(kAbout), key) != std::end(kAbout);
         });
}

OsmNode nodeOf(const osmium::NodeRef& node) {
  return {node.ref(), node.location().lat(), node.location().lon()};
}

constexpr const char* kOlder = "older or repeated versions of elements";

// Throws if a node is not on the earth.
void check(Id node, const osmium::Location& at) {
  if (at.is_undefined() || at.valid()) return;
  throw std::runtime_error("node " + std::to_string(node) + " has the latitude " +
                           std::to_string(at.lat_without_check()) + " and the longitude " +
                           std::to_string(at.lon_without_check()) +
                           ": latitudes are from -90 to 90 degrees, longitudes from -180 to 180");
}

void copyContent(const osmium::Node& node, osmium::builder::NodeBuilder& builder) {
  builder.set_location(node.location());
}

void copyContent(const osmium::Way& way, osmium::builder::WayBuilder& builder) {
  osmium::builder::WayNodeListBuilder joined(builder);
  for (const auto& list : way.subitems<osmium::WayNodeList>()) {
    for (const osmium::NodeRef& n : list) joined.add_node_ref(n);
  }
}

void copyContent(const osmium::Relation& relation, osmium::builder::RelationBuilder& builder) {
  osmium::builder::RelationMemberListBuilder joined(builder);
  for (const auto& list : relation.subitems<osmium::RelationMemberList>()) {
    for (const osmium::RelationMember& member : list) joined.add_member(member.type(), member.ref(), member.role());
  }
}

// Adds an element to a buffer, with one list of tags and one of nodes or members. If tags stand between nodes or
// members in XML, libosmium makes several lists, of which its functions return the first.
template <class Builder, class Element>
void addJoined(const Element& element, osmium::memory::Buffer& buffer) {
  Builder builder(buffer);
  builder.set_id(element.id()).set_version(element.version()).set_visible(element.visible());
  {
    osmium::builder::TagListBuilder joined(builder);
    for (const auto& list : element.template subitems<osmium::TagList>()) {
      for (const osmium::Tag& tag : list) joined.add_tag(tag);
    }
  }
  copyContent(element, builder);
}

// The newest versions of the elements of one type, in the order of their ids: negative ids first, as in sorted files.
template <class Element, class Builder>
class Newest {
 public:
  void add(const Element& element) {
    addJoined<Builder>(element, buffer_);
    entries_.push_back({element.id(), element.version(), buffer_.commit()});
  }

  // Removes older versions and deleted elements, and counts them.
  void finish(const std::set<Key>& deleted, OsmExtract& extract) {
    const osmium::id_order before;
    std::stable_sort(entries_.begin(), entries_.end(), [&](const Entry& a, const Entry& b) {
      return a.id == b.id ? a.version < b.version : before(a.id, b.id);
    });
    std::vector<Entry> newest;
    for (std::size_t i = 0; i < entries_.size(); ++i) {
      const Element& element = at(entries_[i]);
      if (i + 1 < entries_.size() && entries_[i + 1].id == entries_[i].id) {
        ++extract.leftOut[kOlder];
      } else if (!element.visible() || deleted.contains({element.type(), element.id()})) {
        ++extract.leftOut["deleted elements"];
      } else {
        newest.push_back(entries_[i]);
      }
    }
    entries_ = std::move(newest);
  }

  std::size_t size() const { return entries_.size(); }
  Element& operator[](std::size_t i) { return at(entries_[i]); }
  // Returns the place of an element; size() if there is none.
  std::size_t find(Id id) const {
    const auto found = std::lower_bound(entries_.begin(), entries_.end(), id,
                                        [](const Entry& e, Id wanted) { return osmium::id_order{}(e.id, wanted); });
    return found == entries_.end() || found->id != id ? size() : static_cast<std::size_t>(found - entries_.begin());
  }

 private:
  struct Entry {
    Id id;
    osmium::object_version_type version;
    std::size_t offset;
  };

  Element& at(const Entry& entry) { return buffer_.template get<Element>(entry.offset); }

  osmium::memory::Buffer buffer_{1 << 20, osmium::memory::Buffer::auto_grow::yes};
  std::vector<Entry> entries_;
};

// Notes an element that has the attribute `action: delete`.
void XMLCALL noteDeleted(void* deleted, const XML_Char* name, const XML_Char** attributes) {
  Key key{osmium::item_type::undefined, 0};
  for (const auto type : {osmium::item_type::node, osmium::item_type::way, osmium::item_type::relation}) {
    if (std::string_view(name) == osmium::item_type_to_name(type)) key.first = type;
  }
  bool isDeleted = false;
  for (; *attributes != nullptr; attributes += 2) {
    const std::string_view attribute = attributes[0];
    const std::string_view value = attributes[1];
    if (attribute == "id") key.second = osmium::string_to_object_id(attributes[1]);
    isDeleted |= attribute == "action" && value == "delete";
  }
  if (isDeleted) static_cast<std::set<Key>*>(deleted)->insert(key);
}

// Returns the elements that the editor JOSM has marked as deleted by an attribute, which libosmium does not tell. The
// file has been read before, so that its text is known to be XML.
std::set<Key> deletedByEditor(const osmium::io::File& file) {
  std::set<Key> deleted;
  if (file.format() != osmium::io::file_format::xml) return deleted;
  const auto input = osmium::io::CompressionFactory::instance().create_decompressor(
      file.compression(), ::open(file.filename().c_str(), O_RDONLY | O_CLOEXEC));
  const std::unique_ptr<XML_ParserStruct, decltype(&XML_ParserFree)> parser(XML_ParserCreate(nullptr), XML_ParserFree);
  XML_SetUserData(parser.get(), &deleted);
  XML_SetStartElementHandler(parser.get(), noteDeleted);
  for (std::string text = input->read(); !text.empty(); text = input->read()) {
    XML_Parse(parser.get(), text.data(), static_cast<int>(text.size()), 0);
  }
  input->close();
  return deleted;
}

// Reads a file in two passes: first its ways and relations, then the nodes that these use.
class ExtractReader {
 public:
  explicit ExtractReader(const std::string& name) : file_(name) {}

  OsmExtract read() {
    readWaysAndRelations();
    readNodes();
    checkBounds();
    std::multimap<std::size_t, osmium::Relation*> completedBy;  // by the place of the last way that a relation needs
    for (std::size_t i = 0; i < relations_.size(); ++i) {
      osmium::Relation& relation = relations_[i];
      if (!isMultipolygon(relation) || (!isArea(relation) && !takesTagsOfWays(relation))) continue;
      std::size_t last = 0;
      for (const osmium::RelationMember& member : relation.members()) {
        if (member.type() == osmium::item_type::way) last = std::max(last, ways_.find(member.ref()));
      }
      completedBy.emplace(last, &relation);
    }
    for (std::size_t i = 0; i < ways_.size(); ++i) {
      for (auto [at, end] = completedBy.equal_range(i); at != end; ++at) addArea(*at->second);
      addWay(ways_[i]);
    }
    for (auto [at, end] = completedBy.equal_range(ways_.size()); at != end; ++at) {
      extract_.areas.push_back({areaTags(*at->second), {}, {}, "missing ways", 0});
    }
    for (std::size_t i = 0; i < points_.size(); ++i) {
      const osmium::Node& node = points_[i];
      if (node.tags().empty() || !node.location().valid()) continue;
      extract_.points.push_back({nodeOf({node.id(), node.location()}), tagsOf(node)});
    }
    return std::move(extract_);
  }

 private:
  struct PlacedNode {
    Id id;
    osmium::Location location;
    osmium::object_version_type version = 0;
    bool found = false;
  };

  void readWaysAndRelations() {
    osmium::io::Reader reader(file_, osmium::osm_entity_bits::way | osmium::osm_entity_bits::relation);
    bounds_ = reader.header().joined_boxes();
    if (reader.header().has_multiple_object_versions() && file_.format() != osmium::io::file_format::pbf) {
      throw std::runtime_error(
          "it holds changes of a map, not the map: apply them to the map, for example with `osmium apply-changes`");
    }
    while (const osmium::memory::Buffer buffer = reader.read()) {
      for (const osmium::Way& way : buffer.select<osmium::Way>()) ways_.add(way);
      for (const osmium::Relation& relation : buffer.select<osmium::Relation>()) {
        if (isMultipolygon(relation) || relation.tags().has_tag("type", "building")) relations_.add(relation);
      }
    }
    reader.close();
    deleted_ = deletedByEditor(file_);
    ways_.finish(deleted_, extract_);
    relations_.finish(deleted_, extract_);
    for (std::size_t i = 0; i < relations_.size(); ++i) {
      for (const osmium::RelationMember& member : relations_[i].members()) {
        if (!isMultipolygon(relations_[i])) {
          groups_[{member.type(), member.ref()}] = relations_[i].id();
        } else if (member.type() == osmium::item_type::way) {
          members_.insert(member.ref());
          const bool outer = std::string_view(member.role()) != "inner";
          if (outer && relations_[i].tags().has_key("building")) outlines_.insert(member.ref());
          if (outer && isOldStyle(relations_[i])) tagged_.insert(member.ref());
        }
      }
    }
  }

  // Reads the nodes of the ways that are used, and the nodes with tags.
  void readNodes() {
    for (std::size_t i = 0; i < ways_.size(); ++i) {
      if (!isLine(ways_[i]) && !isArea(ways_[i]) && !members_.contains(ways_[i].id())) continue;
      for (const osmium::NodeRef& n : ways_[i].nodes()) placed_.push_back({n.ref(), n.location()});
    }
    std::stable_sort(placed_.begin(), placed_.end(), isBefore);
    placed_.erase(std::unique(placed_.begin(), placed_.end(),
                              [](const PlacedNode& a, const PlacedNode& b) { return a.id == b.id; }),
                  placed_.end());
    std::unordered_set<Id> tagged;
    osmium::io::Reader reader(file_, osmium::osm_entity_bits::node);
    while (const osmium::memory::Buffer buffer = reader.read()) {
      for (const osmium::Node& node : buffer.select<osmium::Node>()) {
        place(node);
        // The newest version of a node with tags may have none.
        if (node.tags().empty() && !tagged.contains(node.id())) continue;
        tagged.insert(node.id());
        points_.add(node);
      }
    }
    reader.close();
    points_.finish(deleted_, extract_);
    for (std::size_t i = 0; i < ways_.size(); ++i) {
      for (osmium::NodeRef& n : ways_[i].nodes()) {
        if (const PlacedNode* const placed = find(n.ref())) n.set_location(placed->location);
      }
    }
  }

  static bool isBefore(const PlacedNode& a, const PlacedNode& b) { return a.id < b.id; }

  PlacedNode* find(Id id) {
    const auto at = std::lower_bound(placed_.begin(), placed_.end(), id,
                                     [](const PlacedNode& node, Id wanted) { return node.id < wanted; });
    return at == placed_.end() || at->id != id ? nullptr : &*at;
  }

  void place(const osmium::Node& node) {
    if (node.visible()) check(node.id(), node.location());
    PlacedNode* const found = find(node.id());
    if (found == nullptr) return;
    PlacedNode& placed = *found;
    if (placed.found && node.tags().empty()) ++extract_.leftOut[kOlder];
    if (placed.found && node.version() < placed.version) return;
    const bool gone = !node.visible() || deleted_.contains({osmium::item_type::node, node.id()});
    if (!gone && node.tags().has_key("ele")) ++extract_.leftOut["heights of nodes (ele)"];
    placed = {node.id(), gone ? osmium::Location{} : node.location(), node.version(), true};
  }

  // Throws if latitudes and longitudes are swapped, by the bounds in the file's header.
  void checkBounds() const {
    if (!bounds_.valid()) return;
    const auto contains = [&](const osmium::Location& at) { return at.valid() && bounds_.contains(at); };
    const bool inside =
        std::any_of(placed_.begin(), placed_.end(), [&](const PlacedNode& n) { return contains(n.location); });
    const auto swapped = std::find_if(placed_.begin(), placed_.end(), [&](const PlacedNode& n) {
      return contains(osmium::Location{n.location.y(), n.location.x()});
    });
    if (inside || swapped == placed_.end()) return;
    throw std::runtime_error("latitudes and longitudes are swapped: node " + std::to_string(swapped->id) +
                             " and all others are outside of the bounds that the file states");
  }

  void addWay(const osmium::Way& way) {
    const osmium::WayNodeList& nodes = way.nodes();
    const bool closed = nodes.size() > 3 && (way.ends_have_same_id() || way.ends_have_same_location());
    const bool area = closed && isArea(way) && !way.tags().has_tag("area", "no");
    if (tagged_.contains(way.id()) && isArea(way)) return;  // its relation has its tags
    if (area && way.tags().has_key("building") && outlines_.contains(way.id())) {
      ++extract_.leftOut["buildings that are the outlines of relations with the key building"];
    } else if (area) {
      addArea(way);
    }
    if (!area && isBuilding(way) && !members_.contains(way.id())) {
      extract_.areas.push_back({tagsOf(way), {}, {}, kBroken, 0});
    }
    const bool road = way.tags().has_key("highway") && !way.tags().has_tag("area", "yes");
    if (!isLine(way) || (area && !road && !way.tags().has_key("barrier"))) return;
    // A piece of the outline of a multipolygon repeats its tags.
    if (!area && isArea(way) && members_.contains(way.id()) && !hasAny(way, kLines)) return;
    std::vector<OsmWay> parts(1);
    for (const osmium::NodeRef& n : nodes) {
      if (n.location().valid()) {
        parts.back().nodes.push_back(nodeOf(n));
      } else {
        parts.front().incomplete = true;
        if (!parts.back().nodes.empty()) parts.emplace_back();
      }
    }
    if (parts.size() > 1 && parts.back().nodes.empty()) parts.pop_back();
    for (OsmWay& part : parts) {
      part.tags = tagsOf(way);
      part.area = area;
      extract_.ways.push_back(std::move(part));
    }
  }

  // Adds the area of a closed way, or of a relation all of whose ways are in the file.
  template <class Element>
  void addArea(const Element& element) {
    osmium::area::AssemblerConfig config;
    config.create_empty_areas = false;
    osmium::area::Assembler assembler(config);
    osmium::memory::Buffer made(1 << 10, osmium::memory::Buffer::auto_grow::yes);
    bool complete = false;
    std::vector<const osmium::Way*> members;
    if constexpr (std::is_same_v<Element, osmium::Way>) {
      complete = assembler(element, made);
      members.push_back(&element);
    } else {
      for (const osmium::RelationMember& member : element.members()) {
        if (member.type() == osmium::item_type::way) members.push_back(&ways_[ways_.find(member.ref())]);
      }
      complete = assembler(element, members, made);
    }
    const OsmTags tags = areaTags(element);
    const auto group = groups_.find({element.type(), element.id()});
    const std::int64_t building = group == groups_.end() ? 0 : group->second;
    if (crossesMeridian(members)) {
      extract_.areas.push_back({tags, {}, {}, "an outline across the meridian of 180 degrees", building});
      return;
    }
    if (!complete) {
      const bool missing = assembler.stats().invalid_locations > 0;
      extract_.areas.push_back({tags, {}, {}, missing ? "missing nodes" : kBroken, building});
    }
    const auto ring = [](const osmium::NodeRefList& nodes) {
      std::vector<OsmNode> points;
      for (const osmium::NodeRef& n : nodes) points.push_back(nodeOf(n));
      if (!points.empty()) points.pop_back();
      return points;
    };
    for (const osmium::Area& area : made.select<osmium::Area>()) {
      const bool several = building == 0 && area.num_rings().first > 1;
      for (const osmium::OuterRing& outer : area.outer_rings()) {
        OsmArea kept{tags, ring(outer), {}, {}, several ? element.id() : building};
        for (const osmium::InnerRing& inner : area.inner_rings(outer)) kept.inner.push_back(ring(inner));
        extract_.areas.push_back(std::move(kept));
      }
    }
  }

  static bool crossesMeridian(const std::vector<const osmium::Way*>& ways) {
    double west = 180;
    double east = -180;
    for (const osmium::Way* way : ways) {
      for (const osmium::NodeRef& n : way->nodes()) {
        if (!n.location().valid()) continue;
        west = std::min(west, n.lon());
        east = std::max(east, n.lon());
      }
    }
    return east - west > 180;
  }

  // Returns the outer ways of a relation that the file has.
  std::vector<const osmium::Way*> outerWays(const osmium::Relation& relation) {
    std::vector<const osmium::Way*> outer;
    for (const osmium::RelationMember& member : relation.members()) {
      if (member.type() != osmium::item_type::way || std::string_view(member.role()) == "inner") continue;
      if (const std::size_t i = ways_.find(member.ref()); i < ways_.size()) outer.push_back(&ways_[i]);
    }
    return outer;
  }

  bool takesTagsOfWays(const osmium::Relation& relation) {
    if (!isOldStyle(relation)) return false;
    const std::vector<const osmium::Way*> outer = outerWays(relation);
    return std::any_of(outer.begin(), outer.end(), [](const auto* way) { return isArea(*way); });
  }

  // Returns the tags of an area. Outer ways add tags that a relation lacks: all if it is of the old style, and those of
  // its heights and roofs if it is a building.
  OsmTags areaTags(const osmium::Way& way) const { return tagsOf(way); }
  OsmTags areaTags(const osmium::Relation& relation) {
    OsmTags tags = tagsOf(relation);
    const bool old = isOldStyle(relation);
    if (!old && !isBuilding(relation)) return tags;
    for (const osmium::Way* way : outerWays(relation)) {
      if (!old && isLine(*way)) continue;
      for (const osmium::Tag& tag : way->tags()) {
        const std::string_view key = tag.key();
        const bool size = key == "height" || key == "est_height" || key == "min_height" ||
                          key.starts_with("building:") || key.starts_with("roof:");
        if ((old || size) && tags[key].empty()) tags.pairs.emplace_back(key, tag.value());
        if (size && tags[key] != tag.value()) ++extract_.leftOut[kDiffering];
      }
    }
    return tags;
  }

  static constexpr std::initializer_list<const char*> kLines = {"highway", "barrier", "railway", "power", "aerialway"};
  static constexpr const char* kDiffering =
      "heights and roofs of outer ways that differ from those of their multipolygon";
  static constexpr const char* kBroken = "an outline that is not closed or crosses itself";

  osmium::io::File file_;
  osmium::Box bounds_;
  std::set<Key> deleted_;
  Newest<osmium::Way, osmium::builder::WayBuilder> ways_;
  // Multipolygons, and the relations of buildings to their parts.
  Newest<osmium::Relation, osmium::builder::RelationBuilder> relations_;
  Newest<osmium::Node, osmium::builder::NodeBuilder> points_;
  std::unordered_set<Id> outlines_;  // outer ways of multipolygons with the key building
  std::unordered_set<Id> tagged_;    // outer ways of multipolygons of the old style
  std::unordered_set<Id> members_;   // ways of multipolygons
  std::map<Key, Id> groups_;         // members of relations with `type: building`, and these relations
  std::vector<PlacedNode> placed_;   // nodes of ways, sorted by their ids
  OsmExtract extract_;
};

class Osmium final : public OsmModule {
 public:
  OsmExtract read(const std::string& name) const override { return ExtractReader(name).read(); }
};

}  // namespace

}  // namespace scanmill::town

SCANMILL_MODULE(town::OsmModule, town::Osmium)
