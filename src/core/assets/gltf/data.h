#pragma once

// The numbers of a glTF file.

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "assets/gltf/model.h"

namespace scanmill::gltf {

// Reads accessors. Buffers are loaded, and compressed views decoded, when they are first needed. What cannot be throws
// an InputError that names the file; `what` tells in it whose numbers they are.
class Data {
 public:
  explicit Data(const Model& model);  // which is kept by reference
  ~Data();
  Data(const Data&) = delete;
  Data& operator=(const Data&) = delete;

  // All numbers of an accessor, one element after the other; those without data are zeroes. Integers that it says are
  // normalised become 0 to 1, or -1 to 1 (3.6.2.2); others keep their value. Floats may be infinite or NaN.
  std::vector<float> floats(Index accessor, const std::string& what) const;
  // The same, all of them finite.
  std::vector<float> finiteFloats(Index accessor, const std::string& what) const;
  // The same of those that must be floats or normalised.
  std::vector<float> fractions(Index accessor, const std::string& what) const;
  // The same of whole numbers.
  std::vector<std::uint32_t> integers(Index accessor, const std::string& what) const;

  // The bytes of a view, or of the buffer that an address with data: holds.
  std::string_view view(Index view) const;
  std::string embedded(const std::string& uri, const std::string& what) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace scanmill::gltf
