#include "passes/resolver.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "base/parallel.h"

namespace scanmill {

namespace {

constexpr std::size_t kResolverGrain = 4096;  // pixels per task
constexpr std::size_t kLanes = 64;  // pixels that are processed together, so that their memory accesses overlap

// A camera's view. The line of sight through pixel (i, j) has the direction corner + right * i + down * j, in world
// axes.
struct ImageView {
  PixelAddress first = 0;  // address of the image's first pixel
  std::uint32_t width = 0;
  Vec3d corner, right, down;
  Vec3d eye;
};

}  // namespace

struct Resolver::Job {
  std::vector<PixelAddress> firsts;  // see firstPixels()
  std::vector<ImageView> views;
  std::span<const PixelAddress> addresses;
  std::span<const SeenTriangle> seen;
  PassPlanes& planes;

  const ImageView& viewOf(PixelAddress address) const { return views[imageOf(firsts, address)]; }
};

namespace {

Vec3d sightOf(const ImageView& view, PixelAddress address) {
  const std::uint32_t pixel = address - view.first;
  const std::uint32_t row = pixel / view.width;
  return view.corner + view.right * (pixel - row * view.width) + view.down * row;
}

std::vector<ImageView> viewsOf(std::span<const Camera> cameras, std::span<const PixelAddress> firsts) {
  std::vector<ImageView> views;
  for (std::size_t k = 0; k < cameras.size(); ++k) {
    const Camera& camera = cameras[k];
    const Mat3 rotation = toMatrix(camera.worldFromCamera.rotation);
    views.push_back({firsts[k], camera.width, rotation * camera.ray(0.5, 0.5), rotation.x * (1 / camera.fx),
                     rotation.y * (1 / camera.fy), camera.worldFromCamera.translation});
  }
  return views;
}

}  // namespace

Resolver::Resolver(const Scene& scene) : scene_(scene) {
  std::vector<std::size_t> firstFace;
  std::size_t faces = 0;
  for (const Mesh& mesh : scene.meshes) {
    firstFace.push_back(faces);
    faces += mesh.triangles.size();
  }
  faces_.resize(faces);
  for (std::size_t m = 0; m < scene.meshes.size(); ++m) {
    const Mesh& mesh = scene.meshes[m];
    const auto firstSurface = static_cast<std::uint32_t>(surfaces_.size());
    for (const Surface& s : mesh.surfaces) surfaces_.push_back({s.object, s.semantic, s.material});
    parallelFor(mesh.triangles.size(), kResolverGrain, [&](std::size_t first, std::size_t last) {
      for (std::size_t t = first; t < last; ++t) {
        const Triangle& corners = mesh.triangles[t];
        const Vec3d a(mesh.positions[corners[0]]);
        const Vec3d ab = Vec3d(mesh.positions[corners[1]]) - a;
        const Vec3d ac = Vec3d(mesh.positions[corners[2]]) - a;
        faces_[firstFace[m] + t] = {normalized(cross(ab, ac)), firstSurface + mesh.surfaceOf[t]};
      }
    });
  }
  instances_.emplace_back();
  for (const Instance& instance : scene.instances) {
    const Mat3& m = instance.worldFromMesh.linear;
    instances_.push_back({{cross(m.y, m.z), cross(m.z, m.x), cross(m.x, m.y)},
                          faces_.data() + firstFace[instance.mesh],
                          instance.firstInstanceId});
  }
  for (const Material& m : scene.materials) {
    materials_.push_back({compact(m), m.roughness, m.metallic, m.retroreflectance});
  }
}

void Resolver::resolve(std::span<const Camera> cameras, std::span<const PixelAddress> addresses,
                       std::span<const SeenTriangle> seen, PassChoice asked, PassPlanes& planes) const {
  planes.reset(seen.size(), asked);
  Job job{firstPixels(cameras), {}, addresses, seen, planes};
  job.views = viewsOf(cameras, job.firsts);
  parallelFor(seen.size(), kResolverGrain, [&](std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; i += kLanes) resolveBlock(job, i, std::min(i + kLanes, last));
  });
}

void Resolver::resolveBlock(const Job& job, std::size_t first, std::size_t last) const {
  const std::size_t count = last - first;
  const SeenTriangle* const seen = &job.seen[first];
  const PixelAddress* const addresses = &job.addresses[first];
  PassPlanes& planes = job.planes;

  std::array<const Placed*, kLanes> placed;
  std::array<const Face*, kLanes> faces;
  static constexpr Face kNothing{};
  for (std::size_t i = 0; i < count; ++i) {
    const bool isSeen = seen[i].instance != 0 && addresses[i] != kNoPixel;
    placed[i] = &instances_[isSeen ? seen[i].instance : 0];
    faces[i] = isSeen ? placed[i]->faces + seen[i].triangle : &kNothing;
    __builtin_prefetch(faces[i]);
    planes.depth[first + i] = isSeen ? seen[i].depth : kNoDepth;
  }

  std::array<SurfaceIds, kLanes> surfaces;
  for (std::size_t i = 0; i < count; ++i)
    surfaces[i] = faces[i] != &kNothing ? surfaces_[faces[i]->surface] : SurfaceIds{};
  const auto store = [&](auto& plane, const auto& value) {
    if (plane.empty()) return;
    for (std::size_t i = 0; i < count; ++i) {
      plane[first + i] = faces[i] != &kNothing ? value(i) : std::remove_cvref_t<decltype(plane[0])>{};
    }
  };
  store(planes.instance, [&](std::size_t i) { return instanceId(placed[i]->firstInstanceId, surfaces[i].object); });
  store(planes.semantic, [&](std::size_t i) { return surfaces[i].semantic; });
  store(planes.material, [&](std::size_t i) { return surfaces[i].material; });
  store(planes.primitive, [&](std::size_t i) { return seen[i].triangle; });
  const auto finishOf = [&](std::size_t i) -> const Finish& { return materials_[surfaces[i].material]; };
  store(planes.roughness, [&](std::size_t i) { return finishOf(i).roughness; });
  store(planes.metallic, [&](std::size_t i) { return finishOf(i).metallic; });
  store(planes.retroreflectance, [&](std::size_t i) { return finishOf(i).retroreflectance; });
  store(planes.reflectance, [&](std::size_t i) {
    const CompactMaterial& material = finishOf(i).base;
    if (material.texture == nullptr) return material.reflectance;
    const ImageView& view = job.viewOf(addresses[i]);
    return texturedReflectance(seen[i], material, view.eye, sightOf(view, addresses[i]));
  });
  if (planes.normal.empty()) return;

  // The first loop gathers values from memory, pixel by pixel. The second loop has no branch and is vectorised.
  alignas(64) std::array<double, kLanes> x, y, z, along;
  for (std::size_t i = 0; i < count; ++i) {
    const Vec3d n = placed[i]->normalFromMesh * faces[i]->normal;
    x[i] = n.x;
    y[i] = n.y;
    z[i] = n.z;
    along[i] = faces[i] != &kNothing ? dot(n, sightOf(job.viewOf(addresses[i]), addresses[i])) : 0;
  }
  for (std::size_t i = 0; i < count; ++i) {
    const double square = x[i] * x[i] + y[i] * y[i] + z[i] * z[i];
    const double scale = square > 0 ? 1 / std::sqrt(square) : 0;
    const double signedScale = along[i] > 0 ? -scale : scale;
    planes.normal[first + i] = {static_cast<float>(x[i] * signedScale), static_cast<float>(y[i] * signedScale),
                                static_cast<float>(z[i] * signedScale)};
  }
}

// Returns the reflectance of the texture at the point where the line of sight intersects the triangle's plane. All
// coordinates are relative to the eye, so that a scene far from the origin loses no precision.
float Resolver::texturedReflectance(const SeenTriangle& seen, const CompactMaterial& material, const Vec3d& eye,
                                    const Vec3d& sight) const {
  const Instance& instance = scene_.instances[seen.instance - 1];
  const Mesh& mesh = scene_.meshes[instance.mesh];
  const Triangle& corners = mesh.triangles[seen.triangle];
  const Affine eyeFromMesh{instance.worldFromMesh.linear, instance.worldFromMesh.translation - eye};
  const auto corner = [&](int i) { return eyeFromMesh * Vec3d(mesh.positions[corners[i]]); };
  const Vec3d a = corner(0);
  const Vec3d ab = corner(1) - a;
  const Vec3d ac = corner(2) - a;
  const Vec3d n = cross(ab, ac);
  const Vec3d p = sight * (dot(n, a) / dot(n, sight)) - a;
  return material.texturedAt(textureCoordinates(mesh.uvs, corners, barycentric(ab, ac, p)));
}

}  // namespace scanmill
