// The module libscanmill_town.so: implements OsmModule (town/osm.h) with libosmium.

#include <algorithm>
#include <map>
#include <osmium/area/assembler.hpp>
#include <osmium/handler/check_order.hpp>
#include <osmium/handler/node_locations_for_ways.hpp>
#include <osmium/index/map/sparse_mem_array.hpp>
#include <osmium/io/any_input.hpp>
#include <osmium/relations/relations_manager.hpp>
#include <osmium/visitor.hpp>
#include <stdexcept>
#include <string>
#include <unordered_set>

#include "town/osm.h"

namespace scanmill::town {

namespace {

using Id = osmium::object_id_type;

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

// True if an element, whether line or area, has one of kMappedKeys.
bool isMapped(const osmium::OSMObject& object) {
  return std::any_of(std::begin(kMappedKeys), std::end(kMappedKeys),
                     [&](const char* key) { return object.tags().has_key(key); });
}

// True if the tags of a closed way or multipolygon make it an area; see OsmExtract::areas.
bool isArea(const osmium::OSMObject& object) {
  const osmium::TagList& tags = object.tags();
  const bool multipolygon = object.type() == osmium::item_type::relation && tags.has_tag("type", "multipolygon");
  return isBuilding(object) || hasAny(object, {"landuse", "landcover", "leisure", "natural", "amenity"}) ||
         (multipolygon && isMapped(object)) ||
         (tags.has_tag("area", "yes") && hasAny(object, {"highway", "aeroway", "barrier"})) ||
         tags.has_tag("aeroway", "apron") || tags.has_tag("aeroway", "helipad") ||
         tags.has_tag("waterway", "riverbank") || tags.has_tag("waterway", "dock");
}

// True if a tag is about the size of a building or about its roof.
bool isSizeOrRoof(const osmium::Tag& tag) {
  const std::string_view key = tag.key();
  return key == "height" || key == "est_height" || key == "min_height" || key.starts_with("building:") ||
         key.starts_with("roof:");
}

OsmNode nodeOf(const osmium::NodeRef& node) {
  return {node.ref(), node.location().lat(), node.location().lon()};
}

// Reads the relations of a file, then the nodes and ways. Makes the area of a relation when the last of its ways has
// been read. Throws osmium::out_of_order_error if elements are not sorted or occur twice.
class ExtractReader : public osmium::relations::RelationsManager<ExtractReader, false, true, false> {
 public:
  OsmExtract read(const osmium::io::File& file) {
    osmium::handler::CheckOrder order;
    osmium::io::Reader relations(file, osmium::osm_entity_bits::relation);
    if (file.has_multiple_object_versions() || relations.header().has_multiple_object_versions()) {
      throw std::runtime_error(
          "it holds a history or changes of a map, not the map: `osmium time-filter` takes the map of one time out of "
          "a history, `osmium apply-changes` changes a map");
    }
    osmium::apply(relations, *this);
    relations.close();
    prepare_for_lookup();
    osmium::io::Reader reader(file, osmium::osm_entity_bits::node | osmium::osm_entity_bits::way);
    osmium::index::map::SparseMemArray<osmium::unsigned_object_id_type, osmium::Location> index;
    osmium::handler::NodeLocationsForWays<decltype(index)> places(index);
    places.ignore_errors();
    PointReader points(extract_.points);
    osmium::apply(reader, order, places, points, handler());
    reader.close();
    for_each_incomplete_relation([&](const osmium::relations::RelationHandle& relation) {
      extract_.areas.push_back({tagsOf(*relation), {}, {}, "missing ways", 0});
    });
    return std::move(extract_);
  }

  // Called by libosmium for each relation of the file. Returns true for areas, whose ways libosmium then collects.
  bool new_relation(const osmium::Relation& relation) {
    if (!relation.visible()) return false;
    const std::string_view type = relation.tags().get_value_by_key("type", "");
    const bool multipolygon = type == "multipolygon" || type == "boundary";
    const bool building = type == "building";
    for (const osmium::RelationMember& member : relation.members()) {
      if (building && !multipolygon) groups_[{member.type(), member.ref()}] = relation.id();
      if (!multipolygon || member.type() != osmium::item_type::way) continue;
      members_.insert(member.ref());
      if (relation.tags().has_key("building") && !isInner(member)) outlines_.insert(member.ref());
    }
    const bool untagged = type == "multipolygon" && !isArea(relation);
    if (untagged) ++extract_.leftOut["multipolygons without a tag of an area, whose holes are not built"];
    return multipolygon && isArea(relation);
  }

  bool new_member(const osmium::Relation& /*relation*/, const osmium::RelationMember& member, std::size_t /*n*/) {
    return member.type() == osmium::item_type::way;
  }

  // Called by libosmium when all ways of a relation have been read. Adds the relation's areas.
  void complete_relation(const osmium::Relation& relation) {
    OsmTags tags = tagsOf(relation);
    std::vector<const osmium::Way*> ways;
    for (const osmium::RelationMember& member : relation.members()) {
      if (member.ref() == 0 || member.type() != osmium::item_type::way) continue;
      const osmium::Way& way = *ways.emplace_back(get_member_way(member.ref()));
      // Outer ways of a building may have tags of heights and roofs that the relation lacks.
      if (!isBuilding(relation) || isInner(member) || isMapped(way)) continue;
      for (const osmium::Tag& tag : way.tags()) {
        if (isSizeOrRoof(tag) && tags[tag.key()].empty()) tags.pairs.emplace_back(tag.key(), tag.value());
        if (isSizeOrRoof(tag) && tags[tag.key()] != tag.value()) {
          ++extract_.leftOut["heights and roofs of outer ways that differ from those of their multipolygon"];
        }
      }
    }
    addArea(relation, tags, ways);
  }

  // Called by libosmium for each way. Adds the way as an area, as a line, as both (a closed hedge), or not at all.
  // Counts buildings that are outlines of relations as left out, and reports buildings with an unclosed outline.
  void after_way(const osmium::Way& way) {
    const osmium::WayNodeList& nodes = way.nodes();
    if (way.subitems<osmium::TagList>().size() > 1 || way.subitems<osmium::WayNodeList>().size() > 1) {
      throw std::runtime_error(tagsOf(way).element + " has tags between its nodes, which must stand behind them");
    }
    if (!way.visible()) return;
    const bool closed = nodes.size() > 3 && (way.ends_have_same_id() || way.ends_have_same_location());
    const bool closedArea = closed && isArea(way) && !way.tags().has_tag("area", "no");
    const bool member = members_.contains(way.id());
    if (closedArea && way.tags().has_key("building") && outlines_.contains(way.id())) {
      ++extract_.leftOut["buildings that are the outlines of relations with the key building"];
    } else if (closedArea) {
      addArea(way, tagsOf(way));
    } else if (isBuilding(way) && !member) {
      extract_.areas.push_back({tagsOf(way), {}, {}, kBroken, 0});
    }
    if (closedArea ? isLineToo(way) : isLine(way, member)) addLine(way, closedArea);
  }

 private:
  // True if a closed area is also a line: a road around a square, or a barrier.
  static bool isLineToo(const osmium::Way& way) {
    const bool road = way.tags().has_key("highway") && !way.tags().has_tag("area", "yes");
    return isMapped(way) && (road || way.tags().has_key("barrier"));
  }

  // True if a way that is not a closed area is a line. A member of a multipolygon may be only a piece of its outline
  // that repeats its tags.
  static bool isLine(const osmium::Way& way, bool member) {
    return isMapped(way) && (!member || !isArea(way) || hasAny(way, kLines));
  }

  // Adds a way as a line; nodes without a location divide it into runs.
  void addLine(const osmium::Way& way, bool area) {
    OsmWay line{tagsOf(way), {}, area};
    bool startsRun = true;
    for (const osmium::NodeRef& n : way.nodes()) {
      const bool valid = n.location().valid();
      if (valid && startsRun) line.runs.emplace_back();
      if (valid) line.runs.back().push_back(nodeOf(n));
      line.incomplete |= !valid;
      startsRun = !valid;
    }
    extract_.ways.push_back(std::move(line));
  }

  // Collects the nodes with tags.
  class PointReader : public osmium::handler::Handler {
   public:
    explicit PointReader(std::vector<OsmPoint>& points) : points_(points) {}
    void node(const osmium::Node& node) {
      if (node.tags().empty() || !node.visible() || !node.location().valid()) return;
      points_.push_back({nodeOf({node.id(), node.location()}), tagsOf(node)});
    }

   private:
    std::vector<OsmPoint>& points_;
  };

  static bool isInner(const osmium::RelationMember& member) { return std::string_view(member.role()) == "inner"; }

  // Adds an OsmArea per outer ring of a closed way or of a relation with the ways `ways`; on failure, one with a fault.
  template <class Element, class... Ways>
  void addArea(const Element& element, const OsmTags& tags, const Ways&... ways) {
    osmium::area::AssemblerConfig config;
    config.create_empty_areas = false;
    osmium::area::Assembler assembler(config);
    osmium::memory::Buffer assembled(1 << 10, osmium::memory::Buffer::auto_grow::yes);
    const auto group = groups_.find({element.type(), element.id()});
    const std::int64_t building = group == groups_.end() ? 0 : group->second;
    if (!assembler(element, ways..., assembled)) {
      const bool missing = assembler.stats().invalid_locations > 0;
      extract_.areas.push_back({tags, {}, {}, missing ? "missing nodes" : kBroken, building});
    }
    const auto ring = [](const osmium::NodeRefList& nodes) {
      std::vector<OsmNode> points;
      for (const osmium::NodeRef& n : nodes) points.push_back(nodeOf(n));
      if (!points.empty()) points.pop_back();
      return points;
    };
    for (const osmium::Area& area : assembled.select<osmium::Area>()) {
      const bool several = building == 0 && area.num_rings().first > 1;  // the outer rings are one building
      for (const osmium::OuterRing& outer : area.outer_rings()) {
        OsmArea& added = extract_.areas.emplace_back(tags, ring(outer));
        added.building = several ? element.id() : building;
        for (const osmium::InnerRing& inner : area.inner_rings(outer)) added.inner.push_back(ring(inner));
      }
    }
  }

  static constexpr std::initializer_list<const char*> kLines = {"highway", "barrier", "railway", "power", "aerialway"};
  static constexpr const char* kBroken = "an outline that is not closed or crosses itself";

  std::unordered_set<Id> outlines_;                        // outer ways of multipolygons with the key building
  std::unordered_set<Id> members_;                         // ways of multipolygons
  std::map<std::pair<osmium::item_type, Id>, Id> groups_;  // relation of `type: building`, by member
  OsmExtract extract_;
};

class Osmium final : public OsmModule {
 public:
  OsmExtract read(const std::string& name) const override {
    try {
      return ExtractReader().read(osmium::io::File(name));
    } catch (const osmium::out_of_order_error& e) {
      throw std::runtime_error(std::string(e.what()) + " Sort it by `osmium sort`");
    }
  }
};

}  // namespace

}  // namespace scanmill::town

SCANMILL_MODULE(town::OsmModule, town::Osmium)
