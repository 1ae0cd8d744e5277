#pragma once

// Worlds in a folder of their own, and what their parts are.

#include <string>
#include <vector>

#include "assets/asset.h"
#include "assets/meshes/asset_parts.h"
#include "tests/support/message_of.h"
#include "tests/support/temporary_folder.h"

namespace scanmill {

// A triangle whose corners tell the axes apart: (1, 0, 0), (0, 2, 0), (0, 0, 3).
constexpr const char* kWing = "o wing\nv 1 0 0\nv 0 2 0\nv 0 0 3\nf 1 2 3\n";

inline Pose poseOf(double x, double y, double z, double roll, double pitch, double yaw) {
  return {fromYawPitchRoll(yaw, pitch, roll), {x, y, z}};
}

class WorldFiles : public testing::Test {
 protected:
  Asset read(const std::string& name, const std::string& text) const {
    return readAsset(folder_.write(name, text), {});
  }
  // An SDF 1.9 of that.
  Asset sdf(const std::string& inside) const {
    return read("a.sdf", "<?xml version=\"1.0\"?>\n<sdf version=\"1.9\">\n" + inside + "\n</sdf>\n");
  }
  std::string refusal(const std::string& inside) const {
    return messageOf([&] { sdf(inside); });
  }
  static std::string world(const std::string& inside) { return "<world name=\"w\">" + inside + "</world>"; }
  // A model of one link with one visual of this geometry; `look`: what follows the geometry.
  static std::string model(const std::string& geometry, const std::string& look = "") {
    return "<model name=\"m\"><link name=\"l\"><visual name=\"v\"><geometry>" + geometry + "</geometry>" + look +
           "</visual></link></model>";
  }

  // A model of one link with one visual, which is a wing.
  std::string wing(const std::string& name, const std::string& more = "", const std::string& visual = "") const {
    folder_.write("wing.obj", kWing);
    return "<model name=\"" + name + "\">" + more + "<link name=\"l\"><visual name=\"v\">" + visual +
           "<geometry><mesh><uri>wing.obj</uri></mesh></geometry></visual></link></model>";
  }
  // The corners of the first part that has such a node.
  static std::vector<Vec3d> corners(const Asset& asset, const std::string& node) {
    for (const AssetPart& part : asset.parts) {
      if (part.node != node) continue;
      std::vector<Vec3d> found;
      for (const Vec3f& p : part.positions) found.emplace_back(Vec3d(p));
      return found;
    }
    ADD_FAILURE() << "there is no node " << node;
    return {{}, {}, {}};
  }
  static void expectWing(const std::vector<Vec3d>& corners, const Pose& pose) {
    const Vec3d wing[] = {{1, 0, 0}, {0, 2, 0}, {0, 0, 3}};
    for (int i = 0; i < 3; ++i) EXPECT_LT(length(corners.at(i) - pose * wing[i]), 1e-5) << i;
  }
  static void expectWing(const Asset& asset, const std::string& node, const Pose& pose) {
    expectWing(corners(asset, node), pose);
  }

  TemporaryFolder folder_;
};

}  // namespace scanmill
