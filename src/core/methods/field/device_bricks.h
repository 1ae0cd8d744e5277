#pragma once

// Makes bricks on a device of OpenGL: what BrickMaker makes on the processor, byte by byte.

#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "methods/field/nearby.h"
#include "methods/world/world.h"

namespace scanmill {

class DeviceBricks {
 public:
  // Throws Error where the machine has no OpenGL 4.3. `most`: bytes of a table or buffer; the device's own limits hold
  // too.
  explicit DeviceBricks(std::uint64_t most = std::numeric_limits<std::uint64_t>::max());
  ~DeviceBricks();

  // Uploads the world's triangles and a hierarchy of them, unless they are there. Throws Error where they do not fit.
  // This and what follows is for one thread at a time.
  void hold(const std::shared_ptr<const World>& world);

  // Of bricks' centres, at most kCentresAtOnce, as a field's table has them (voxels); NaN where the processor must
  // tell. The world that is held has triangles.
  static constexpr std::size_t kCentresAtOnce = 262'144;
  void centres(std::span<const BrickPlace> places, std::span<float> distances);

  // What BrickMaker::make() makes of a brick.
  struct Made {
    bool left = false;                       // to the processor
    std::span<const std::uint32_t> corners;  // two words each of kCornersPerBrick: distance, and word
    std::span<const std::uint32_t> lists;    // words of corners count from here; the last of each list is marked
  };
  // Calls take(i, made) for each place, from several threads at once.
  void make(std::span<const BrickPlace> places, bool lists, const std::function<void(std::size_t, const Made&)>& take);

  std::string device() const;
  bool software() const;  // it runs on the processor

 private:
  class Inside;
  std::unique_ptr<Inside> inside_;
};

}  // namespace scanmill
