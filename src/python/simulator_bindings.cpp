#include "python/simulator_bindings.h"

#include <fmt/format.h>
#include <pybind11/stl.h>

#include <array>
#include <cmath>
#include <cstring>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/error.h"
#include "dataset/json_text.h"
#include "dataset/manifest.h"
#include "python/arrays.h"
#include "python/simulator.h"

namespace py = pybind11;

namespace scanmill {
namespace {

template <class T>
using Array = py::array_t<T, py::array::c_style | py::array::forcecast>;

template <class T, class V>
std::vector<T> copied(const Array<V>& array) {
  static_assert(sizeof(T) % sizeof(V) == 0);
  std::vector<T> values(static_cast<std::size_t>(array.size()) * sizeof(V) / sizeof(T));
  if (!values.empty()) {
    std::memcpy(static_cast<void*>(values.data()), array.data(), values.size() * sizeof(T));
  }
  return values;
}

Affine affineOf(const Array<double>& matrix) {
  const auto m = matrix.unchecked<2>();
  const auto column = [&](py::ssize_t k) { return Vec3d{m(0, k), m(1, k), m(2, k)}; };
  return {{column(0), column(1), column(2)}, column(3)};
}

py::array_t<double> matrixOf(const Affine& a) {
  std::vector<double> values;
  for (const auto row : {&Vec3d::x, &Vec3d::y, &Vec3d::z}) {
    for (const Vec3d* column : {&a.linear.x, &a.linear.y, &a.linear.z, &a.translation}) values.push_back(column->*row);
  }
  values.insert(values.end(), {0, 0, 0, 1});
  return arrayOf(std::move(values), {4, 4});
}

// Surfaces are tuples (class, material, reflectance or None, number of the thing or -1).
using SurfaceTuple = std::tuple<std::string, std::string, std::optional<float>, std::int64_t>;

ArrayPart partOf(const py::dict& given) {
  ArrayPart part;
  part.name = given["name"].cast<std::string>();
  part.mesh.positions = copied<Vec3f>(given["vertices"].cast<Array<float>>());
  part.mesh.triangles = copied<Triangle>(given["triangles"].cast<Array<std::uint32_t>>());
  part.mesh.surfaceOf = copied<std::uint16_t>(given["surface_of"].cast<Array<std::uint16_t>>());
  for (const auto& [name, material, reflectance, object] : given["surfaces"].cast<std::vector<SurfaceTuple>>()) {
    part.surfaces.push_back({name, material, reflectance.value_or(-1), object});
  }
  part.worldFromMesh = affineOf(given["pose"].cast<Array<double>>());
  return part;
}

// An object's place is a tuple (name, matrix or None, velocity, angular velocity).
using PlaceTuple =
    std::tuple<std::string, std::optional<Array<double>>, std::array<double, 3>, std::array<double, 3>>;

// Poses are arrays (n, 7) of quaternions w, x, y, z and translations.
std::vector<Pose> posesOf(const Array<double>& rows) {
  const auto r = rows.unchecked<2>();
  std::vector<Pose> poses;
  for (py::ssize_t i = 0; i < r.shape(0); ++i) {
    const double norm = std::sqrt(r(i, 0) * r(i, 0) + r(i, 1) * r(i, 1) + r(i, 2) * r(i, 2) + r(i, 3) * r(i, 3));
    if (!(std::abs(norm - 1) < 1e-6)) throw InputError("rotation must be a unit quaternion w, x, y, z");
    poses.push_back({{r(i, 0) / norm, r(i, 1) / norm, r(i, 2) / norm, r(i, 3) / norm}, {r(i, 4), r(i, 5), r(i, 6)}});
  }
  return poses;
}

py::list simulate(const Simulator& simulator, const std::vector<Array<double>>& poses, double time, std::uint32_t frame,
                  const std::vector<PlaceTuple>& objects, bool moving) {
  SimulatedShot wanted;
  for (const Array<double>& rows : poses) wanted.worldFromVehicle.push_back(posesOf(rows));
  wanted.time = time;
  wanted.frame = frame;
  wanted.moving = moving;
  for (const auto& [name, matrix, v, w] : objects) {
    ObjectPlace& place = wanted.objects.emplace_back();
    place.name = name;
    if (matrix) place.worldFromObject = affineOf(*matrix);
    place.velocity = {v[0], v[1], v[2]};
    place.turning = {w[0], w[1], w[2]};
  }
  std::vector<SimulatedScan> scans;
  {
    const py::gil_scoped_release released;
    scans = simulator.scan(wanted);
  }
  py::list all;
  for (SimulatedScan& own : scans) {
    const bool empty = own.scan.size() == 0;
    py::dict arrays = arraysOf(std::move(own.scan));
    if (empty) addEmptyColumns(scanColumnNames(simulator.plan().columns()), arrays);
    arrays["world_from_sensor"] = matricesOf(own.worldFromSensor);
    all.append(std::move(arrays));
  }
  return all;
}

}  // namespace

void defineSimulator(py::module_& module) {
  py::class_<Simulator>(module, "Simulator")
      .def(py::init([](const std::string& pipeline, const std::string& folder, const std::vector<py::dict>& given,
                       bool placeable) {
             std::vector<ArrayPart> parts;
             for (const py::dict& part : given) parts.push_back(partOf(part));
             const py::gil_scoped_release released;
             return std::make_unique<Simulator>(pipeline, folder, std::move(parts), placeable);
           }),
           py::arg("pipeline"), py::arg("folder"), py::arg("parts") = std::vector<py::dict>(),
           py::arg("placeable") = false)
      .def_property_readonly("sensors",
                             [](const Simulator& s) {
                               std::vector<std::string> names;
                               for (const MountedSensor& sensor : s.plan().pipeline.sensors)
                                 names.push_back(sensor.name);
                               return names;
                             })
      .def_property_readonly("sizes",
                             [](const Simulator& s) {
                               std::vector<std::pair<std::uint32_t, std::uint32_t>> sizes;
                               for (const auto& [beams, footprint] : s.plan().sensors)
                                 sizes.emplace_back(beams->rings, beams->columns);
                               return sizes;
                             })
      .def_property_readonly("durations",
                             [](const Simulator& s) {
                               std::vector<double> durations;
                               for (const auto& [beams, footprint] : s.plan().sensors)
                                 durations.push_back(beams->columnPeriod() * beams->columns);
                               return durations;
                             })
      .def_property_readonly("classes", [](const Simulator& s) { return layOut(ontologyJson(s.scene().ontology)); })
      .def(
          "objects",
          [](const Simulator& s, double time) {
            py::dict all;
            for (const auto& [name, object] : s.objects(time)) {
              all[py::str(name)] = py::make_tuple(matrixOf(object.worldFromObject), object.things, object.moves);
            }
            return all;
          },
          py::arg("time") = 0.0)
      .def("scan", &simulate, py::arg("poses"), py::arg("time") = 0.0, py::arg("frame") = 0,
           py::arg("objects") = std::vector<PlaceTuple>(), py::arg("moving") = false);
}

}  // namespace scanmill
