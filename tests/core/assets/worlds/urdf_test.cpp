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
  expectWing(asset, "r/tip/visual_1/wing",
             poseOf(1, 0, 0, 0.2, 0.3, 0.4) * poseOf(0, 0, 2, 0, 0, 1) * poseOf(0, 1, 0, 0.1, 0, 0));
}

// An arm of two joints: the first turns by 90 degrees about z, the second slides along its own y, and a third mimics
// it.
TEST_F(Urdf, JointsAreAtTheirPositions) {
  const auto joint = [](const char* name, const char* type, const char* parent, const char* child, const char* more) {
    return fmt::format(
        "<link name=\"{3}\"/><joint name=\"{0}\" type=\"{1}\"><origin xyz=\"1 0 0\"/><parent "
        "link=\"{2}\"/><child link=\"{3}\"/>{4}</joint>",
        name, type, parent, child, more);
  };
  const std::filesystem::path file = folder_.write(
      "arm.urdf",
      "<robot><link name=\"base\"/>" +
          joint("turn", "revolute", "base", "upper", "<axis xyz=\"0 0 2\"/><limit lower=\"-2\" upper=\"2\"/>") +
          joint("slide", "prismatic", "upper", "lower", "<axis xyz=\"0 1 0\"/><limit lower=\"0\" upper=\"3\"/>") +
          joint("follow", "continuous", "lower", "hand",
                "<axis xyz=\"0 0 1\"/><mimic joint=\"turn\" multiplier=\"-1\"/>") +
          joint("stiff", "fixed", "base", "box", "") + "</robot>");
  const std::map<std::string, double> positions{{"turn", kPi / 2}, {"slide", 3}};
  const Affine hand = robotFromLink(file, positions, "hand");
  EXPECT_NEAR(length(hand.translation - Vec3d{1 - 3, 1 + 1, 0}), 0, 1e-12);
  EXPECT_NEAR(length(hand.linear.x - Vec3d{1, 0, 0}), 0, 1e-12) << "the third joint turns back";
  EXPECT_NEAR(length(robotFromLink(file, {}, "hand").translation - Vec3d{3, 0, 0}), 0, 1e-12);
  const auto refusal = [&](const std::map<std::string, double>& given, const char* link) {
    return messageOf<InputError>([&] { robotFromLink(file, given, link); });
  };
  EXPECT_THAT(refusal({{"trun", 1}}, "hand"), HasSubstr("no joint 'trun' (did you mean 'turn'"));
  EXPECT_THAT(refusal({{"slide", -1}}, "hand"), HasSubstr("'slide' is from 0 to 3, not at -1"));
  EXPECT_THAT(refusal({{"stiff", 1}}, "hand"), HasSubstr("'stiff' is fixed"));
  EXPECT_EQ(readLinkNames(file).front(), "base");
  EXPECT_THAT(refusal({}, "hnad"), HasSubstr("no link 'hnad' (did you mean 'hand'"));
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
  expectWing(asset, "r/tip/visual_1/wing", poseOf(1, 0, 0, 0, 0, kPi) * poseOf(0, 1, 0, kPi / 2, 0, 0));
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
      <limit lower="0.5" upper="1"/><mimic joint="k"/></joint><transmission name="t"/>
    <link name="c"/><joint name="k" type="continuous"><parent link="a"/><child link="c"/><limit upper="-1"/></joint>
    <link name="d"/><joint name="m" type="revolute"><parent link="a"/><child link="d"/><limit lower="-1" upper="1"/>
      <mimic joint="k" offset="0.1"/></joint>
    <gazebo reference="a"><material>Gazebo/Red</material><kp>1</kp></gazebo><gazebo><plugin name="p"/></gazebo>
    <sound/>)");
  const std::string told = testing::internal::GetCapturedStderr();
  EXPECT_THAT(told,
              AllOf(HasSubstr("r.urdf: left out: "), HasSubstr("1 unknown 'sound'"),
                    HasSubstr("1 joints whose limits exclude 0"), HasSubstr("1 materials, visuals and poses for")));
  EXPECT_EQ(std::count(told.begin(), told.end(), '\n'), 1);
}

// An element in a wrong place means nothing. Of elements that may stand once, the first counts.
TEST_F(Urdf, ElementsInWrongPlacesAreTold) {
  const auto told = [&](const std::string& inside) {
    folder_.write("misplaced.urdf", "<robot>" + inside + "</robot>");
    return printedBy(
        [&] { EXPECT_NEAR(boundsOf(readAsset(folder_.path() / "misplaced.urdf", {})).high.x, 0.5, 1e-9); });
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
  EXPECT_THAT(told(link(big + "<origin xyz=\"5 0 0\"/><material name=\"r\"/>", "<color rgba=\"1 0 0 1\"/>")),
              AllOf(HasSubstr("1 misplaced <geometry> in <link>"), HasSubstr("1 misplaced <origin> in <link>"),
                    HasSubstr("1 misplaced <material> in <link>"), HasSubstr("1 misplaced <color> in <visual>")));
  EXPECT_THAT(told(link("", big + big)), HasSubstr("2 second <geometry> in <visual>"));
  EXPECT_THAT(told(link("", "", "<sphere radius=\"4\"/>")), HasSubstr("1 second <sphere> in <geometry>"));
  EXPECT_THAT(told(link("", "<origin/><origin xyz=\"3 0 0\"/>")), HasSubstr("1 second <origin> in <visual>"));
  EXPECT_THAT(told(link("<visual>" + big + "<material name=\"n\"><color rgba=\"1 1 1 0\"/></material></visual>")),
              HasSubstr("1 invisible visuals (alpha 0)"));
  EXPECT_THAT(told(link("", "<material name=\"o\"><color rgba=\"255 128 0 1\"/></material>")),
              HasSubstr("1 numbers of colours above 1 (they count as 1)"));
}

TEST_F(Urdf, MistakesAreNamedWithTheirLine) {
  expectRefusals([&](const std::string& text) { return messageOf([&] { read("w.urdf", text); }); },
                 {{"<robot>\n<xi:include href=\"a\"/></robot>", "w.urdf:2 | xmllint"},
                  {"<robot>\n<% x = 1 %></robot>", "erb FILE.erb"},
                  {"<sdf/>", "not a URDF"}});
  folder_.write("pkg/meshes/wing.obj", kWing);
  const auto mesh = [](const std::string& name) {
    return "<visual><geometry><mesh filename=\"package://" + name + "\"/></geometry></visual>";
  };
  const auto link = [](const std::string& inside) { return "<link name=\"a\">" + inside + "</link>"; };
  const auto origin = [&](const std::string& more) {
    return link("<visual><origin " + more + "/><geometry><box size=\"1 1 1\"/></geometry></visual>");
  };
  const auto joint = [](const std::string& parent, const std::string& child) {
    return "<joint name=\"" + child + parent + "\"><parent link=\"" + parent + "\"/><child link=\"" + child +
           "\"/></joint>";
  };
  expectRefusals([&](const std::string& inside) { return refused(inside); },
                 {{"<xacro:property name=\"a\" value=\"1\"/>", "r.urdf:2 | xacro robot"},
                  {"<link name=\"a\">\n<xacro:wheel/></link>", "r.urdf:3 | a macro"},
                  {"<link name=\"${prefix}a\"/>", "has a macro: expand the file first"},
                  {"<link name=\"a\"/>\n<link name=\"a\"/>", "r.urdf:3 | 'a', as another"},
                  {joint("a", "bb") + link(""), "r.urdf:2 | 'bb', but this link does not exist"},
                  {"<link name=\"a\"/>\n<link name=\"b\"/>", "r.urdf:3 | 'b' and 'a' are both the child of no joint"},
                  {"<joint name=\"j\"><child link=\"a\"/></joint>", "<parent link="},
                  {joint("b", "a") + joint("a", "b") + link("") + "<link name=\"b\"/>", "its own ancestor"},
                  {joint("b", "a") + joint("c", "a") + link(""), "second parent"},
                  {link("<visual><geometry><torus/></geometry></visual>"), "not a shape of URDF"},
                  {link("<visual><geometry><box/></geometry></visual>"), "has no size"},
                  {link(mesh("gone/a.stl")), "r.urdf:2 | package://gone/a.stl | ROS_PACKAGE_PATH"},
                  {link(mesh("pkg/meshes/a.stl") + mesh("pkg/meshes/wing.obj") + mesh("pkg/meshes/b.stl")),
                   "/pkg' has no file 'meshes/a.stl' | missing: 'package://pkg/meshes/b.stl'"},
                  {link(""), "has no triangle | <collision>"},
                  {origin("rpy=\"0 0 0\" quat_xyzw=\"0 0 0 1\""), "both rpy and quat_xyzw"},
                  {origin("quat_xyzw=\"0 0 0 0\""), "quaternion of zeros"}});
}

}  // namespace
}  // namespace scanmill
