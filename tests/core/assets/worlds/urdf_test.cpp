#include <algorithm>

#include "world_files.h"

namespace scanmill {
namespace {

using testing::AllOf;
using testing::HasSubstr;

class Urdf : public WorldFiles {
 protected:
  Asset urdf(const std::string& inside) const {
    return read("r.urdf", "<robot name=\"r\">\n" + inside + "\n</robot>\n");
  }
  std::string refused(const std::string& inside) const {
    return messageOf([&] { urdf(inside); });
  }
};

TEST_F(Urdf, LinksHangOnTheirJoints) {
  folder_.write("pkg/meshes/wing.obj", kWing);
  const Asset asset = urdf(R"(
    <link name="tip"><visual><origin xyz="0 1 0" rpy="0.1 0 0"/><geometry><mesh filename="package://pkg/meshes/wing.obj"/></geometry></visual></link>
    <joint name="b" type="revolute"><origin xyz="0 0 2" rpy="0 0 1"/><parent link="arm"/><child link="tip"/></joint>
    <link name="base"/>
    <joint name="a" type="fixed"><origin xyz="1 0 0" rpy="0.2 0.3 0.4"/><parent link="base"/><child link="arm"/></joint>
    <link name="arm"/>)");
  expectWing(corners(asset, "r/tip/visual_1/wing"),
             poseOf(1, 0, 0, 0.2, 0.3, 0.4) * poseOf(0, 0, 2, 0, 0, 1) * poseOf(0, 1, 0, 0.1, 0, 0));
}

TEST_F(Urdf, SolidsAndMeshesHaveTheirSizesAndColours) {
  folder_.write("wing.obj", kWing);
  const Asset asset = urdf(R"(
    <material name="red"><color rgba="0.8 0.1 0.2 1"/></material>
    <link name="base">
      <visual name="body"><geometry><box size="4 2 1"/></geometry><material name="red"/></visual>
      <visual><geometry><cylinder radius="0.5" length="6"/></geometry></visual>
      <visual><geometry><sphere radius="2"/></geometry></visual>
      <visual><geometry><mesh filename="wing.obj" scale="0.001 0.001 0.001"/></geometry></visual>
      <collision><geometry><box size="100 100 100"/></geometry></collision>
    </link>)");
  ASSERT_EQ(asset.parts.size(), 4u);
  EXPECT_EQ(asset.parts[0].node, "r/base/body");
  EXPECT_EQ(asset.parts[0].material, "red");
  EXPECT_FLOAT_EQ(asset.parts[0].color[0], 0.8f);
  EXPECT_NEAR(corners(asset, "r/base/visual_4/wing")[2].z, 0.003, 1e-9);
  const Box box = boundsOf(asset);
  EXPECT_NEAR(box.high.z, 3, 1e-6);
  EXPECT_NEAR(box.high.x, 2, 1e-3);
  for (const AssetPart& part : asset.parts) EXPECT_EQ(part.nodeIndex, 0u) << "a robot is one thing";
}

// quat_xyzw is of URDF 1.2.
TEST_F(Urdf, RotationsMayBeQuaternions) {
  folder_.write("wing.obj", kWing);
  const Asset asset = urdf(R"(
    <link name="base"/><link name="tip"><visual><origin xyz="0 1 0" quat_xyzw="2 0 0 2"/>
      <geometry><mesh filename="wing.obj"/></geometry></visual></link>
    <joint name="a" type="fixed"><origin xyz="1 0 0" quat_xyzw="0 0 1 0"/><parent link="base"/><child link="tip"/></joint>)");
  expectWing(corners(asset, "r/tip/visual_1/wing"), poseOf(1, 0, 0, 0, 0, kPi) * poseOf(0, 1, 0, kPi / 2, 0, 0));
}

// The first definition of a name holds, as in urdfdom; alpha 0 is invisible, as in RViz.
TEST_F(Urdf, MaterialsAreThoseOfTheFirstDefinition) {
  const auto box = [](const std::string& material) {
    return "<visual><geometry><box size=\"1 1 1\"/></geometry>" + material + "</visual>";
  };
  testing::internal::CaptureStderr();
  const Asset asset =
      urdf("<link name=\"a\">" + box("<material name=\"red\"><color rgba=\"0 0 1 1\"/></material>") +
           box("<material name=\"own\"><color rgba=\"0 1 0 0.5\"/></material>") + box("<material name=\"own\"/>") +
           box("<material name=\"gone\"/>") + box("<material name=\"\"><color rgba=\"1 1 1 0\"/></material>") +
           "</link><material name=\"red\"><color rgba=\"1 0 0 1\"/></material>");
  EXPECT_THAT(testing::internal::GetCapturedStderr(),
              AllOf(HasSubstr("2 transparencies between 0 and 1 (these visuals are solid)"),
                    HasSubstr("1 materials that are defined nowhere")));
  ASSERT_EQ(asset.parts.size(), 4u);
  EXPECT_EQ(asset.parts[0].color, (std::array<float, 3>{1, 0, 0}));
  EXPECT_EQ(asset.parts[2].color, (std::array<float, 3>{0, 1, 0}));
}

TEST_F(Urdf, ItsMaterialsReplaceThoseOfMeshes) {
  folder_.write("wing.obj", std::string("mtllib wing.mtl\nusemtl own\n") + kWing);
  folder_.write("wing.mtl", "newmtl own\nKd 0 0 0\n");
  folder_.write("bare.obj", kWing);
  const auto visual = [](const std::string& mesh, const std::string& material) {
    return "<visual><geometry><mesh filename=\"" + mesh + "\"/></geometry>" + material + "</visual>";
  };
  const std::string white = "<material name=\"white\"><color rgba=\"1 1 1 1\"/></material>";
  const Asset asset = urdf("<link name=\"a\">" + visual("wing.obj", white) + visual("bare.obj", white) +
                           visual("wing.obj", "") + "</link>");
  ASSERT_EQ(asset.parts.size(), 3u);
  for (const std::size_t i : {0u, 1u, 2u}) {
    const Material& m = asset.parts[i].fileMaterial;
    EXPECT_NEAR(m.reflectance, i == 2 ? 0 : 1, 1e-6) << i;
    EXPECT_EQ(m.source, i == 2 ? "base colour of wing.obj" : "base colour of r.urdf") << i;
  }
}

TEST_F(Urdf, ContentsThatAreLeftOutAreToldOnceWithTheirNumber) {
  testing::internal::CaptureStderr();
  urdf(R"(<link name="a"><visual><geometry><box size="1 1 1"/></geometry></visual><collision/><inertial/></link>
    <link name="b"/><joint name="j" type="revolute"><parent link="a"/><child link="b"/><axis xyz="1 0 0"/>
      <limit lower="0.5" upper="1"/><mimic joint="k" offset="0.1"/></joint><transmission name="t"/>
    <link name="c"/><joint name="k" type="continuous"><parent link="a"/><child link="c"/><limit upper="-1"/></joint>
    <gazebo reference="a"><material>Gazebo/Red</material><kp>1</kp></gazebo><gazebo><plugin name="p"/></gazebo>
    <sound/>)");
  const std::string told = testing::internal::GetCapturedStderr();
  EXPECT_THAT(
      told, AllOf(HasSubstr("r.urdf: left out: "), HasSubstr("1 limits that exclude 0"), HasSubstr("1 unknown 'sound'"),
                  HasSubstr("1 offsets of joints that mimic others"), HasSubstr("1 materials, visuals and poses for")));
  EXPECT_EQ(std::count(told.begin(), told.end(), '\n'), 1);
}

// An element in a wrong place means nothing. Of elements that may stand once, the first counts.
TEST_F(Urdf, ElementsInWrongPlacesAreTold) {
  const auto told = [&](const std::string& inside) {
    folder_.write("misplaced.urdf", "<robot>" + inside + "</robot>");
    testing::internal::CaptureStderr();
    EXPECT_NEAR(boundsOf(readAsset(folder_.path() / "misplaced.urdf", {})).high.x, 0.5, 1e-9);
    return testing::internal::GetCapturedStderr();
  };
  const std::string big = "<geometry><box size=\"9 9 9\"/></geometry>";
  const auto link = [](const std::string& more, const std::string& inVisual = "", const std::string& shape = "") {
    return "<link name=\"a\">" + more + "<visual><geometry><box size=\"1 1 1\"/>" + shape + "</geometry>" + inVisual +
           "</visual></link>";
  };
  EXPECT_THAT(told("<material name=\"m\"><color rgba=\"1 1 1 1\"/></material>" +
                   link("<collision>" + big + "</collision>", "<origin/><material name=\"m\"/>")),
              testing::IsEmpty());
  EXPECT_THAT(told(link("") + "<visual>" + big + "</visual>"), HasSubstr("1 misplaced <visual> in <robot>"));
  EXPECT_THAT(told(link(big)), HasSubstr("1 misplaced <geometry> in <link>"));
  EXPECT_THAT(told(link("<origin xyz=\"5 0 0\"/>")), HasSubstr("1 misplaced <origin> in <link>"));
  EXPECT_THAT(told(link("<material name=\"r\"/>")), HasSubstr("1 misplaced <material> in <link>"));
  EXPECT_THAT(told(link("", "<color rgba=\"1 0 0 1\"/>")), HasSubstr("1 misplaced <color> in <visual>"));
  EXPECT_THAT(told(link("", big + big)), HasSubstr("2 second <geometry> in <visual>"));
  EXPECT_THAT(told(link("", "", "<sphere radius=\"4\"/>")), HasSubstr("1 second <sphere> in <geometry>"));
  EXPECT_THAT(told(link("", "<origin/><origin xyz=\"3 0 0\"/>")), HasSubstr("1 second <origin> in <visual>"));
  EXPECT_THAT(told(link("<visual>" + big + "<material name=\"n\"><color rgba=\"1 1 1 0\"/></material></visual>")),
              HasSubstr("1 invisible visuals (alpha 0)"));
  EXPECT_THAT(told(link("", "<material name=\"o\"><color rgba=\"255 128 0 1\"/></material>")),
              HasSubstr("1 numbers of colours above 1 (they count as 1)"));
}

TEST_F(Urdf, MistakesAreNamedWithTheirLine) {
  EXPECT_THAT(messageOf([&] { read("w.urdf", "<robot>\n<xi:include href=\"a\"/></robot>"); }),
              AllOf(HasSubstr("w.urdf:2"), HasSubstr("xmllint")));
  EXPECT_THAT(messageOf([&] { read("w.urdf", "<robot>\n<% x = 1 %></robot>"); }), HasSubstr("erb FILE.erb"));
  EXPECT_THAT(messageOf([&] { read("r.urdf", "<sdf/>"); }), HasSubstr("not a URDF"));
  EXPECT_THAT(refused("<xacro:property name=\"a\" value=\"1\"/>"),
              AllOf(HasSubstr("r.urdf:2"), HasSubstr("xacro robot")));
  EXPECT_THAT(refused("<link name=\"a\">\n<xacro:wheel/></link>"), AllOf(HasSubstr("r.urdf:3"), HasSubstr("a macro")));
  EXPECT_THAT(refused("<link name=\"${prefix}a\"/>"), HasSubstr("has a macro: expand the file first"));
  EXPECT_THAT(refused("<link name=\"a\"/>\n<link name=\"a\"/>"),
              AllOf(HasSubstr("r.urdf:3"), HasSubstr("'a', as another")));
  EXPECT_THAT(refused("<joint name=\"j\"><parent link=\"a\"/><child link=\"bb\"/></joint><link name=\"a\"/>"),
              AllOf(HasSubstr("r.urdf:2"), HasSubstr("'bb', but this link does not exist")));
  EXPECT_THAT(refused("<link name=\"a\"/>\n<link name=\"b\"/>"),
              AllOf(HasSubstr("r.urdf:3"), HasSubstr("'b' and 'a' are both the child of no joint")));
  EXPECT_THAT(refused("<joint name=\"j\"><child link=\"a\"/></joint>"), HasSubstr("<parent link="));
  EXPECT_THAT(
      refused("<joint name=\"j\"><parent link=\"b\"/><child link=\"a\"/></joint><joint name=\"k\"><parent link=\"a\"/>"
              "<child link=\"b\"/></joint><link name=\"a\"/><link name=\"b\"/>"),
      HasSubstr("its own ancestor"));
  EXPECT_THAT(
      refused("<joint name=\"j\"><parent link=\"b\"/><child link=\"a\"/></joint><joint name=\"k\"><parent link=\"c\"/>"
              "<child link=\"a\"/></joint>"
              "<link name=\"a\"/>"),
      HasSubstr("second parent"));
  EXPECT_THAT(refused("<link name=\"a\"><visual><geometry><torus/></geometry></visual></link>"),
              HasSubstr("not a shape of URDF"));
  EXPECT_THAT(refused("<link name=\"a\"><visual><geometry><box/></geometry></visual></link>"),
              HasSubstr("has no size"));
  EXPECT_THAT(
      refused(
          "<link name=\"a\"><visual><geometry><mesh filename=\"package://gone/a.stl\"/></geometry></visual></link>"),
      AllOf(HasSubstr("r.urdf:2"), HasSubstr("package://gone/a.stl"), HasSubstr("ROS_PACKAGE_PATH")));
  folder_.write("pkg/meshes/wing.obj", kWing);
  const auto mesh = [](const std::string& name) {
    return "<visual><geometry><mesh filename=\"package://pkg/meshes/" + name + "\"/></geometry></visual>";
  };
  EXPECT_THAT(refused("<link name=\"a\">" + mesh("a.stl") + mesh("wing.obj") + mesh("b.stl") + "</link>"),
              AllOf(HasSubstr("/pkg' has no file 'meshes/a.stl'"), HasSubstr("'package://pkg/meshes/b.stl'"),
                    testing::Not(HasSubstr("wing.obj")), testing::Not(HasSubstr("must have the name"))));
  EXPECT_THAT(refused("<link name=\"a\"/>"), AllOf(HasSubstr("has no triangle"), HasSubstr("<collision>")));
  const auto origin = [&](const std::string& more) {
    return refused("<link name=\"a\"><visual><origin " + more +
                   "/><geometry><box size=\"1 1 1\"/></geometry></visual></link>");
  };
  EXPECT_THAT(origin("rpy=\"0 0 0\" quat_xyzw=\"0 0 0 1\""), HasSubstr("both rpy and quat_xyzw"));
  EXPECT_THAT(origin("quat_xyzw=\"0 0 0 0\""), HasSubstr("quaternion of zeros"));
}

}  // namespace
}  // namespace scanmill
