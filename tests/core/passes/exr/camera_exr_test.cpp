#include "base/random.h"
#include "passes/exr/exr_file.h"
#include "tests/core/passes/exr/foreign_file.h"

namespace scanmill {
namespace {

class ForeignCamera : public ForeignFile {};
class CameraExr : public OneFile {};

PassImage smallImage() {
  PassImage image{squareCamera(2, 2, radians(100)), {}};
  image.camera.cx += 0.25;
  image.planes.reset(4, {});
  image.planes.depth.assign(4, 1.0f);
  image.camera.worldFromCamera.rotation = fromYawPitchRoll(0.7, -0.2, 0.05) * vehicleFromOptical();
  return image;
}

TEST_F(CameraExr, AnyPoseComesBackToTheBitAndByItsMatrixAlone) {
  PassImage image = smallImage();
  for (std::uint32_t i = 0; i < 48; ++i) {
    const RandomBlock random = randomBlock({.seed = 4, .beam = i});
    // Half turns too, where a component of the quaternion is zero.
    const auto angle = [&](int k) { return i % 3 == 0 ? kPi / 2 * (random[k] % 8) : 2 * kPi * uniform(random[k]); };
    const Pose pose{fromYawPitchRoll(angle(0), angle(1), angle(2)), {1e7 * uniform(random[3]), -1e7, 0.1}};
    image.camera.worldFromCamera = pose;
    writePasses(path, image);
    EXPECT_EQ(readPasses(path, {}).camera.worldFromCamera, pose);

    const ExrReader file(path);
    EXPECT_EQ(std::get<std::string>(*file.attribute("units")), "m");
    EXPECT_EQ(std::get<double>(*file.attribute("horizontalFieldDeg")), degrees(image.camera.horizontalField()));
    const std::vector<float> depth(4, 1.0f);
    const ExrPlane planes[] = {{"Z", ExrType::Float32, depth.data()}};
    writeExr(
        path, 2, 2,
        {{"cameraMatrix", *file.attribute("cameraMatrix")}, {"worldFromCamera", *file.attribute("worldFromCamera")}},
        planes, ExrCompression::Zip);
    const Pose back = readPasses(path, {}).camera.worldFromCamera;
    EXPECT_EQ(back.translation, pose.translation);
    const Mat3 a = toMatrix(pose.rotation);
    const Mat3 b = toMatrix(back.rotation);
    for (const Vec3d& axis : {a.x - b.x, a.y - b.y, a.z - b.z}) EXPECT_LT(length(axis), 1e-14);
  }
}

TEST_F(CameraExr, AttributesAreCheckedByName) {
  const ExrAttributes good{{"cameraMatrix", ExrMatrix3{1, 0, 1, 0, 1, 1, 0, 0, 1}},
                           {"worldFromCamera", ExrMatrix4{0, 0, 1, 10, -1, 0, 0, 20, 0, -1, 0, 30, 0, 0, 0, 1}}};
  const std::vector<float> depth(4, 5.0f);
  const auto read = [&](const ExrAttributes& attributes) {
    const ExrPlane planes[] = {{"Z", ExrType::Float32, depth.data()}};
    writeExr(path, 2, 2, attributes, planes, ExrCompression::Zip);
    return readPasses(path, {}).camera;
  };
  const auto with = [&](const char* name, const ExrValue& value) {
    ExrAttributes changed = good;
    changed[name] = value;
    return changed;
  };
  EXPECT_EQ(read(good).name, "file");
  EXPECT_EQ(read(with("camera", "left")).name, "left");
  for (const char* name : {"cameraMatrix", "worldFromCamera"}) {
    ExrAttributes without = good;
    without.erase(name);
    expectInputError([&] { read(without); }, {path.string(), name, "absent"});
    expectInputError([&] { read(with(name, "unit")); }, {path.string(), name, "type m"});
  }
  EXPECT_NO_THROW(read(with("units", "m")));
  expectInputError([&] { read(with("units", "cm")); }, {path.string(), "'units'", "'cm'"});
  EXPECT_NO_THROW(read(with("horizontalFieldDeg", 90.0)));
  expectInputError([&] { read(with("horizontalFieldDeg", 60.0)); },
                   {path.string(), "'horizontalFieldDeg'", "60", "90"});
  for (const char* name : {"../x", "a\nb"}) {
    expectInputError([&] { read(with("camera", name)); }, {path.string(), "'camera'"});
  }
  // A quaternion that contradicts its matrix.
  ExrAttributes turned = with("worldFromCameraXyz", Vec3d{0, 0, 0});
  turned["worldFromCameraW"] = 1.0;
  expectInputError([&] { read(turned); }, {path.string(), "'worldFromCameraXyz'", "worldFromCamera"});
  turned["worldFromCameraW"] = std::nan("");
  expectInputError([&] { read(turned); }, {path.string(), "'worldFromCameraXyz'"});
}

TEST_F(ForeignCamera, TheCameraMatrixMakesSense) {
  add("Z", Imf::FLOAT, 5);
  const Imath::M33d bad[] = {{0, 0, 4, 0, 4, 3, 0, 0, 1},   {4, 0, 4, 0, -4, 3, 0, 0, 1},
                             {NAN, 0, 4, 0, 4, 3, 0, 0, 1}, {4, 0, 4, 0, INFINITY, 3, 0, 0, 1},
                             {4, 0, 0, 0, 4, 0, 4, 3, 1},   {4, 1, 4, 0, 4, 3, 0, 0, 1},
                             {4, 0, 4, 0, 4, 3, 0, 0, 0}};
  for (const Imath::M33d& matrix : bad) {
    header.insert("cameraMatrix", Imf::M33dAttribute(matrix));
    expectRefused({"'cameraMatrix'"});
  }
  Imf::Header single(kWidth, kHeight);
  single.channels() = header.channels();
  single.insert("worldFromCamera", header["worldFromCamera"]);
  single.insert("cameraMatrix", Imf::M33fAttribute({4, 0, 4, 0, 4, 3, 0, 0, 1}));
  write(single);
  EXPECT_EQ(readPasses(path, {}).camera.cy, 3);
}

TEST_F(ForeignCamera, ThePoseIsARotationAndATranslation) {
  add("Z", Imf::FLOAT, 5);
  const ExrMatrix4 bad[] = {{0, 0, 1, 10, -1, 0, 0, 20, 0, -1, 0, 30, 0, 0, 0, 0},    // no last row
                            {0, -1, 0, 0, 0, 0, -1, 0, 1, 0, 0, 0, 10, 20, 30, 1},    // transposed
                            {0, 0, 2, 10, -2, 0, 0, 20, 0, -2, 0, 30, 0, 0, 0, 1},    // scaled
                            {0, 0, 1, 10, 1, 0, 0, 20, 0, -1, 0, 30, 0, 0, 0, 1},     // mirrored
                            {0, 0, 1, 10, -1, 0.1, 0, 20, 0, -1, 0, 30, 0, 0, 0, 1},  // sheared
                            {0, 0, 0, 10, 0, 0, 0, 20, 0, 0, 0, 30, 0, 0, 0, 1},
                            {0, 0, 1, NAN, -1, 0, 0, 20, 0, -1, 0, 30, 0, 0, 0, 1}};
  for (const ExrMatrix4& matrix : bad) {
    setPose(matrix);
    expectRefused({"'worldFromCamera'"});
  }
}

}  // namespace
}  // namespace scanmill
