#pragma once

// The instanced meshes and Embree's hierarchies of them, which the worlds of all origins and revolutions share. A
// hierarchy is built when a world first needs it. Large meshes, such as the ground of a town, are divided into parts:
// the ground far from the sensor then needs no hierarchy.

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <exception>
#include <memory>
#include <span>
#include <vector>

#include "methods/world/block.h"

namespace scanmill {

class SharedMeshes {
 public:
  // Triangles of one mesh that share a hierarchy. build() sets the members that follow the bounds.
  struct Part {
    enum class State { Missing, InProgress, Finished };

    const Mesh* mesh = nullptr;
    std::vector<std::uint32_t> triangles;  // ascending indices; empty if all of the mesh, or after building
    Box bounds;                            // m, in the mesh's axes
    std::unique_ptr<TriangleBlock> block;
    SceneHandle hierarchy;
    std::exception_ptr failure;
    std::atomic<State> state = State::Missing;
  };

  // `instanced`: for each mesh, true if it is instanced and thus has parts. If `divided` is true, meshes of more than
  // 2 * kTrianglesOfPart triangles have several parts. The scene and the device must outlive this object.
  SharedMeshes(RTCDeviceTy* device, const Scene& scene, const std::vector<bool>& instanced,
               const HierarchyOptions& options, bool divided = false);

  // Returns the number of a mesh's first part. The mesh's last part has the number firstPart(mesh + 1) - 1.
  std::size_t firstPart(std::size_t mesh) const { return firstPart_[mesh]; }
  const Part& part(std::size_t number) const { return parts_[number]; }

  // Builds the parts with these numbers that are missing. Threads that want the same parts share the work. Throws Error
  // if Embree fails. Safe to call from several threads.
  void build(std::span<const std::size_t> numbers) const;

  static constexpr std::size_t kTrianglesOfPart = 12000;  // mean number of triangles of the parts of a large mesh

 private:
  void divide(const Mesh& mesh);
  void addPart(const Mesh& mesh, const Box& bounds, std::vector<std::uint32_t> triangles);
  void buildPart(Part& part) const;

  RTCDeviceTy* device_;
  const Scene& scene_;
  HierarchyOptions options_;
  std::vector<std::size_t> firstPart_;  // by mesh, and one more entry
  mutable std::deque<Part> parts_;
};

}  // namespace scanmill
