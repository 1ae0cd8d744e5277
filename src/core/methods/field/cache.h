#pragma once

// Fields on disk, so that a second run need not build what the first has built.

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>

#include "methods/field/distance_field.h"
#include "scene/scene.h"

namespace scanmill {

// Safe to use from several threads and programs at once.
class FieldCache {
 public:
  // Folder of the cache, made when something is first stored; empty: nothing is ever found or stored. `geometry`: see
  // geometryHash().
  FieldCache(std::filesystem::path folder, std::string geometry);

  // The field of exactly this geometry and shape, or null. A file that is truncated, of another version, of other
  // geometry, or changed in any byte is not trusted: null, and the next store() replaces it.
  std::shared_ptr<const DistanceField> find(const FieldShape& shape, const Vec3d& worldOrigin) const;
  // Atomically; what does not fit on the disk or may not be written is a warning, not an error. Afterwards the files
  // that were longest unused are deleted until the folder's fields are at most kCacheBytes; a larger field is not kept.
  void store(const DistanceField& field, const Vec3d& worldOrigin) const;

  static constexpr std::uint64_t kCacheBytes = std::uint64_t{2} << 30;

 private:
  std::filesystem::path file(const FieldShape& shape, const Vec3d& worldOrigin) const;

  std::filesystem::path folder_;
  std::string geometry_;
};

// A hash of all that a field follows from: the triangles, where they are placed, and what decides in which order fields
// name triangles (alpha-tested materials, instance ids).
std::string geometryHash(const Scene& scene);

// $XDG_CACHE_HOME/scanmill/fields, or ~/.cache/scanmill/fields; empty where there is no home.
std::filesystem::path defaultCacheFolder();

}  // namespace scanmill
