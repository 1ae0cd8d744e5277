#include <fmt/format.h>
#include <pybind11/stl.h>

#include <cmath>
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

// Returns the transform of a matrix of 4 x 4, which is stored row by row.
Affine affineOf(const double* m) {
  const auto column = [&](int k) { return Vec3d{m[k], m[4 + k], m[8 + k]}; };
  return {{column(0), column(1), column(2)}, column(3)};
}

py::array_t<double> matrixOf(const Affine& a) {
  std::vector<double> values;
  for (const auto row : {&Vec3d::x, &Vec3d::y, &Vec3d::z}) {
    for (const Vec3d* column : {&a.linear.x, &a.linear.y, &a.linear.z, &a.translation}) values.push_back(column->*row);
  }
  values.insert(values.end(), {0, 0, 0, 1});
  return arrayOf<double>(std::move(values), {4, 4});
}

// Surfaces are tuples (class, material, reflectance or None, number of the thing or -1).
using SurfaceTuple = std::tuple<std::string, std::string, std::optional<float>, std::int64_t>;

// Converts a part from the dictionary that the Python class Part makes.
ArrayPart partOf(const py::dict& given) {
  ArrayPart part;
  part.name = given["name"].cast<std::string>();
  part.mesh.positions = copied<Vec3f>(given["vertices"].cast<Array<float>>());
  part.mesh.triangles = copied<Triangle>(given["triangles"].cast<Array<std::uint32_t>>());
  part.mesh.surfaceOf = copied<std::uint16_t>(given["surface_of"].cast<Array<std::uint16_t>>());
  for (const auto& [name, material, reflectance, object] : given["surfaces"].cast<std::vector<SurfaceTuple>>()) {
    part.surfaces.push_back({name, material, reflectance.value_or(-1), object});
  }
  const auto pose = given["pose"].cast<Array<double>>();
  if (pose.size() != 16) throw InputError(fmt::format("part '{}': pose must be a matrix of 4 x 4", part.name));
  part.worldFromMesh = affineOf(pose.data());
  return part;
}

// Returns the poses of objects by their names, from arrays: matrices (n, 4, 4), linear and angular velocities (n, 6),
// and whether they are left out (n,).
std::vector<ObjectPose> objectPosesOf(const std::vector<std::string>& names, const Array<double>& matrices,
                                      const Array<double>& velocities, const Array<bool>& hidden) {
  const auto v = velocities.unchecked<2>();
  const auto h = hidden.unchecked<1>();
  std::vector<ObjectPose> poses;
  for (py::ssize_t i = 0; i < static_cast<py::ssize_t>(names.size()); ++i) {
    ObjectPose& pose = poses.emplace_back();
    pose.name = names[static_cast<std::size_t>(i)];
    if (!h(i)) pose.worldFromObject = affineOf(matrices.data(i));
    pose.velocity = {v(i, 0), v(i, 1), v(i, 2)};
    pose.turning = {v(i, 3), v(i, 4), v(i, 5)};
  }
  return poses;
}

// Returns poses from an array (n, 7) of quaternions w, x, y, z and translations.
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

// Returns a dictionary of arrays for each sensor. `poses`: for each sensor an array as for posesOf(); the others as for
// objectPosesOf() and SimulatedShot.
py::list simulate(const Simulator& simulator, const std::vector<Array<double>>& poses, double time, std::uint32_t frame,
                  const std::vector<std::string>& names, const Array<double>& matrices, const Array<double>& velocities,
                  const Array<bool>& hidden, bool moving) {
  SimulatedShot shot{
      .time = time, .frame = frame, .objects = objectPosesOf(names, matrices, velocities, hidden), .moving = moving};
  for (const Array<double>& rows : poses) shot.worldFromVehicle.push_back(posesOf(rows));
  std::vector<SimulatedScan> scans;
  {
    const py::gil_scoped_release released;
    scans = simulator.scan(shot);
  }
  py::list scansOfSensors;
  for (SimulatedScan& simulated : scans) {
    const bool empty = simulated.scan.size() == 0;
    py::dict arrays = arraysOf(std::move(simulated.scan));
    if (empty) addEmptyColumns(scanColumnNames(simulator.plan().columns()), arrays);
    arrays["world_from_sensor"] = matricesOf(simulated.worldFromSensor);
    scansOfSensors.append(std::move(arrays));
  }
  return scansOfSensors;
}

}  // namespace

void defineSimulator(py::module_& module) {
  py::class_<Simulator>(module, "Simulator")
      .def(py::init([](const std::string& pipeline, const std::string& folder, const std::vector<py::dict>& given,
                       bool placeable) {
             std::vector<ArrayPart> parts;
             parts.reserve(given.size());
             for (const py::dict& part : given) parts.push_back(partOf(part));
             const py::gil_scoped_release released;
             return std::make_unique<Simulator>(pipeline, folder, std::move(parts), placeable);
           }),
           py::arg("pipeline"), py::arg("folder"), py::arg("parts") = std::vector<py::dict>(),
           py::arg("placeable") = false)
      .def_property_readonly("sensors",
                             [](const Simulator& s) {
                               py::list sensors;
                               for (std::size_t i = 0; i < s.plan().sensors.size(); ++i) {
                                 const BeamTable& beams = *s.plan().sensors[i].beams;
                                 sensors.append(py::make_tuple(s.plan().pipeline.sensors[i].name,
                                                               py::make_tuple(beams.rings, beams.columns),
                                                               staggerOf(beams), beams.columnPeriod() * beams.columns));
                               }
                               return sensors;
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
      .def("scan", &simulate, py::arg("poses"), py::arg("time"), py::arg("frame"), py::arg("names"),
           py::arg("matrices"), py::arg("velocities"), py::arg("hidden"), py::arg("moving"));
}

}  // namespace scanmill
