#pragma once

// A method whose beams have two returns, one or none, for the tests of everything that comes behind a method.

#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "methods/method.h"
#include "pipeline/plan/plan.h"

namespace scanmill {

// How many surfaces a beam meets; which ones changes from frame to frame. A beam that meets two of them has a ray for
// each, with half of the power; of those that meet nothing, every other one has no ray at all.
inline std::uint32_t returnsOfBeam(std::uint32_t beam, std::uint32_t frame) {
  return (beam + frame) % 3;
}

// What a beam's nth return meets. Ranges (m) are of no scene; classes, instances and materials are the scene's, or 0.
struct TwoReturnsOptions {
  double near = 10;  // m, the first return of beam 0
  double gap = 5;    // m, from the first return to the second
  std::int64_t most = 2;
};

inline float rangeOfReturn(const TwoReturnsOptions& options, std::uint32_t beam, std::uint32_t number) {
  return static_cast<float>(options.near + 0.01 * (beam % 7) + options.gap * number);
}

inline std::uint16_t labelOfReturn(const Ontology& ontology, std::uint32_t beam, std::uint32_t number) {
  return ontology.classes[(beam + number) % ontology.classes.size()].id;
}

inline std::uint32_t instanceOfReturn(const Scene& scene, std::uint32_t beam, std::uint32_t number) {
  return (beam / 5 + number) % (scene.things() + 1);
}

class TwoReturns : public Method {
 public:
  TwoReturns(const Scene& scene, const TwoReturnsOptions& options) : scene_(scene), options_(options) {}

  TraceAccount prepare(const Shot&) const override { return {}; }

  // The farther ray of a beam comes first, and all second rays come behind all first ones: a method's rays have no
  // order.
  TraceAccount trace(const Shot& shot, Channels channels, Hits& hits) const override {
    const BeamTable& beams = *shot.beams;
    hits.reset(0, 0, channels);  // its columns get an item for each ray, not for each beam
    hits.rings = beams.rings;
    hits.columns = beams.columns;
    for (const std::uint32_t number : {1u, 0u}) {
      for (std::uint32_t beam = 0; beam < beams.size(); ++beam) {
        const auto count = std::min(returnsOfBeam(beam, shot.frame), static_cast<std::uint32_t>(options_.most));
        if (number < count) add(shot, beam, number, 1.0f / static_cast<float>(count), hits);
        if (number == 0 && count == 0 && beam % 2 == 0) addMiss(beam, hits);
      }
    }
    return {};
  }

  std::vector<ModelledItem> modelled() const override { return {{"two returns", "of no scene"}}; }
  std::uint64_t memoryBytes() const override { return 0; }

 private:
  void add(const Shot& shot, std::uint32_t beam, std::uint32_t number, float weight, Hits& hits) const {
    const Vec3d& direction = shot.beams->direction[beam];
    hits.beamOfRay.push_back(beam);
    hits.weightOfRay.push_back(weight);
    hits.range.push_back(rangeOfReturn(options_, beam, number));
    put(hits, Channel::Normal, hits.normal, Vec3f(direction * -1.0));
    put(hits, Channel::Instance, hits.instance, instanceOfReturn(scene_, beam, number));
    put(hits, Channel::Semantic, hits.semantic, labelOfReturn(scene_.ontology, beam, number));
    put(hits, Channel::Material, hits.material, static_cast<std::uint16_t>(beam % scene_.materials.size()));
    put(hits, Channel::Primitive, hits.primitive, beam);
    put(hits, Channel::Reflectance, hits.reflectance, 0.5f);
    put(hits, Channel::Incidence, hits.incidence, number == 0 ? 1.0f : 0.5f);
  }

  static void addMiss(std::uint32_t beam, Hits& hits) {
    hits.beamOfRay.push_back(beam);
    hits.weightOfRay.push_back(1);
    hits.range.push_back(kMiss);
    put(hits, Channel::Normal, hits.normal, Vec3f{});
    put(hits, Channel::Instance, hits.instance, 0u);
    put(hits, Channel::Semantic, hits.semantic, std::uint16_t{0});
    put(hits, Channel::Material, hits.material, std::uint16_t{0});
    put(hits, Channel::Primitive, hits.primitive, 0u);
    put(hits, Channel::Reflectance, hits.reflectance, 0.0f);
    put(hits, Channel::Incidence, hits.incidence, 0.0f);
  }

  template <class T>
  static void put(const Hits& hits, Channel channel, std::vector<T>& column, T value) {
    if (hits.channels.has(channel)) column.push_back(value);
  }

  const Scene& scene_;
  TwoReturnsOptions options_;
};

inline std::unique_ptr<Method> makeTwoReturns(const Scene& scene, Fields& fields) {
  TwoReturnsOptions options;
  options.near = fields.number("near_m", {0.5, 100}, options.near);
  options.gap = fields.number("gap_m", {0.01, 100}, options.gap);
  options.most = fields.integer("most", 0, 2, options.most);
  fields.finish();
  return std::make_unique<TwoReturns>(scene, options);
}

// No row of methods(): a test puts it into a pipeline.
inline const MethodEntry& twoReturns() {
  static constexpr MethodEntry kEntry{.name = "two_returns",
                                      .summary = "beams with two returns, one or none",
                                      .keys =
                                          "near_m: 10 m, of the first return\ngap_m: 5 m, to the second\n"
                                          "most: 2, returns of a beam",
                                      .can = {},
                                      .color = {10, 200, 90},
                                      .make = makeTwoReturns};
  return kEntry;
}

// The pipeline with this method in place of its own. `options`: its map in YAML.
inline Pipeline withTwoReturns(Pipeline pipeline, const std::string& options = "{}") {
  pipeline.method = {&twoReturns(), parseYaml(options, "two_returns")};
  return pipeline;
}

}  // namespace scanmill
