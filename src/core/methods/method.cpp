#include "methods/method.h"

#include <array>

#include "methods/depth_camera/depth_camera.h"
#include "methods/particle/particle.h"
#include "methods/ray_tracing/ray_tracing.h"

namespace scanmill {

namespace {

constexpr std::array kMethods{
    MethodEntry{"ray_tracing", "Embree on all cores: exact, the reference of the other methods",
                "packet: 16 or 1, rays a call; "
                "tile_columns: auto, 1, 2, 4, 8 or 16, columns of a packet; "
                "robust: true, watertight at the edges of triangles; "
                "bvh: medium, low or high, quality of the hierarchy; "
                "instancing: auto, always or never; "
                "simplify: 1, share of the triangles that is kept, as in collision meshes",
                makeRayTracing},
    MethodEntry{"depth_camera", "images of depth, normals and ids, drawn at the sensor and sampled at the beams",
                "renderer: vtk or blender, what draws; "
                "layout: auto, three_120, four_90 or cube_6, where the cameras look; "
                "resolution: 2048 pixels across an image, 128 to 4096; "
                "sampling: plane, nearest, bilinear, row_hyperbola, equirectangular or pixel_row; "
                "depth: float32, uint24, uint16 or half_500, how depths are stored; "
                "antialiasing: 1, 2 or 4, subpixels per side of a pixel; "
                "near_m: 0.01 m, nearer surfaces are not drawn; "
                "far_m: the sensor's range, m, farther surfaces are not drawn; "
                "renders_per_turn: auto or a number, images of a moving sensor",
                makeDepthCamera},
    MethodEntry{"particle", "one particle per beam flies through a distance field, on the processor or a GPU",
                "field: sensor or scene, levels around each sensor or one for the whole scene; "
                "voxel_m: 0.1 m, voxels of the finest level; "
                "voxels: 256, across each level around a sensor, 64 to 1024; "
                "levels: auto or 1 to 16, each twice as coarse as the one before; "
                "refine: triangle, normal or none, how hits are made exact; "
                "cone_mrad: 0 mrad, half of the angle in which a beam meets things (normal, none); "
                "steps: 512, a particle's budget; "
                "backend: auto, cpu or gl; "
                "cache: auto, none or a folder, where fields are kept from run to run; "
                "smallest_m: none, m, the smallest ball that every beam through its middle meets (normal, none); "
                "smallest_within_m: 30 m, so far from the sensor",
                makeParticle},
};

}  // namespace

std::span<const MethodEntry> methods() {
  return kMethods;
}

const MethodEntry& requireMethod(std::string_view name, const Location& where) {
  std::vector<std::string> names;
  for (const MethodEntry& entry : kMethods) {
    if (entry.name == name) return entry;
    names.emplace_back(entry.name);
  }
  throw InputError(where, "unknown method '" + std::string(name) + "'" + suggestion(name, names));
}

}  // namespace scanmill
