#include "methods/method.h"

#include <algorithm>
#include <array>

#include "methods/depth_camera/depth_camera.h"
#include "methods/particle/particle.h"
#include "methods/ray_tracing/ray_tracing.h"

namespace scanmill {

namespace {

// The colours follow Figure 8 of "LiDAR-GEIL: LiDAR GPU Exploitation in Lightsimulations", which shows ray tracing in
// red, the depth camera in blue and particles in orange. In the table below each colour is lighter than the previous
// one, so that the colour-blind can tell them apart.
constexpr std::array kMethods{
    MethodEntry{.name = "ray_tracing",
                .summary = "Embree on all cores: exact, the reference of the other methods",
                .keys = "instancing: auto, whether copies share geometry in the hierarchy: auto, always or never\n"
                        "simplify: 1, share of the triangles that is kept, for meshes like collision meshes, 0.01 to "
                        "1; 1: all",
                .can = {.transmission = true, .moving = true, .reference = true},
                .color = {235, 40, 40},
                .make = makeRayTracing},
    MethodEntry{
        .name = "depth_camera",
        .summary = "images of depth, normals and ids, drawn from the sensor and sampled along the beams",
        .keys = "renderer: vtk, what draws: vtk (OpenGL, without a display) or blender\n"
                "layout: auto, number and field of the images: auto (the fewest and smallest that hold all beams), "
                "three_120, four_90 (squares of 120 or 90 degrees) or cube_6 (the faces of a cube); beams outside "
                "all images are counted and become misses\n"
                "resolution: 2048, pixels across an image, 128 to 4096; auto's pixels are as fine as those of four_90\n"
                "sampling: plane, what gives a beam its range: plane (where it meets the plane that its pixel sees, "
                "exact on flat surfaces) or nearest (the pixel's point)\n"
                "depth: float32, how depths are stored: float32, uint24, uint16 (fixed point between near and far) "
                "or half_500 (half floats of coordinates + 500 m)\n"
                "near_m: 0.01 m, nearer surfaces are not drawn and hide nothing; 1e-3 to 1\n"
                "far_m: the sensor's range, m; farther surfaces are not drawn; 10 to 1e4\n"
                "renders_per_turn: auto, renders of a moving sensor: auto (one for every 5 cm or degree that it "
                "moves; all steps of `motion: {steps: n}` up to 64), or 1 to 65536; at most one per pose",
        .can = {.passes = true, .openGl = true},
        .color = {80, 165, 255},
        .make = makeDepthCamera},
    MethodEntry{.name = "particle",
                .summary = "one particle per beam marches through a distance field, on the processor or a GPU",
                .keys = "voxel_m: 0.1 m, voxels of the finest level, 0.001 to 10\n"
                        "voxels: 256, voxels across each level around a sensor, 64 to 1024, a multiple of 16\n"
                        "levels: auto, number of levels, each twice as coarse as the one before: auto (as many as the "
                        "sensor's range needs) or 1 to 16; beams end at the edge of the last level\n"
                        "refine: triangle, how hits are made exact: triangle (intersection with the triangles near "
                        "the particle) or none (particles stop half a voxel before surfaces, as the paper's)\n"
                        "steps: 512, most steps of a particle, 16 to 65535; beams that need more are counted as "
                        "unresolved, neither hits nor misses\n"
                        "backend: cpu, what computes: cpu, or gl (compute shaders of OpenGL 4.3 with "
                        "ARB_buffer_storage on a graphics card, without a display), with the same bytes; the "
                        "environment variable `SCANMILL_GL_DEVICE` selects a device (0, 1 ... or software)",
                .can = {.openGl = true},
                .color = {255, 190, 40},
                .make = makeParticle},
};

}  // namespace

std::span<const MethodEntry> methods() {
  return kMethods;
}

const MethodEntry* findMethod(std::string_view name) {
  const auto entry = std::ranges::find(kMethods, name, &MethodEntry::name);
  return entry == kMethods.end() ? nullptr : &*entry;
}

const MethodEntry& requireMethod(std::string_view name, const Location& where) {
  return requireNamed(kMethods, "method", name, where);
}

const MethodEntry& firstMethodThat(bool MethodCapabilities::*can) {
  return *std::ranges::find_if(kMethods, [&](const MethodEntry& e) { return e.can.*can; });
}

std::unique_ptr<Method> makeReference(const Scene& scene) {
  const MethodEntry& entry = firstMethodThat(&MethodCapabilities::reference);
  const Value value = parseYaml("{}", "reference method");
  Fields options(value, "method");
  return entry.make(scene, options);
}

}  // namespace scanmill
