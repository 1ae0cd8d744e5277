// Datasets with voxels about their sensors.

#include "dataset/voxels.h"

#include "tests/core/pipeline/small_world.h"

namespace scanmill {
namespace {

const std::string kVoxels = "output.voxels={size: 0.5, from: [-45, -30, -2.5], to: [45, 30, 2.5]}";

class Voxels : public Yard {
 protected:
  std::map<std::string, ScanVoxels> voxels(const std::string& name = "out") const {
    std::map<std::string, ScanVoxels> found;
    for (const auto& [member, bytes] : members(name)) {
      if (member.ends_with(".voxels.npz")) found[member] = decodeVoxels(bytes, member);
    }
    return found;
  }
};

// The yard's walls and cars are where the scene has them, as seen from a vehicle that drives along x.
TEST_F(Voxels, HoldWhatStandsThere) {
  const Manifest m = sound({kVoxels});
  const auto found = voxels();
  ASSERT_EQ(found.size(), m.samples.size());
  const std::uint16_t wall = m.ontology.require("wall", {}).id;
  const std::uint16_t car = m.ontology.require("car", {}).id;
  const std::uint16_t ground = m.ontology.require("ground", {}).id;
  for (const SampleRecord& sample : m.samples) {
    const ScanVoxels& v = found.at(sample.key + ".top.ray_tracing.voxels.npz");
    const Vec3d eye = sample.scans[0].worldFromSensor[0].translation;
    const auto at = [&](double x, double y, double z) { return *v.grid.at(Vec3d{x, y, z} - eye); };
    EXPECT_EQ(v.label[at(30.01, 0, 1)], wall);
    EXPECT_EQ(v.label[at(0, 20.01, 1)], wall);
    EXPECT_EQ(v.label[at(8, 5, 1.49)], car);
    EXPECT_EQ(v.label[at(0, 0, 0.01)], ground);
    EXPECT_EQ(v.label[at(0, 0, 1)], 0) << "air";
    EXPECT_TRUE(v.invalid[at(8, 5, 0.75)]) << "within the car";
    EXPECT_FALSE(v.unseen[at(eye.x + 1, 0, 1.8)]) << "in front of the sensor";
  }
}

// At 20 m/s, whatever frame the points are reported in.
TEST_F(Voxels, PointsOfAMovingSensorLieWhereTheyWere) {
  const auto inputs = [&](const std::string& motion, const std::string& name) {
    sound({kVoxels, "motion=" + motion}, name);
    std::vector<std::vector<std::uint8_t>> found;
    for (const auto& [member, v] : voxels(name)) {
      for (std::size_t i = 0; i < v.input.size(); ++i) {
        if (v.input[i] != 0) {
          EXPECT_NE(v.label[i], 0) << motion;
          EXPECT_EQ(v.unseen[i], 0) << motion;
        }
      }
      found.push_back(v.input);
    }
    return found;
  };
  const auto skewed = inputs("per_column", "skewed");
  const auto deskewed = inputs("{steps: per_column, deskew: true}", "deskewed");
  for (std::size_t i = 0; i < skewed.size(); ++i) {
    std::size_t differ = 0;
    for (std::size_t k = 0; k < skewed[i].size(); ++k) differ += skewed[i][k] != deskewed[i][k] ? 1 : 0;
    EXPECT_LE(differ, 6U);  // single precision at the faces of voxels
  }
  EXPECT_THAT(refusal({kVoxels, "motion=per_column", "output.columns=[label]"}), HasSubstr("add `column`"));
}

TEST_F(Voxels, KeysAreChecked) {
  const auto refusal = [&](const std::string& keys) {
    return messageOf([&] { readPipeline(pipeline_, {"output.voxels=" + keys}); });
  };
  const VoxelGrid kitti = *readPipeline(pipeline_, {"output.voxels=true"}).output.voxels;
  EXPECT_EQ(kitti, VoxelGrid());
  EXPECT_EQ(kitti.voxels(), 256U * 256 * 32);
  EXPECT_FALSE(readPipeline(pipeline_, {"output.voxels=false"}).output.voxels.has_value());
  expectRefusals(refusal, {{"{size: 0.3}", "not a whole number of voxels"},
                           {"{from: [0, 20, 0], to: [10, -20, 4]}", "`to` must be greater than `from`"},
                           {"0.2", "voxels must be true, false or a grid such as"},
                           {"{size: 0}", "size"},
                           {"{to: [-1, 25.6, 4.4]}", "along x"},
                           {"{size: 0.02, from: [-50, -50, -50], to: [50, 50, 50]}", "64 million"},
                           {"{sise: 1}", "sise | size"},
                           {"maybe", "voxels"}});
}

}  // namespace
}  // namespace scanmill
