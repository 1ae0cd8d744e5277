// libscanmill_town.so: libosmium behind the interface of town/osm_interface.h.

#include <osmium/area/assembler.hpp>
#include <osmium/area/multipolygon_manager.hpp>
#include <osmium/handler/node_locations_for_ways.hpp>
#include <osmium/index/map/flex_mem.hpp>
#include <osmium/io/any_input.hpp>
#include <osmium/relations/relations_manager.hpp>
#include <osmium/visitor.hpp>
#include <string>

#include "town/osm_interface.h"

namespace scanmill::town {

namespace {

OsmTags tagsOf(const osmium::OSMObject& object) {
  OsmTags tags;
  for (const osmium::Tag& tag : object.tags()) tags.pairs.emplace_back(tag.key(), tag.value());
  return tags;
}

bool hasAny(const osmium::OSMObject& object, std::initializer_list<const char*> keys) {
  for (const char* key : keys) {
    if (object.tags().has_key(key)) return true;
  }
  return false;
}

OsmNode nodeOf(std::int64_t id, const osmium::Location& at) {
  return {id, at.lat(), at.lon()};
}

class Collector : public osmium::handler::Handler {
 public:
  explicit Collector(OsmExtract& extract) : extract_(extract) {}

  void node(const osmium::Node& node) {
    if (node.tags().empty() || !node.location().valid()) return;
    extract_.points.push_back({nodeOf(node.id(), node.location()), tagsOf(node)});
  }

  void way(const osmium::Way& way) {
    if (!hasAny(way, {"highway", "barrier"})) return;
    OsmWay kept{tagsOf(way), {}};
    for (const osmium::NodeRef& n : way.nodes()) {
      if (n.location().valid()) kept.nodes.push_back(nodeOf(n.ref(), n.location()));
    }
    extract_.ways.push_back(std::move(kept));
  }

  void area(const osmium::Area& area) {
    const bool square = area.tags().has_key("highway") && area.tags().has_tag("area", "yes");
    if (!square && !hasAny(area, {"building", "landuse", "leisure", "natural", "amenity"})) return;
    const auto ring = [](const osmium::NodeRefList& nodes) {
      std::vector<OsmNode> made;
      for (const osmium::NodeRef& n : nodes) made.push_back(nodeOf(n.ref(), n.location()));
      if (!made.empty()) made.pop_back();
      return made;
    };
    for (const osmium::OuterRing& outer : area.outer_rings()) {
      OsmArea kept{tagsOf(area), ring(outer), {}};
      for (const osmium::InnerRing& inner : area.inner_rings(outer)) kept.inner.push_back(ring(inner));
      extract_.areas.push_back(std::move(kept));
    }
  }

 private:
  OsmExtract& extract_;
};

class Osmium final : public OsmModule {
 public:
  OsmExtract read(const std::string& name) const override {
    const osmium::io::File file(name);
    using Assembler = osmium::area::Assembler;
    const Assembler::config_type config;
    osmium::area::MultipolygonManager<Assembler> polygons(config);
    osmium::relations::read_relations(file, polygons);
    OsmExtract extract;
    using Index = osmium::index::map::FlexMem<osmium::unsigned_object_id_type, osmium::Location>;
    Index index;
    Index negative;  // locations of nodes with negative ids, which were never uploaded
    osmium::handler::NodeLocationsForWays<Index, Index> locations(index, negative);
    locations.ignore_errors();  // extracts contain ways with nodes outside the extract
    Collector collector(extract);
    osmium::io::Reader reader(file);
    osmium::apply(reader, locations, collector,
                  polygons.handler([&](const osmium::memory::Buffer& buffer) { osmium::apply(buffer, collector); }));
    reader.close();
    return extract;
  }
};

}  // namespace

}  // namespace scanmill::town

SCANMILL_MODULE(town::OsmModule, town::Osmium)
