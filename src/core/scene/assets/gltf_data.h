#pragma once

// The numbers in a glTF file's buffers, and when its animations begin and end.

#include <cstddef>
#include <filesystem>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "scene/assets/gltf_container.h"

namespace scanmill {

class GltfData {
 public:
  // Keeps a reference to the container, whose buffers, views and accessors have been checked (scene/assets/gltf.h).
  // Throws InputError that names the file, as all below do.
  GltfData(const GltfContainer& container, const std::filesystem::path& file);
  ~GltfData();
  GltfData(const GltfData&) = delete;
  GltfData& operator=(const GltfData&) = delete;

  // All numbers of an accessor, one element after the other; those without data are zeroes. Integers that it says are
  // normalised become 0 to 1, or -1 to 1; others are refused. `what` tells in messages whose they are.
  std::vector<float> floats(std::size_t accessor, const std::string& what);
  // The same of whole numbers of 8 or 16 bits.
  std::vector<float> indices(std::size_t accessor, const std::string& what);

  // The names of the animations, numbers where they have none.
  std::vector<std::string> clips() const;
  // The index of the animation with this name, or of its number where none has that name.
  std::size_t clip(const std::string& name) const;
  // When the first of an animation's key frames is, and when the last (s).
  std::pair<double, double> spanOf(std::size_t clip);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace scanmill
