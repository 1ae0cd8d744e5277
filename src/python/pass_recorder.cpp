#include <fmt/core.h>
#include <pybind11/stl.h>

#include <array>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "config/version.h"
#include "dataset/recording.h"
#include "passes/exr/pass_exr.h"
#include "python/arrays.h"
#include "sensors/beams.h"
#include "sensors/sensor.h"

namespace py = pybind11;

namespace scanmill {

namespace {

constexpr const char* kTrajectory = "cameras";

// Returns the pose from a quaternion w, x, y, z and a translation x, y, z, in this order.
Pose poseOf(const std::array<double, 7>& p) {
  return {{p[0], p[1], p[2], p[3]}, {p[4], p[5], p[6]}};
}

// Writes one sensor's frames, each with the images of its depth cameras, in the order of the calls.
class PassRecorder {
 public:
  // `sensor`: the YAML text of a sensor, whose relative paths start at `here`.
  PassRecorder(const std::string& folder, std::string name, const std::string& sensor, const std::string& here,
               std::string scene)
      : writer_(folder, false), name_(std::move(name)), scene_(std::move(scene)) {
    const Value description = parseYaml(sensor, (std::filesystem::path(here) / "sensor.yaml").string());
    beams_ = makeBeams(resolveSensor(description));
  }

  // Adds an image of the frame that begin() started. All arrays have the camera's width^2 pixels, row by row from the
  // top; a depth of infinity means that the pixel shows no surface.
  void image(const std::string& camera, const std::array<double, 7>& worldFromCamera, std::uint32_t width,
             const Array<float>& depth, const Array<float>& normal, const Array<std::uint16_t>& semantic,
             const Array<std::uint32_t>& instance, const Array<float>& reflectance) {
    PassImage image;
    image.camera = squareCamera(width, width, kPi / 2);
    image.camera.name = camera;
    image.camera.worldFromCamera = poseOf(worldFromCamera);
    PassPlanes& planes = image.planes;
    planes.depth = copied<float>(depth);
    planes.normal = copied<Vec3f>(normal);
    planes.semantic = copied<std::uint16_t>(semantic);
    planes.instance = copied<std::uint32_t>(instance);
    planes.reflectance = copied<float>(reflectance);
    planes.roughness.assign(planes.depth.size(), 1.0f);
    planes.metallic.assign(planes.depth.size(), 0.0f);
    planes.retroreflectance.assign(planes.depth.size(), 0.0f);
    const py::gil_scoped_release released;
    const std::filesystem::path file = writer_.file(key(), name_, fmt::format("0.{}.exr", camera));
    writePasses(file, image);
    images_.push_back(file.filename().string());
  }

  // Writes the frame with its images. `worldFromSensor`: the sensor's pose. `time`: s since the start of the drive.
  void frame(const std::array<double, 7>& worldFromSensor, double time) {
    const Pose pose = poseOf(worldFromSensor);
    RecordedShot shot{key(), name_, time, {pose}, "", {}};
    shot.steps.push_back({0, beams_->columns, pose, std::exchange(images_, {})});
    writer_.add(shot);
    ++frames_;
  }

  void finish() {
    writer_.finish({.kind = RecordingKind::Passes,
                    .programVersion = kVersion,
                    .method = "depth_camera",
                    .folder = writer_.folder(),
                    .sensors = {{name_, beams_->rings, beams_->columns, "", Pose{}}},
                    .sequences = {{scene_, 1, kTrajectory, frames_, 0}},
                    .materials = {{}},
                    .modelled = {{"passes", "images of six depth cameras, as another program rendered them"}}});
  }

 private:
  std::string key() const { return fmt::format("{}-s1-{}-{:06}", scene_, kTrajectory, frames_); }

  RecordingWriter writer_;
  std::string name_, scene_;
  std::shared_ptr<const BeamTable> beams_;
  std::uint32_t frames_ = 0;
  std::vector<std::string> images_;  // images of the frame that has not ended
};

}  // namespace

void definePassRecorder(py::module_& module) {
  py::class_<PassRecorder>(module, "PassRecorder")
      .def(py::init<const std::string&, std::string, const std::string&, const std::string&, std::string>(),
           py::arg("folder"), py::arg("name"), py::arg("sensor"), py::arg("here"), py::arg("scene"))
      .def("image", &PassRecorder::image)
      .def("frame", &PassRecorder::frame)
      .def("finish", &PassRecorder::finish);
}

}  // namespace scanmill
