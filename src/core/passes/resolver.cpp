#include "passes/resolver.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "base/parallel.h"
#include "scene/triangles.h"

namespace scanmill {

namespace {

constexpr std::size_t kResolverGrain = 4096;  // pixels per task
constexpr std::size_t kLanes = 64;  // pixels that are processed together, so that their memory accesses overlap

// A camera's view. The line of sight through the centre of pixel (column i, row j) has the direction
// corner + right * i + down * j (world axes, not normalised).
struct ImageView {
  PixelAddress firstPixel = 0;  // address of the image's first pixel
  std::uint32_t width = 0;      // px
  Vec3d corner, right, down;
  Vec3d eye;  // position of the camera (m, world axes)
};

}  // namespace

// The arguments of resolve(), and the cameras' views.
struct Resolver::Job {
  std::vector<PixelAddress> firsts;  // see firstPixels()
  std::vector<ImageView> views;
  std::span<const PixelAddress> addresses;
  std::span<const VisibleTriangle> triangles;
  PassPlanes& planes;

  const ImageView& viewOf(PixelAddress address) const { return views[imageOf(firsts, address)]; }
};

// At most kLanes consecutive pixels of a job, [first, first + count), and the records of their triangles.
struct Resolver::PixelBlock {
  static constexpr Face kNoFace{};  // stands for a pixel without a surface

  std::size_t first, count;
  std::array<const PlacedMesh*, kLanes> meshes;
  std::array<const Face*, kLanes> faces;
  std::array<SurfaceIds, kLanes> surfaces;

  bool showsSurface(std::size_t i) const { return faces[i] != &kNoFace; }
};

namespace {

// Returns the direction of the line of sight through a pixel's centre (world axes, not normalised).
Vec3d sightOf(const ImageView& view, PixelAddress address) {
  const std::uint32_t pixel = address - view.firstPixel;
  const std::uint32_t row = pixel / view.width;
  return view.corner + view.right * (pixel - row * view.width) + view.down * row;
}

std::vector<ImageView> viewsOf(std::span<const Camera> cameras, std::span<const PixelAddress> firsts) {
  std::vector<ImageView> views;
  for (std::size_t k = 0; k < cameras.size(); ++k) {
    const Camera& camera = cameras[k];
    const Mat3 rotation = toMatrix(camera.worldFromCamera.rotation);
    views.push_back({.firstPixel = firsts[k],
                     .width = camera.width,
                     .corner = rotation * camera.ray(0.5, 0.5),
                     .right = rotation.x * (1 / camera.fx),
                     .down = rotation.y * (1 / camera.fy),
                     .eye = camera.worldFromCamera.translation});
  }
  return views;
}

}  // namespace

Resolver::Resolver(const Scene& scene) : scene_(scene) {
  std::vector<std::size_t> firstFaces;  // by mesh: index in faces_ of its first triangle
  std::size_t faceCount = 0;
  for (const Mesh& mesh : scene.meshes) {
    firstFaces.push_back(faceCount);
    faceCount += mesh.triangles.size();
  }
  faces_.resize(faceCount);
  for (std::size_t m = 0; m < scene.meshes.size(); ++m) {
    const Mesh& mesh = scene.meshes[m];
    const auto firstSurface = static_cast<std::uint32_t>(surfaces_.size());
    for (const Surface& s : mesh.surfaces) surfaces_.push_back({s.object, s.semantic, s.material});
    parallelForEach(mesh.triangles.size(), kResolverGrain, [&](std::size_t t) {
      const auto [a, b, c] = cornersOf(mesh, static_cast<std::uint32_t>(t));
      faces_[firstFaces[m] + t] = {normalized(cross(b - a, c - a)), firstSurface + mesh.surfaceOf[t]};
    });
  }
  instances_.emplace_back();
  for (const Instance& instance : scene.instances) {
    const Mat3& m = instance.worldFromMesh.linear;
    instances_.push_back({{cross(m.y, m.z), cross(m.z, m.x), cross(m.x, m.y)},
                          faces_.data() + firstFaces[instance.mesh],
                          instance.firstInstanceId});
  }
  for (const Material& m : scene.materials) {
    materials_.push_back({compact(m), m.roughness, m.metallic, m.retroreflectance});
  }
}

void Resolver::resolve(std::span<const Camera> cameras, std::span<const PixelAddress> addresses,
                       std::span<const VisibleTriangle> triangles, PassChoice requested, PassPlanes& planes) const {
  planes.reset(triangles.size(), requested);
  Job job{firstPixels(cameras), {}, addresses, triangles, planes};
  job.views = viewsOf(cameras, job.firsts);
  parallelFor(triangles.size(), kResolverGrain, [&](std::size_t first, std::size_t end) {
    for (std::size_t i = first; i < end; i += kLanes) {
      const PixelBlock block = gatherBlock(job, i, std::min(i + kLanes, end));
      storeSurfaces(job, block);
      if (!planes.normal.empty()) storeNormals(job, block);
    }
  });
}

// Looks up the records of pixels [first, end), at most kLanes. The first loop prefetches records for the second.
Resolver::PixelBlock Resolver::gatherBlock(const Job& job, std::size_t first, std::size_t end) const {
  PixelBlock block;
  block.first = first;
  block.count = end - first;
  for (std::size_t i = 0; i < block.count; ++i) {
    const VisibleTriangle& visible = job.triangles[first + i];
    const bool hasSurface = visible.instance != 0 && job.addresses[first + i] != kNoPixel;
    block.meshes[i] = &instances_[hasSurface ? visible.instance : 0];
    block.faces[i] = hasSurface ? block.meshes[i]->faces + visible.triangle : &PixelBlock::kNoFace;
    __builtin_prefetch(block.faces[i]);
  }
  for (std::size_t i = 0; i < block.count; ++i) {
    block.surfaces[i] = block.showsSurface(i) ? surfaces_[block.faces[i]->surface] : SurfaceIds{};
  }
  return block;
}

// Stores the block's values in all requested planes except the plane of normals.
void Resolver::storeSurfaces(const Job& job, const PixelBlock& block) const {
  const VisibleTriangle* const triangles = &job.triangles[block.first];
  const PixelAddress* const addresses = &job.addresses[block.first];
  PassPlanes& planes = job.planes;
  // Stores valueOf(i) for each pixel with a surface, otherwise `background`, if the plane is requested.
  const auto store = [&]<class T>(std::vector<T>& plane, const auto& valueOf, T background = {}) {
    if (plane.empty()) return;
    for (std::size_t i = 0; i < block.count; ++i) {
      plane[block.first + i] = block.showsSurface(i) ? valueOf(i) : background;
    }
  };
  const auto materialOf = [&](std::size_t i) -> const MaterialValues& {
    return materials_[block.surfaces[i].material];
  };
  store(
      planes.depth, [&](std::size_t i) { return triangles[i].depth; }, kNoDepth);
  store(planes.instance,
        [&](std::size_t i) { return instanceId(block.meshes[i]->firstInstanceId, block.surfaces[i].object); });
  store(planes.semantic, [&](std::size_t i) { return block.surfaces[i].semantic; });
  store(planes.material, [&](std::size_t i) { return block.surfaces[i].material; });
  store(planes.primitive, [&](std::size_t i) { return triangles[i].triangle; });
  store(planes.roughness, [&](std::size_t i) { return materialOf(i).roughness; });
  store(planes.metallic, [&](std::size_t i) { return materialOf(i).metallic; });
  store(planes.retroreflectance, [&](std::size_t i) { return materialOf(i).retroreflectance; });
  store(planes.reflectance, [&](std::size_t i) {
    const CompactMaterial& material = materialOf(i).reflecting;
    if (material.texture == nullptr) return material.reflectance;
    const ImageView& view = job.viewOf(addresses[i]);
    return texturedReflectance(triangles[i], material, view.eye, sightOf(view, addresses[i]));
  });
}

// Stores the block's unit normals, turned towards the camera; zero for pixels without a surface. The first loop gathers
// values from memory, pixel by pixel. The second loop has no branch and is vectorised.
void Resolver::storeNormals(const Job& job, const PixelBlock& block) {
  alignas(64) std::array<double, kLanes> x, y, z;
  alignas(64) std::array<double, kLanes> along;  // dot product of the normal and the line of sight
  for (std::size_t i = 0; i < block.count; ++i) {
    const Vec3d n = block.meshes[i]->normalFromMesh * block.faces[i]->normal;
    const PixelAddress address = job.addresses[block.first + i];
    x[i] = n.x;
    y[i] = n.y;
    z[i] = n.z;
    along[i] = block.showsSurface(i) ? dot(n, sightOf(job.viewOf(address), address)) : 0;
  }
  for (std::size_t i = 0; i < block.count; ++i) {
    const double square = x[i] * x[i] + y[i] * y[i] + z[i] * z[i];
    const double scale = square > 0 ? 1 / std::sqrt(square) : 0;
    const double signedScale = along[i] > 0 ? -scale : scale;
    job.planes.normal[block.first + i] = {static_cast<float>(x[i] * signedScale),
                                          static_cast<float>(y[i] * signedScale),
                                          static_cast<float>(z[i] * signedScale)};
  }
}

// Returns the reflectance of the texture at the point where the line of sight intersects the triangle's plane. All
// coordinates are relative to `eye` (the camera's position), so that a scene far from the origin loses no precision.
float Resolver::texturedReflectance(const VisibleTriangle& visible, const CompactMaterial& material, const Vec3d& eye,
                                    const Vec3d& sight) const {
  const Instance& instance = scene_.instances[visible.instance - 1];
  const Mesh& mesh = scene_.meshes[instance.mesh];
  const Affine eyeFromMesh{instance.worldFromMesh.linear, instance.worldFromMesh.translation - eye};
  const auto [a, b, c] = cornersOf(eyeFromMesh, mesh, visible.triangle);
  const Vec3d ab = b - a;
  const Vec3d ac = c - a;
  const Vec3d normal = cross(ab, ac);
  const Vec3d point = sight * (dot(normal, a) / dot(normal, sight)) - a;  // relative to the corner a
  return material.texturedAt(
      textureCoordinates(mesh.uvs, mesh.triangles[visible.triangle], barycentric(ab, ac, point)));
}

}  // namespace scanmill
