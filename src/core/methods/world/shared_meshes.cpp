#include "methods/world/shared_meshes.h"

#include <algorithm>
#include <cmath>

#include "base/parallel.h"
#include "scene/embree.h"

namespace scanmill {

namespace {

// Returns a mesh that has the triangles of `mesh` with these indices, and only the vertices that these triangles use.
Mesh excerpt(const Mesh& mesh, const std::vector<std::uint32_t>& triangles) {
  constexpr std::uint32_t kUnused = 0xFFFFFFFFu;
  thread_local std::vector<std::uint32_t> numbers;  // by vertex of the mesh: its number in the excerpt, or kUnused
  if (numbers.size() < mesh.positions.size()) numbers.resize(mesh.positions.size(), kUnused);
  Mesh part;
  part.surfaces = mesh.surfaces;
  // Memory is reserved for all elements, so that nothing throws while `numbers` is in use.
  part.triangles.reserve(triangles.size());
  part.surfaceOf.reserve(triangles.size());
  part.positions.reserve(3 * triangles.size());
  if (!mesh.uvs.empty()) part.uvs.reserve(3 * triangles.size());
  for (const std::uint32_t t : triangles) {
    Triangle corners = mesh.triangles[t];
    for (std::uint32_t& corner : corners) {
      std::uint32_t& number = numbers[corner];
      if (number == kUnused) {
        number = static_cast<std::uint32_t>(part.positions.size());
        part.positions.push_back(mesh.positions[corner]);
        if (!mesh.uvs.empty()) part.uvs.push_back(mesh.uvs[corner]);
      }
      corner = number;
    }
    part.triangles.push_back(corners);
    part.surfaceOf.push_back(mesh.surfaceOf[t]);
  }
  for (const std::uint32_t t : triangles) {
    for (const std::uint32_t corner : mesh.triangles[t]) numbers[corner] = kUnused;
  }
  return part;
}

}  // namespace

SharedMeshes::SharedMeshes(RTCDeviceTy* device, const Scene& scene, const std::vector<bool>& instanced,
                           const HierarchyOptions& options, bool divided)
    : device_(device), scene_(scene), options_(options) {
  for (std::size_t m = 0; m < scene.meshes.size(); ++m) {
    const Mesh& mesh = scene.meshes[m];
    firstPart_.push_back(parts_.size());
    if (!instanced[m]) continue;
    divided&& mesh.triangles.size() > 2 * kTrianglesOfPart ? divide(mesh) : addPart(mesh, mesh.bounds(), {});
  }
  firstPart_.push_back(parts_.size());
}

// Divides a mesh by a grid of squares, seen from above, into parts of kTrianglesOfPart triangles on average. A triangle
// belongs to the square of its first corner.
void SharedMeshes::divide(const Mesh& mesh) {
  const Box box = mesh.bounds();
  const double width = box.high.x - box.low.x;
  const double depth = box.high.y - box.low.y;
  const double squares = std::ceil(static_cast<double>(mesh.triangles.size()) / double{kTrianglesOfPart});
  const double side = std::max(std::sqrt(width * depth / squares), std::max(width, depth) / squares);
  if (!(side > 0)) return addPart(mesh, box, {});
  const auto columns = static_cast<std::size_t>(width / side) + 1;
  const auto rows = static_cast<std::size_t>(depth / side) + 1;
  std::vector<std::vector<std::uint32_t>> cells(columns * rows);
  std::vector<Box> boxes(cells.size());
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    const Triangle& corners = mesh.triangles[t];
    const Vec3d a(mesh.positions[corners[0]]);
    const std::size_t cell = static_cast<std::size_t>((a.y - box.low.y) / side) * columns +
                             static_cast<std::size_t>((a.x - box.low.x) / side);
    cells[cell].push_back(t);
    for (const std::uint32_t corner : corners) boxes[cell].add(Vec3d(mesh.positions[corner]));
  }
  for (std::size_t cell = 0; cell < cells.size(); ++cell) {
    if (!cells[cell].empty()) addPart(mesh, boxes[cell], std::move(cells[cell]));
  }
}

void SharedMeshes::addPart(const Mesh& mesh, const Box& bounds, std::vector<std::uint32_t> triangles) {
  Part& part = parts_.emplace_back();
  part.mesh = &mesh;
  part.bounds = bounds;
  part.triangles = std::move(triangles);
}

void SharedMeshes::build(std::span<const std::size_t> numbers) const {
  parallelForEach(numbers.size(), 1, [&](std::size_t i) {
    Part& part = parts_[numbers[i]];
    Part::State missing = Part::State::Missing;
    if (!part.state.compare_exchange_strong(missing, Part::State::InProgress)) return;
    try {
      buildPart(part);
    } catch (...) {
      part.failure = std::current_exception();  // rethrown in each thread that needs the part
    }
    part.state = Part::State::Finished;
    part.state.notify_all();
  });
  for (const std::size_t number : numbers) {
    Part& part = parts_[number];
    part.state.wait(Part::State::InProgress);  // another thread builds the part
    if (part.failure) std::rethrow_exception(part.failure);
  }
}

// Sets the part's block and hierarchy.
void SharedMeshes::buildPart(Part& part) const {
  if (part.triangles.empty()) {
    part.block = blockOf(scene_, *part.mesh);
  } else {
    part.block = blockOf(scene_, excerpt(*part.mesh, part.triangles));
    for (BlockTriangle& triangle : part.block->triangles) triangle.primitive = part.triangles[triangle.primitive];
    part.triangles = std::vector<std::uint32_t>();  // frees the memory
  }
  part.hierarchy = newScene(device_);
  attachBlock(device_, part.hierarchy.get(), *part.block, options_);
  isolated([&] { rtcCommitScene(part.hierarchy.get()); });
  checkEmbree(device_, "build the shared meshes");  // Embree keeps an error for the thread in which it occurs
}

}  // namespace scanmill
