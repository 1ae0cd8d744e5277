#pragma once

// Converts between numpy arrays and values of C++. Arrays of scans take over the memory of the scan's columns; only
// unsigned integers of 16 bits and more are copied, to signed integers, because PyTorch before 2.3 lacks these types.

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <cstdint>
#include <cstring>
#include <memory>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "scan/scan.h"
#include "sensors/beams.h"

namespace scanmill {

// Functions that add a class to the extension module: PassRecorder writes images of depth cameras as a recording of
// passes; Simulator makes scans (simulator.cpp).
void defineJobs(pybind11::module_& module);
void definePassRecorder(pybind11::module_& module);
void defineSimulator(pybind11::module_& module);

// An array argument with elements T in C order. Python's arrays of other types or orders are converted.
template <class T>
using Array = pybind11::array_t<T, pybind11::array::c_style | pybind11::array::forcecast>;

// Copies an array into values T that consist of one or several elements each, such as Vec3f.
template <class T, class V>
std::vector<T> copied(const Array<V>& array) {
  static_assert(sizeof(T) % sizeof(V) == 0);
  std::vector<T> values(static_cast<std::size_t>(array.size()) * sizeof(V) / sizeof(T));
  if (!values.empty()) {
    std::memcpy(static_cast<void*>(values.data()), array.data(), values.size() * sizeof(T));
  }
  return values;
}

// Returns an array that takes over the memory of `values`, each of which consists of one element or several.
template <class T, class V>
pybind11::array_t<T> arrayOf(std::vector<V>&& values, const std::vector<pybind11::ssize_t>& shape) {
  static_assert(sizeof(V) % sizeof(T) == 0);
  auto elements = std::make_unique<std::vector<V>>(std::move(values));
  auto* const data = reinterpret_cast<T*>(elements->data());
  const pybind11::capsule owner(elements.release(), [](void* vector) { delete static_cast<std::vector<V>*>(vector); });
  return pybind11::array_t<T>(shape, data, owner);
}

// Type of an array's elements: int32 for uint16, and int64 for uint32 and uint64 (PyTorch may lack these); else T.
template <class T>
using ArrayType = std::conditional_t<
    std::is_same_v<T, std::uint16_t>, std::int32_t,
    std::conditional_t<std::is_same_v<T, std::uint32_t> || std::is_same_v<T, std::uint64_t>, std::int64_t, T>>;

// Returns a column as an array with elements ArrayType<T>; takes over the memory of `values` if that type is T.
template <class T>
pybind11::array columnArray(std::vector<T>&& values, const std::vector<pybind11::ssize_t>& shape) {
  if constexpr (std::is_same_v<T, ArrayType<T>>) {
    return arrayOf<T>(std::move(values), shape);
  } else {
    return arrayOf<ArrayType<T>>(std::vector<ArrayType<T>>(values.begin(), values.end()), shape);
  }
}

// Returns a dictionary of arrays. The array "xyz" is float32 and has the shape (points, 3). Each column of the scan has
// an array with the column's name, and the shape (points,). If the scan is organised, the shapes are
// (planes * rings, columns, 3) and (planes * rings, columns).
inline pybind11::dict arraysOf(Scan&& scan) {
  std::vector<pybind11::ssize_t> shape{scan.width()};  // the width of a dense scan is its number of points
  if (scan.organised) shape.insert(shape.begin(), scan.height());
  pybind11::dict arrays;
  arrays["xyz"] = pybind11::none();  // so that xyz is the first key
  visitColumns(scan, [&]<class T>(std::string_view name, std::vector<T>& values) {
    arrays[pybind11::str(std::string(name))] = columnArray(std::move(values), shape);
  });
  shape.push_back(3);
  arrays["xyz"] = arrayOf<float>(std::move(scan.position), shape);
  return arrays;
}

// Returns the poses as 4 x 4 matrices, in an array of the shape (poses, 4, 4).
inline pybind11::array_t<double> matricesOf(const std::vector<Pose>& poses) {
  std::vector<double> values;
  for (const Pose& pose : poses) {
    const std::array<double, 16> rows = matrixRows(toAffine(pose));
    values.insert(values.end(), rows.begin(), rows.end());
  }
  return arrayOf<double>(std::move(values), {static_cast<pybind11::ssize_t>(poses.size()), 4, 4});
}

// Returns the arguments of the Python class Stagger: the shift of each ring in a destaggered image, and its width.
inline pybind11::tuple staggerOf(const BeamTable& beams) {
  const Destagger image = destagger(beams);
  return pybind11::make_tuple(
      arrayOf<std::int64_t>(std::vector<std::int64_t>(image.shift.begin(), image.shift.end()), {beams.rings}),
      image.width);
}

// Adds the missing columns of a scan without points as empty arrays: Draco may leave out the column `time`.
inline void addEmptyColumns(const std::vector<std::string>& names, pybind11::dict& arrays) {
  for (const std::string& name : names) {
    const std::size_t index = columnIndex(name);
    if (index == kColumnCount || arrays.contains(name.c_str())) continue;
    forEachColumn([&](auto key) {
      if (key.index == index)
        arrays[pybind11::str(name)] = columnArray(std::vector<typename decltype(key)::Value>(), {0});
    });
  }
}

}  // namespace scanmill
