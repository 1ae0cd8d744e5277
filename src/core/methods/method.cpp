#include "methods/method.h"

#include <algorithm>
#include <array>

#include "config/value.h"
#include "methods/depth_camera/depth_camera.h"
#include "methods/particle/particle.h"
#include "methods/ray_tracing/ray_tracing.h"

namespace scanmill {

namespace {

// The colours follow Figure 8 of "LiDAR-GEIL: LiDAR GPU Exploitation in Lightsimulations", which shows ray tracing in
// red, the depth camera in blue and particles in orange. In the table below each colour is lighter than the previous
// one, so that the colour-blind can tell them apart. The settings that `auto` tries are cheap to measure, and together
// range from exact to fast, on processors and on GPUs.
constexpr std::array kMethods{
    MethodEntry{.name = "ray_tracing",
                .summary = "Embree on all cores: exact, the reference of the other methods",
                .keys = "packet: 16 or 1, rays per call of Embree; "
                        "robust: true, watertight at the edges of triangles; "
                        "bvh: medium, low or high, quality of the bounding volume hierarchy; "
                        "instancing: auto, always or never; "
                        "simplify: 1, share of the triangles to keep, below 1 as in collision meshes",
                .can = {.footprints = true, .transmission = true, .motion = true, .moving = true, .reference = true},
                .color = {235, 40, 40},
                .autoSettings = "- ray_tracing\n- {ray_tracing: {simplify: [0.5, 0.25]}}\n",
                .make = makeRayTracing},
    MethodEntry{
        .name = "depth_camera",
        .summary = "images of depth, normals and ids, drawn from the sensor and sampled along the beams",
        .keys = "renderer: vtk or blender, the program that draws the images; "
                "layout: auto, three_120, four_90 or cube_6, number and field of the cameras; "
                "resolution: 2048 pixels across an image, 128 to 4096; "
                "sampling: plane, nearest or bilinear, how a beam gets its range from pixels; "
                "depth: float32, uint24, uint16 or half_500, how depths are stored; "
                "antialiasing: 1, 2 or 4, subpixels per side of a pixel; "
                "near_m: 0.01 m, nearer surfaces are not drawn; "
                "far_m: the sensor's range, m, farther surfaces are not drawn; "
                "renders_per_turn: auto or a number, times that a moving sensor is drawn in a revolution",
        .can = {.footprints = true, .motion = true, .passes = true, .openGl = true},
        .color = {80, 165, 255},
        .autoSettings =
            "- depth_camera\n- {depth_camera: {resolution: [512, 1024]}}\n- {depth_camera: {sampling: nearest}}\n",
        .make = makeDepthCamera},
    MethodEntry{.name = "particle",
                .summary = "one particle per beam marches through a distance field, on the processor or a GPU",
                .keys = "field: sensor or scene, levels around each sensor or one level for the complete scene; "
                        "voxel_m: 0.1 m, edge of the finest level's voxels; "
                        "voxels: 256, voxels across each level around a sensor, 64 to 1024; "
                        "levels: auto or 1 to 16, each twice as coarse as the one before; "
                        "refine: triangle, normal or none, how hits are made exact; "
                        "steps: 512, the greatest number of steps of a particle; "
                        "backend: cpu, or gl for a graphics card",
                .can = {.footprints = true, .motion = true, .openGl = true},
                .color = {255, 190, 40},
                .autoSettings = "- particle\n- {particle: {refine: [normal, none]}}\n- {particle: {refine: [normal, "
                                "none], voxel_m: 0.2}}\n",
                .make = makeParticle},
};

}  // namespace

std::span<const MethodEntry> methods() {
  return kMethods;
}

const MethodEntry* findMethod(std::string_view name) {
  const auto found =
      std::find_if(kMethods.begin(), kMethods.end(), [&](const MethodEntry& e) { return e.name == name; });
  return found == kMethods.end() ? nullptr : &*found;
}

const MethodEntry& requireMethod(std::string_view name, const Location& where, std::string_view other) {
  if (const MethodEntry* entry = findMethod(name)) return *entry;
  std::vector<std::string> names;
  names.reserve(kMethods.size());
  for (const MethodEntry& entry : kMethods) names.emplace_back(entry.name);
  if (!other.empty()) names.emplace_back(other);
  throw InputError(where, "unknown method '" + std::string(name) + "'" + suggestion(name, names));
}

const MethodEntry& firstMethodThat(bool MethodCapabilities::*can) {
  return *std::find_if(kMethods.begin(), kMethods.end(), [&](const MethodEntry& e) { return e.can.*can; });
}

std::unique_ptr<Method> makeReference(const Scene& scene) {
  const MethodEntry& entry = firstMethodThat(&MethodCapabilities::reference);
  const Value value = parseYaml("{}", "reference method");
  Fields options(value, "method");
  return entry.make(scene, options);
}

}  // namespace scanmill
