#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "base/error.h"
#include "passes/exr/exr_file.h"

namespace scanmill {

namespace {

constexpr const char* kMatrix = "cameraMatrix";
constexpr const char* kPose = "worldFromCamera";
constexpr const char* kQuaternionXyz = "worldFromCameraXyz";
constexpr const char* kQuaternionW = "worldFromCameraW";
constexpr const char* kHorizontalField = "horizontalFieldDeg";
constexpr const char* kVerticalField = "verticalFieldDeg";

// Returns the sum of the absolute differences between the entries of two matrices; NaN if an entry is NaN.
double difference(const Mat3& a, const Mat3& b) {
  double sum = 0;
  for (const Vec3d& d : {a.x - b.x, a.y - b.y, a.z - b.z}) sum += std::abs(d.x) + std::abs(d.y) + std::abs(d.z);
  return sum;
}

class CameraReader {
 public:
  explicit CameraReader(const ExrReader& file) : file_(file) {}

  Camera read() {
    Camera camera;
    camera.name = std::filesystem::path(file_.name()).stem().string();
    if (const auto* name = optional<std::string>("camera", "string")) camera.name = *name;
    // The name becomes part of file names.
    if (std::ranges::any_of(camera.name, [](unsigned char c) { return c < ' ' || c == '/'; })) {
      refuse("camera", "must be a name without '/' and control characters");
    }
    camera.width = file_.width();
    camera.height = file_.height();
    const auto* units = optional<std::string>("units", "string");
    if (units != nullptr && *units != "m") refuse("units", fmt::format("must be 'm', not '{}'", *units));
    readMatrix(camera);
    camera.worldFromCamera = readPose();
    checkField(kHorizontalField, degrees(camera.horizontalField()));
    checkField(kVerticalField, degrees(camera.verticalField()));
    return camera;
  }

 private:
  [[noreturn]] void refuse(const char* attribute, const std::string& why) const {
    throw InputError({file_.name()}, "attribute '{}': {}", attribute, why);
  }

  // Returns the value of an attribute; null if the file lacks it. Throws InputError if the value is not of type T.
  template <class T>
  const T* optional(const char* attribute, const char* type) const {
    const ExrValue* value = file_.attribute(attribute);
    if (value == nullptr) return nullptr;
    if (const T* typed = std::get_if<T>(value)) return typed;
    refuse(attribute, fmt::format("must be of type {}", type));
  }

  // Returns an attribute's numbers. Throws InputError if the file lacks it (with `meaning`), or if one is not finite.
  template <class T>
  const T& require(const char* attribute, const char* type, const char* meaning) const {
    const T* value = optional<T>(attribute, type);
    if (value == nullptr) refuse(attribute, fmt::format("is absent: add it as {}, {}", type, meaning));
    for (const double number : *value) {
      if (!std::isfinite(number)) refuse(attribute, "holds a number that is not finite");
    }
    return *value;
  }

  // Sets the focal lengths and the principal point.
  void readMatrix(Camera& camera) const {
    constexpr const char* kMeaning = "the rows fx 0 cx, 0 fy cy, 0 0 1 (px)";
    const ExrMatrix3& matrix = require<ExrMatrix3>(kMatrix, "m33d", kMeaning);
    camera.fx = matrix[0];
    camera.cx = matrix[2];
    camera.fy = matrix[4];
    camera.cy = matrix[5];
    if (matrix != ExrMatrix3{camera.fx, 0, camera.cx, 0, camera.fy, camera.cy, 0, 0, 1}) {
      refuse(kMatrix, fmt::format("must be {}", kMeaning));
    }
    if (camera.fx > 0 && camera.fy > 0) return;
    refuse(kMatrix, fmt::format("fx {:g} and fy {:g} must be above 0", camera.fx, camera.fy));
  }

  // Returns worldFromCamera. Reads the rotation from the quaternion if the file has it, because the matrix may be
  // rounded.
  Pose readPose() const {
    constexpr double kRoundedRotation = 1e-5;  // largest difference() between an exact rotation and its float32
    constexpr const char* kMeaning =
        "the rows of the 4 x 4 matrix that takes points as column vectors from the camera (x right, y down, z forward) "
        "to the world (m), the last one 0 0 0 1";
    const auto& m = require<ExrMatrix4>(kPose, "m44d", kMeaning);
    if (m[12] != 0 || m[13] != 0 || m[14] != 0 || m[15] != 1) refuse(kPose, fmt::format("must be {}", kMeaning));
    const Mat3 matrix{{m[0], m[4], m[8]}, {m[1], m[5], m[9]}, {m[2], m[6], m[10]}};
    const Vec3d translation{m[3], m[7], m[11]};
    if (determinant(matrix) < 0) {
      refuse(kPose, "mirrors: the camera's axes are right-handed, x right, y down, z forward");
    }
    if (!(difference(matrix * transposed(matrix), {}) < kRoundedRotation)) {
      refuse(kPose, "its left upper 3 x 3 is no rotation: camera poses have no scale and no shear");
    }
    const auto* xyz = optional<Vec3d>(kQuaternionXyz, "v3d");
    const auto* w = optional<double>(kQuaternionW, "double");
    if (xyz == nullptr || w == nullptr) return {fromMatrix(matrix), translation};
    const Quat rotation{*w, xyz->x, xyz->y, xyz->z};
    if (!(difference(toMatrix(rotation), matrix) < kRoundedRotation)) {
      refuse(kQuaternionXyz,
             fmt::format("is not the rotation of '{}': remove it and '{}', or set them too", kPose, kQuaternionW));
    }
    return {rotation, translation};
  }

  // Throws InputError if the file's attribute for the field of view differs from `field` (deg), which follows from the
  // camera matrix. The two differ if a program has scaled the image but not the matrix.
  void checkField(const char* attribute, double field) const {
    constexpr double kTolerance = 1e-3;  // deg, for fields of view that were rounded to three decimals
    const auto* claimed = optional<double>(attribute, "double");
    if (claimed == nullptr || std::abs(*claimed - field) < kTolerance) return;
    refuse(attribute,
           fmt::format("is {:.4f}, but by '{}' the image of {} x {} pixels spans {:.4f} degrees: keep the size "
                       "that was rendered, or set both",
                       *claimed, kMatrix, file_.width(), file_.height(), field));
  }

  const ExrReader& file_;
};

}  // namespace

ExrAttributes cameraAttributes(const Camera& camera) {
  const Quat& q = camera.worldFromCamera.rotation;
  return {{"camera", camera.name},
          {"units", "m"},
          {kMatrix, ExrMatrix3{camera.fx, 0, camera.cx, 0, camera.fy, camera.cy, 0, 0, 1}},
          {kPose, matrixRows(toAffine(camera.worldFromCamera))},
          {kQuaternionXyz, Vec3d{q.x, q.y, q.z}},
          {kQuaternionW, q.w},
          {kHorizontalField, degrees(camera.horizontalField())},
          {kVerticalField, degrees(camera.verticalField())}};
}

Camera readCamera(const ExrReader& file) {
  return CameraReader(file).read();
}

}  // namespace scanmill
