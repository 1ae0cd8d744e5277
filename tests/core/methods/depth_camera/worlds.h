#pragma once

// What the tests of the depth camera share: scenes, the method with a ray-tracing renderer, and how far two Hits are
// apart.

#include <memory>
#include <string>
#include <vector>

#include "methods/depth_camera/depth_camera.h"
#include "tests/core/methods/trace.h"
#include "tests/support/embree_passes.h"
#include "tests/support/ray_scenes.h"
#include "tests/support/same_hits.h"

namespace scanmill {

inline Fields depthFields(const Value& value) {
  return {value, "method depth_camera"};
}

// The scene must outlive it. `renderer`, where given, is set when it is made.
inline std::unique_ptr<DepthCamera> depthCamera(const Scene& scene, const std::string& options = "{}",
                                                EmbreePasses** renderer = nullptr) {
  const Value value = parseYaml(options, "options");
  Fields fields = depthFields(value);
  return makeDepthCamera(scene, fields, [&scene, renderer]() -> std::unique_ptr<PassRenderer> {
    auto made = std::make_unique<EmbreePasses>(scene);
    if (renderer != nullptr) *renderer = made.get();
    return made;
  });
}

inline Hits photographed(const Scene& scene, const Shot& shot, const std::string& options = "{}",
                         Channels channels = Channels::all()) {
  return traced(*depthCamera(scene, options), shot, channels);
}

// A closed room of flat walls around the origin, turned so that no wall is parallel to an axis. Its ceiling reflects
// differently.
inline Scene room() {
  SceneBuilder builder = testBuilder();
  Mesh walls = meshOf(builder, "ground");
  appendBox(walls, 0, {}, {42, 30, 9});
  builder.place(builder.addMesh(walls), {toMatrix(fromYawPitchRoll(0.4, 0.15, 0.1)), {3, -2, 1}}, "room");
  Mesh box = meshOf(builder, "thing", "dark");
  appendBox(box, 0, {}, {2, 1, 3});
  builder.place(builder.addMesh(box), {toMatrix(fromYawPitchRoll(1, 0.2, 0)), {8, 3, 0}}, "box");
  return builder.finish();
}

// Beams that hit in both, on the same plane: their range errors relative to `truth`.
inline std::vector<double> relativeErrors(const Hits& truth, const Hits& hits) {
  std::vector<double> errors;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    if (!truth.hit(i) || !hits.hit(i) || truth.instance[i] != hits.instance[i]) continue;
    if (dot(truth.normal[i], hits.normal[i]) < 0.999999f) continue;
    errors.push_back(std::abs(double{hits.range[i]} - double{truth.range[i]}) / double{truth.range[i]});
  }
  return errors;
}

inline double largest(const std::vector<double>& values) {
  return values.empty() ? INFINITY : *std::max_element(values.begin(), values.end());
}

// Mean absolute range error (m) of beams that hit the same instance in both.
inline double meanError(const Hits& truth, const Hits& hits) {
  double sum = 0;
  std::size_t count = 0;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    if (!truth.hit(i) || !hits.hit(i) || truth.instance[i] != hits.instance[i]) continue;
    sum += std::abs(double{hits.range[i]} - double{truth.range[i]});
    ++count;
  }
  return sum / static_cast<double>(count);
}

}  // namespace scanmill
