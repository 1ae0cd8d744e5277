#include "world_files.h"

namespace scanmill {
namespace {

using testing::AllOf;
using testing::AnyOf;
using testing::HasSubstr;
using testing::Not;

class Sdf : public WorldFiles {};

TEST_F(Sdf, PosesOfModelLinkAndVisualFollowEachOther) {
  folder_.write("wing.obj", kWing);
  const Asset asset = sdf(R"(<world name="w"><model name="m"><pose>1 2 3 0.1 0.2 0.3</pose>
    <link name="l"><pose>4 5 6 0.4 0.5 0.6</pose>
      <visual name="v"><pose>-1 0.5 2 -0.3 0.2 1</pose><geometry><mesh><uri>wing.obj</uri></mesh></geometry></visual>
    </link></model></world>)");
  expectWing(asset, "m/l/v/wing",
             poseOf(1, 2, 3, 0.1, 0.2, 0.3) * poseOf(4, 5, 6, 0.4, 0.5, 0.6) * poseOf(-1, 0.5, 2, -0.3, 0.2, 1));
}

TEST_F(Sdf, DegreesAndQuaternionsSayTheSame) {
  const Pose expected = poseOf(1, 2, 3, radians(10), radians(20), radians(30));
  expectWing(corners(sdf(wing("m", "<pose degrees=\"true\">1 2 3 10 20 30</pose>")), "m/l/v/wing"), expected);
  const Quat& q = expected.rotation;
  const std::string quat =
      std::to_string(q.x) + " " + std::to_string(q.y) + " " + std::to_string(q.z) + " " + std::to_string(q.w);
  expectWing(corners(sdf(wing("m", "<pose rotation_format=\"quat_xyzw\">1 2 3 " + quat + "</pose>")), "m/l/v/wing"),
             expected);
}

// Frames, joints and links by names, one relative to the other, whatever their order.
TEST_F(Sdf, PosesMayBeRelativeToLinksJointsAndFrames) {
  folder_.write("wing.obj", kWing);
  const Asset asset = sdf(R"(<model name="m">
    <link name="b"><pose relative_to="j">0 0 1 0 0 0.5</pose>
      <visual name="v"><geometry><mesh><uri>wing.obj</uri></mesh></geometry></visual></link>
    <joint name="j" type="fixed"><pose relative_to="f">1 0 0 0 0.25 0</pose><parent>a</parent><child>b</child></joint>
    <frame name="f" attached_to="a"><pose>0 3 0 0.1 0 0</pose></frame>
    <link name="a"><pose>7 0 0 0 0 1</pose>
      <visual name="v"><pose relative_to="b">0 1 0 0 0 0</pose><geometry><mesh><uri>wing.obj</uri></mesh></geometry></visual>
    </link></model>)");
  const Pose b =
      poseOf(7, 0, 0, 0, 0, 1) * poseOf(0, 3, 0, 0.1, 0, 0) * poseOf(1, 0, 0, 0, 0.25, 0) * poseOf(0, 0, 1, 0, 0, 0.5);
  expectWing(asset, "m/b/v/wing", b);
  expectWing(asset, "m/a/v/wing", b * poseOf(0, 1, 0, 0, 0, 0));
}

// SDF 1.6 allows a joint of the same name.
TEST_F(Sdf, LinksStandAtTheirPosesWhateverJointsAreCalled) {
  const Asset asset = sdf(wing("m",
                               "<joint name=\"l\"><child>o</child></joint><link name=\"o\"><pose>5 0 0 0 0 0</pose>"
                               "</link>") +
                          wing("n", "<link name=\"o\"><pose>5 0 0 0 0 0</pose></link>"));
  expectWing(asset, "m/l/v/wing", {});
}

TEST_F(Sdf, ModelsMayBeRelativeToOthersAndPlacedByAFrame) {
  const Asset asset =
      sdf("<world name=\"w\">" + wing("a", "<pose relative_to=\"b\">1 0 0 0 0 0</pose>") +
          wing("b", "<pose>0 5 0 0 0 1.5707963267948966</pose>") +
          "<model name=\"c\" placement_frame=\"l\"><pose>2 2 0 0 0 0</pose><link name=\"l\"><pose>0 0 9 "
          "0 0 1</pose><visual name=\"v\"><geometry><mesh><uri>wing.obj</uri></mesh></geometry>"
          "</visual></link></model></world>");
  expectWing(asset, "a/l/v/wing", poseOf(0, 6, 0, 0, 0, kPi / 2));
  expectWing(asset, "c/l/v/wing", poseOf(2, 2, 0, 0, 0, 0));
}

TEST_F(Sdf, ModelsOfModelsAreThingsWhereTheyAreNoMoreThanThat) {
  const Asset street =
      sdf("<model name=\"street\"><pose>10 0 0 0 0 0</pose>" + wing("left", "<pose>0 1 0 0 0 0</pose>") +
          wing("right", "<pose>0 -1 0 0 0 0</pose>") + "</model>");
  expectWing(street, "street/left/l/v/wing", poseOf(10, 1, 0, 0, 0, 0));
  expectWing(street, "street/right/l/v/wing", poseOf(10, -1, 0, 0, 0, 0));
  EXPECT_NE(street.parts[0].nodeIndex, street.parts[1].nodeIndex);

  const Asset car =
      sdf("<model name=\"car\"><link name=\"body\"><visual name=\"v\"><geometry><box><size>4 2 1</size></box>"
          "</geometry></visual></link>" +
          wing("wheel", "<pose>1 0 0 0 0 0</pose>") + "</model>");
  expectWing(car, "car/wheel/l/v/wing", poseOf(1, 0, 0, 0, 0, 0));
  EXPECT_EQ(car.parts[0].nodeIndex, car.parts[1].nodeIndex);
}

class IncludedSdf : public Sdf {
 protected:
  IncludedSdf() {
    folder_.write("models/post/mesh.obj", kWing);
    for (const char* version : {"1.4", "1.10"}) {
      folder_.write(
          std::string("models/post/model-") + version + ".sdf",
          std::string("<sdf version=\"1.5\"><model name=\"Post\"><pose>0 0 9 0 0 0</pose><link name=\"l\"><visual "
                      "name=\"v") +
              version +
              "\"><geometry><mesh><uri>model://post/mesh.obj</uri><scale>2 2 2</scale></mesh></geometry>"
              "</visual></link></model></sdf>");
    }
    folder_.write("models/post/model.config",
                  "<model><sdf version=\"1.10\">model-1.10.sdf</sdf><sdf version=\"1.4\">model-1.4.sdf</sdf></model>");
  }
  static std::string include(const std::string& more, const std::string& uri = "model://post") {
    return "<include><uri>" + uri + "</uri>" + more + "</include>";
  }
};

TEST_F(IncludedSdf, AreOfTheHighestVersionAndStandWhereTheIncludeSays) {
  const Asset asset = sdf("<world name=\"w\">" + include("<pose>5 0 0 0 0 0</pose>") + "</world>");
  const std::vector<Vec3d> found = corners(asset, "post/l/v1.10/wing");
  EXPECT_LT(length(found[0] - Vec3d{7, 0, 0}), 1e-6);  // scaled by 2, and not 9 m up
  EXPECT_LT(length(found[2] - Vec3d{5, 0, 6}), 1e-6);
  // Without a pose it stands where its own file says.
  EXPECT_LT(length(corners(sdf(world(include(""))), "post/l/v1.10/wing")[2] - Vec3d{0, 0, 15}), 1e-6);
}

TEST_F(IncludedSdf, SeveralOfOneShareTheirMeshes) {
  const Asset asset =
      sdf(world(include("<name>a_1</name><pose>5 0 0 0 0 0</pose>") +
                include("<name>a_02</name><pose relative_to=\"a_1\">0 5 0 0 0 1</pose>") + wing("own")));
  ASSERT_EQ(asset.instanced.size(), 1u);
  const InstancedParts& posts = asset.instanced[0];
  ASSERT_EQ(posts.assetFromParts.size(), 2u);
  EXPECT_EQ(posts.parts.size(), 1u);
  EXPECT_EQ(posts.parts[0].node, "a/l/v1.10/wing");
  EXPECT_LT(length(posts.assetFromParts[1].translation - Vec3d{5, 5, 0}), 1e-9);
  EXPECT_EQ(asset.parts.size(), 1u);
}

TEST_F(IncludedSdf, AreCalledAsTheyAreIncluded) {
  const Asset asset = sdf(world(include("<name>left</name>") + include("<name>right</name><pose>0 1 0 0 0 0</pose>")));
  EXPECT_TRUE(asset.instanced.empty());
  EXPECT_LT(length(corners(asset, "right/l/v1.10/wing")[0] - Vec3d{2, 1, 0}), 1e-6);
  EXPECT_NE(corners(asset, "left/l/v1.10/wing")[2].z, 0);
}

// The name in the world is that of the model around the include, and those that differ in numbers share their meshes.
TEST_F(IncludedSdf, HaveTheNameOfTheModelAroundThem) {
  const auto around = [](const std::string& name, const std::string& inside) {
    return "<model name=\"" + name + "\">" + inside + "</model>";
  };
  corners(sdf(world(around("my_table", include("")))), "my_table/l/v1.10/wing");
  const std::string two = include("<name>left</name>") + include("<name>right</name>");
  const Asset rows = sdf(world(around("row_1", two) + around("row_2", two)));
  ASSERT_EQ(rows.instanced.size(), 2u);
  EXPECT_EQ(rows.instanced[0].parts.at(0).node, "row/left/l/v1.10/wing");
  EXPECT_EQ(rows.instanced[1].parts.at(0).node, "row/right/l/v1.10/wing");
}

// Whoever fetches them must know all of them.
TEST_F(IncludedSdf, ThatAreMissingAreNamedTogetherOrLeftOut) {
  folder_.write("models/gap/model.sdf",
                "<sdf version=\"1.6\">" + model("<mesh><uri>model://gap/a.stl</uri></mesh>") + "</sdf>");
  const std::string world = "<world name=\"w\">\n" + include("", "model://chair") + "\n" +
                            include("<name>other</name>", "model://chair") + "\n" + include("", "model://gap") + "\n" +
                            include("<name>p</name><pose relative_to=\"other\">1 0 0 0 0 0</pose>") + "</world>";
  EXPECT_THAT(refusal(world),
              AllOf(HasSubstr("a.sdf:4: <uri> names 'model://chair'"),
                    HasSubstr("further ones are missing: 'model://gap/a.stl' ("), HasSubstr("model.sdf:1)"),
                    HasSubstr("`missing: leave_out`"), HasSubstr("--leave-out-missing")));
  Asset asset;
  EXPECT_THAT(printedBy([&] { asset = readAsset(folder_.path() / "a.sdf", {.leaveOutMissing = true}); }),
              HasSubstr("left out: 2 missing models and meshes ('model://chair'), 1 missing models and meshes "
                        "('model://gap/a.stl')"));
  EXPECT_LT(length(corners(asset, "p/l/v1.10/wing")[0] - Vec3d{3, 0, 0}), 1e-6);
}

// Frames of a missing model are taken to be at its pose, and a missing model does not count as a model beside others.
TEST_F(IncludedSdf, ThatAreMissingHaveFramesAndStatesOfWhichNothingIsKnown) {
  const std::string gone = include("<name>gone</name><pose>1 0 0 0 0 0</pose>", "model://chair");
  const std::string merged =
      "<include merge=\"true\"><uri>model://arm</uri><name>arm</name><pose>0 0 2 0 0 0</pose></include>";
  const std::string world =
      "<world name=\"w\">" + gone + include("<name>p</name><pose relative_to=\"gone::seat::link\">0 5 0 0 0 0</pose>") +
      "<model name=\"m\">" + merged + include("<name>q</name><pose relative_to=\"hand\">0 1 0 0 0 0</pose>") +
      "</model>" + "<model name=\"my_table\">" + gone + include("") + "</model>" +
      "<state world_name=\"w\"><model name=\"gone\"><pose>1 2 3 0 0 0</pose><link name=\"seat\"/></model>"
      "<model name=\"m\"><link name=\"hand\"/></model></state></world>";
  EXPECT_THAT(refusal(world), AllOf(HasSubstr("'model://chair'"), HasSubstr("'model://arm'")));
  testing::internal::CaptureStderr();
  const Asset asset = readAsset(folder_.path() / "a.sdf", {.leaveOutMissing = true});
  EXPECT_THAT(testing::internal::GetCapturedStderr(), AllOf(HasSubstr("'model://arm'"), Not(HasSubstr("states"))));
  EXPECT_LT(length(corners(asset, "p/l/v1.10/wing")[0] - Vec3d{3, 5, 0}), 1e-6);
  EXPECT_LT(length(corners(asset, "m/l/v1.10/wing")[0] - Vec3d{2, 1, 2}), 1e-6);
  EXPECT_LT(length(corners(asset, "my_table/l/v1.10/wing")[0] - Vec3d{2, 0, 9}), 1e-6);
}

TEST_F(IncludedSdf, AreFoundWhereTheEnvironmentSays) {
  const TemporaryFolder elsewhere;
  elsewhere.write("lamp/model.sdf", "<sdf version=\"1.6\">" + model("<sphere><radius>1</radius></sphere>") + "</sdf>");
  const std::string world = "<world name=\"w\">" + include("", "model://lamp") + "</world>";
  EXPECT_THAT(refusal(world), AllOf(HasSubstr("a.sdf:3"), HasSubstr("model://lamp"), HasSubstr("GAZEBO_MODEL_PATH")));
  ::setenv("GAZEBO_MODEL_PATH", ("/nowhere:" + elsewhere.path().string()).c_str(), 1);
  const Box box = boundsOf(sdf(world));
  ::unsetenv("GAZEBO_MODEL_PATH");
  EXPECT_NEAR(box.high.z, 1, 1e-6);
}

TEST_F(IncludedSdf, TheSunIsALightAndTheGroundPlaneAPlane) {
  const Asset asset = sdf(world(include("", "model://sun") + include("", "model://ground_plane")));
  const Box box = boundsOf(asset);
  EXPECT_EQ(box.low, (Vec3d{-50, -50, 0}));
  EXPECT_EQ(box.high, (Vec3d{50, 50, 0}));
}

// A merged model has its links and frames in the model that includes it, whatever their names.
TEST_F(IncludedSdf, MergedOnesLendTheirFrames) {
  folder_.write(
      "models/arm/model.sdf",
      "<sdf version=\"1.9\"><model name=\"arm\"><frame name=\"f\" attached_to=\"arm\"><pose "
      "relative_to=\"__model__\">0 0 4 0 0 0</pose></frame><link name=\"arm\"><pose>0 0 2 0 0 0</pose><visual "
      "name=\"v\"><geometry><mesh><uri>model://post/mesh.obj</uri></mesh></geometry></visual></link></model></sdf>");
  const Asset asset =
      sdf("<model name=\"m\"><include merge=\"true\"><uri>model://arm</uri><pose>1 0 0 0 0 0</pose></include>" +
          wing("own", "<pose relative_to=\"arm\">0 1 0 0 0 0</pose>") +
          wing("two", "<pose relative_to=\"f\">0 1 0 0 0 0</pose>") + "</model>");
  expectWing(asset, "m/arm/v/wing", poseOf(1, 0, 2, 0, 0, 0));
  expectWing(asset, "m/own/l/v/wing", poseOf(1, 1, 2, 0, 0, 0));
  expectWing(asset, "m/two/l/v/wing", poseOf(1, 1, 4, 0, 0, 0));
}

TEST_F(Sdf, SolidsHaveTheirSizes) {
  const auto expectSize = [&](const std::string& shape, const Vec3d& size, double within = 1e-6) {
    const Box box = boundsOf(sdf(model(shape)));
    const Vec3d off = box.high - box.low - size;
    EXPECT_LT(std::max({std::fabs(off.x), std::fabs(off.y), std::fabs(off.z)}), within) << shape;
    EXPECT_LT(length(box.center()), within) << shape;
  };
  expectSize("<box><size>1 2 3</size></box>", {1, 2, 3});
  expectSize("<cylinder><radius>0.5</radius><length>3</length></cylinder>", {1, 1, 3}, 0.01);
  expectSize("<cone><radius>0.5</radius><length>3</length></cone>", {1, 1, 3}, 0.01);
  expectSize("<sphere><radius>2</radius></sphere>", {4, 4, 4}, 0.05);
  expectSize("<capsule><radius>0.5</radius><length>3</length></capsule>", {1, 1, 4}, 0.01);
  expectSize("<ellipsoid><radii>1 2 3</radii></ellipsoid>", {2, 4, 6}, 0.1);
  // The first size of a plane is that along x before the shortest rotation from z to the normal.
  for (const auto& [normal, size] : {std::pair("0 0 1", Vec3d{10, 2, 0}),
                                     {"0 0 -1", {10, 2, 0}},
                                     {"1 0 0", {0, 2, 10}},
                                     {"0 1 0", {10, 0, 2}},
                                     {"-3 0 4", {8, 2, 6}},
                                     {"0 -4 -3", {10, 1.2, 1.6}}}) {
    expectSize("<plane><normal>" + std::string(normal) + "</normal><size>10 2</size></plane>", size, 1e-5);
  }
}

TEST_F(Sdf, MirroredMeshesKeepTheirOutside) {
  folder_.write("wing.obj", kWing);
  const Asset asset = sdf(model("<mesh><uri>wing.obj</uri><scale>-1 1 1</scale></mesh>"));
  const AssetPart& part = asset.parts.at(0);
  const Triangle& t = part.triangles.at(0);
  const auto corner = [&](int i) { return Vec3d(part.positions[t[i]]); };
  const Vec3d normal = cross(corner(1) - corner(0), corner(2) - corner(0));
  EXPECT_LT(dot(normal, Vec3d{1, 0, 0}), 0);  // as mirrored as the wing, whose normal is (6, 3, 2)
  EXPECT_GT(dot(normal, Vec3d{0, 1, 0}), 0);
}

TEST_F(Sdf, SubmeshesAreTakenAloneAndCentred) {
  folder_.write("two.obj", std::string(kWing) + "o box\nv 10 0 0\nv 12 0 0\nv 10 4 0\nf 4 5 6\n");
  const auto visual = [](const std::string& submesh) {
    return model("<mesh><uri>two.obj</uri>" + submesh + "</mesh>");
  };
  EXPECT_EQ(sdf(visual("")).parts.size(), 2u);
  EXPECT_EQ(boundsOf(sdf(visual("<submesh><name>box</name></submesh>"))).low, (Vec3d{10, 0, 0}));
  EXPECT_EQ(boundsOf(sdf(visual("<submesh><name>box</name><center>true</center></submesh>"))).low, (Vec3d{-1, -2, 0}));
  EXPECT_THAT(refusal(visual("<submesh><name>bix</name></submesh>")),
              AllOf(HasSubstr("no submesh 'bix'"), HasSubstr("box, wing")));
  folder_.write("bare.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  EXPECT_THAT(refusal(model("<mesh><uri>bare.obj</uri><submesh><name>zz</name></submesh></mesh>")),
              HasSubstr("has no submesh 'zz', since none of its parts has a name: leave out <submesh>"));
}

// Names without colours are names too, and commas, comments and alpha are as users write them.
TEST_F(Sdf, LooksAndNumbersAreReadAsOthersWriteThem) {
  folder_.write("wing.obj", kWing);
  testing::internal::CaptureStderr();
  const Asset asset = sdf(wing("m", "<pose>1 2 <!-- z --> 3 0 0 1e-400</pose>",
                               "<material><script><name>Gazebo/Brick</name></script></material>"));
  EXPECT_THAT(testing::internal::GetCapturedStderr(), HasSubstr("1 looks by scripts of OGRE"));
  EXPECT_EQ(asset.parts.at(0).material, "Gazebo/Brick");
  expectWing(asset, "m/l/v/wing", poseOf(1, 2, 3, 0, 0, 0));
  const Asset red = sdf(wing("m", "", "<material><diffuse>1 0 0</diffuse></material>"));
  EXPECT_FLOAT_EQ(red.parts.at(0).color[1], 0);
}

// A chain of any length is none that goes round.
TEST_F(Sdf, ChainsOfFramesMayBeLong) {
  std::string frames;
  for (int i = 0; i < 100; ++i) {
    const std::string on = i == 0 ? "" : " attached_to=\"f" + std::to_string(i - 1) + "\"";
    frames += "<frame name=\"f" + std::to_string(i) + "\"" + on + "><pose>1 0 0 0 0 0</pose></frame>";
  }
  const Asset asset = sdf(world(frames + wing("m", "<pose relative_to=\"f99\">0 1 0 0 0 0</pose>")));
  expectWing(asset, "m/l/v/wing", poseOf(100, 1, 0, 0, 0, 0));
}

class StateSdf : public Sdf {
 protected:
  // A world with two wings, at x = 1 and 2, and a state.
  std::string wings(const std::string& state, const std::string& more = "") const {
    return world(wing("a", "<pose>1 0 0 0 0 0</pose>") + wing("b", "<pose>2 0 0 0 0 0</pose>") + more + state);
  }
  static std::string state(const std::string& inside) {
    return "<state world_name=\"w\"><sim_time>1 0</sim_time>" + inside + "</state>";
  }
  std::string toldOf(const std::string& inside) const {
    return printedBy([&] { sdf(inside); });
  }
};

// Worlds that Gazebo saves have the models as they were inserted, and where they stood at last in a state: the poses of
// models and links are those in the world.
TEST_F(StateSdf, MovesModelsAndLinks) {
  const Asset asset = sdf(wings(state(R"(
    <model name="a"><pose>5 6 7 0.1 0.2 0.3</pose><scale>1 1 1</scale>
      <link name="l"><pose>8 9 10 0.4 0.5 0.6</pose><velocity>1 0 0 0 0 0</velocity></link></model>
    <model name="b"><pose>3 0 0 0 0 1</pose></model><light name="sun"><pose>0 0 10 0 0 0</pose></light>)")));
  expectWing(asset, "a/l/v/wing", poseOf(8, 9, 10, 0.4, 0.5, 0.6));
  expectWing(asset, "b/l/v/wing", poseOf(3, 0, 0, 0, 0, 1));
}

TEST_F(StateSdf, MovesNestedModels) {
  const std::string outer =
      "<model name=\"outer\"><pose>1 1 0 0 0 0</pose>" + wing("in", "<pose>0 0 4 0 0 0</pose>") +
      wing("still", "<pose>0 0 5 0 0 0</pose>") +
      "<link name=\"l\"><pose>0 0 1 0 0 0</pose><visual name=\"v\"><pose>1 0 0 0 0 0</pose><geometry>"
      "<mesh><uri>wing.obj</uri></mesh></geometry></visual></link></model>";
  const Asset asset = sdf(wings(state(R"(<model name="outer"><pose>10 0 0 0 0 1</pose>
    <link name="l"><pose>10 0 3 0 0 2</pose></link>
    <model name="in"><pose>20 1 0 0.3 0 0</pose><link name="l"><pose>20 1 2 0.3 0 0</pose></link></model></model>)"),
                                outer));
  expectWing(asset, "outer/l/v/wing", poseOf(10, 0, 3, 0, 0, 2) * poseOf(1, 0, 0, 0, 0, 0));
  expectWing(asset, "outer/in/l/v/wing", poseOf(20, 1, 2, 0.3, 0, 0));
  expectWing(asset, "outer/still/l/v/wing", poseOf(10, 0, 0, 0, 0, 1) * poseOf(0, 0, 5, 0, 0, 0));
}

// A state's scale enlarges shapes in their own frames, and leaves them where they are; round ones stay round.
TEST_F(StateSdf, ScalesVisuals) {
  const auto sizeOf = [&](const std::string& shape) {
    const std::string at = "<pose>1 2 3 0 0 0</pose>";
    const Box box = boundsOf(sdf("<world name=\"w\"><model name=\"m\"><link name=\"l\"><visual name=\"v\">" + at +
                                 "<geometry>" + shape + "</geometry></visual></link></model>" +
                                 state("<model name=\"m\"><scale>2 3 4</scale></model>") + "</world>"));
    EXPECT_LT(length(box.center() - Vec3d{1, 2, 3}), 1e-5);
    return box.high - box.low;
  };
  const auto near = [](const Vec3d& a, const Vec3d& b) { return length(a - b) < 0.2; };
  EXPECT_TRUE(near(sizeOf("<box><size>1 1 2</size></box>"), {2, 3, 8}));
  EXPECT_TRUE(near(sizeOf("<sphere><radius>1</radius></sphere>"), {8, 8, 8}));
  EXPECT_TRUE(near(sizeOf("<cylinder><radius>1</radius><length>2</length></cylinder>"), {6, 6, 8}));
  EXPECT_THAT(refusal(wings(state("<model name=\"a\"><scale>0 1 1</scale></model>"))), HasSubstr("above 0"));
}

// Gazebo applies the first state alone.
TEST_F(StateSdf, OthersThanTheFirstAndOfUnknownModelsAreTold) {
  const std::string first =
      state("<model name=\"a\"><pose>4 0 0 0 0 0</pose><link name=\"x\"/></model><model name=\"z\"/>");
  const std::string told = toldOf(wings(first + state("<model name=\"a\"><pose>5 0 0 0 0 0</pose></model>")));
  EXPECT_THAT(told, AllOf(HasSubstr("1 states after the first"),
                          HasSubstr("2 states of models and links that the world lacks (the first is 'x')")));
  expectWing(corners(sdf(wings(first + state(""))), "a/l/v/wing"), poseOf(4, 0, 0, 0, 0, 0));
  EXPECT_EQ(toldOf(wings(state("<model name=\"a\"><pose>4 0 0 0 0 0</pose></model>"))), "");
  EXPECT_THAT(toldOf(wings(state("<insertions>" + wing("c") + "</insertions>"))),
              HasSubstr("1 models that a state inserts or deletes"));
}

TEST_F(StateSdf, MovesTheGroundPlaneThatNeedsNoFile) {
  testing::internal::CaptureStderr();
  const Asset asset =
      sdf("<world name=\"w\"><include><uri>model://ground_plane</uri></include>" +
          state("<model name=\"ground_plane\"><pose>1 2 3 0 0 0</pose><link name=\"link\"><pose>1 2 3 0 0 0</pose>"
                "</link></model>") +
          "</world>");
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
  EXPECT_EQ(asset.parts.at(0).node, "ground_plane/link/visual");
  EXPECT_EQ(boundsOf(asset).low, (Vec3d{-49, -48, 3}));
}

// An included model whose links a state moves is no copy of the others.
TEST_F(StateSdf, OfIncludedModelsIsTheirOwn) {
  folder_.write("post/model.sdf", "<sdf version=\"1.6\">" + wing("Post") + "</sdf>");
  const std::string include = "<include><uri>post</uri><name>p_";
  const Asset asset =
      sdf(world(include + "1</name></include>" + include + "2</name></include>" + include + "3</name></include>" +
                state("<model name=\"p_2\"><link name=\"l\"><pose>0 0 5 0 0 0</pose></link></model>")));
  ASSERT_EQ(asset.instanced.size(), 1u);
  EXPECT_EQ(asset.instanced[0].assetFromParts.size(), 2u);
  expectWing(asset, "p_2/l/v/wing", poseOf(0, 0, 5, 0, 0, 0));
}

// One warning for a file with all that it includes, and none for elements that beams do not see.
TEST_F(Sdf, ContentsThatAreLeftOutAreToldOnceWithTheirNumber) {
  folder_.write("post/model.sdf", "<sdf version=\"1.6\">" +
                                      wing("post", "", "<laser_retro>5</laser_retro><laser_retro>0</laser_retro>") +
                                      "</sdf>");
  const std::string include = "<include><uri>post</uri></include>";
  testing::internal::CaptureStderr();
  sdf("<world name=\"w\"><physics><ode/></physics><light name=\"sun\"/><plugin name=\"p\"><model/></plugin>" + include +
      include +
      "<actor "
      "name=\"x\"><skin/></actor><road/><road/><drake:thing/><include><uri>post</uri><experimental:params/></include>" +
      model("<image><uri>a.png</uri></image>", "<transparency>0.5</transparency><cast_shadows>1</cast_shadows>") +
      model("<box><size>1 1 1</size></box>", "<material><diffuse>1 0 0 0.2</diffuse></material>") +
      model("<torus/>", "<transparency>1</transparency><visibility_flags>4294967295</visibility_flags>") +
      "<joint name=\"j\"><axis><initial_position>1</initial_position></axis></joint></world><world name=\"v\"/>");
  const std::string told = testing::internal::GetCapturedStderr();
  EXPECT_THAT(
      told,
      HasSubstr(
          "a.sdf: left out: 1 actors, 1 alphas of diffuse colours (these visuals are solid), 1 changes of included "
          "models (experimental:params), "
          "1 extruded images (image), 1 initial positions of joints, 2 roads, "
          "1 transparencies between 0 and 1 (these visuals are solid), 1 unknown 'torus', 1 values of laser_retro, "
          "1 worlds after the first\n"));
  EXPECT_EQ(std::count(told.begin(), told.end(), '\n'), 1);
}

TEST_F(Sdf, NumbersAndNamesOfPosesAreThoseOfTheSpecification) {
  expectWing(corners(sdf(wing("m", "<pose degrees=\"1\">0 0 0 0 0 90</pose>")), "m/l/v/wing"),
             poseOf(0, 0, 0, 0, 0, kPi / 2));
  // Names with colons, as in models that were flattened.
  const Asset flat =
      sdf("<model name=\"m\"><frame name=\"in::__model__\"><pose>0 0 2 0 0 0</pose></frame><link name=\"in::l\">"
          "<pose relative_to=\"in::__model__\">1 0 0 0 0 0</pose><visual name=\"v\"><geometry><mesh><uri>wing.obj"
          "</uri></mesh></geometry></visual></link></model>");
  expectWing(flat, "m/in::l/v/wing", poseOf(1, 0, 2, 0, 0, 0));
}

TEST_F(IncludedSdf, MayBeReferredToByTheNameInTheirFile) {
  const Asset asset =
      sdf(world(include("<pose>1 0 0 0 0 0</pose>") + wing("own", "<pose relative_to=\"Post\">0 1 0 0 0 0</pose>")));
  expectWing(asset, "own/l/v/wing", poseOf(1, 1, 0, 0, 0, 0));
}

TEST_F(Sdf, PhysicallyBasedMaterialsHaveTheirGloss) {
  const std::string metal =
      "<material><pbr><metal><roughness>0.25</roughness><metalness>0.75</metalness></metal></pbr></material>";
  for (const Asset& asset : {sdf(model("<box><size>1 1 1</size></box>", metal)), sdf(wing("m", "", metal))}) {
    EXPECT_EQ(asset.parts.at(0).fileMaterial.roughness, 0.25f);
    EXPECT_EQ(asset.parts[0].fileMaterial.metallic, 0.75f);
  }
}

TEST_F(Sdf, MistakesAreNamedWithTheirLine) {
  std::string deep;
  for (int i = 0; i < 100; ++i) deep = "<a>" + deep + "</a>";
  expectRefusals([&](const std::string& text) { return messageOf([&] { read("b.sdf", text); }); },
                 {{"<sdf>\n<model>\n</sdf>", "b.sdf:3 | not XML"},
                  {"<robot/>", "not an SDF"},
                  {"<sdf version=\"1.6\"/>", "neither a world nor a model"},
                  {"nothing", "not XML"},
                  {"<sdf>" + deep + "</sdf>", "nested more than"}});
  folder_.write("r.urdf", "<robot name=\"r\"/>");
  folder_.write("models/empty/readme.txt", "x");
  folder_.write("models/odd/model.config", "<model><sdf version=\"abc\">model.sdf</sdf></model>");
  folder_.write("models/egg/model.sdf",
                "<sdf version=\"1.6\"><model name=\"egg\"><include><uri>model://egg</uri></include></model></sdf>");
  const auto include = [](const std::string& uri) {
    return "<world name=\"w\"><include><uri>" + uri + "</uri></include></world>";
  };
  expectRefusals(
      [&](const std::string& inside) { return refusal(inside); },
      {{wing("m", "<pose>1 2 3 4 5</pose>"), "a.sdf:3 | 5 numbers"},
       {wing("m", "<pose>1 2 3 4 5 x</pose>"), "'x'"},
       {wing("m", "<pose rotation_format=\"wxyz\">0 0 0 1 0 0 0</pose>"), "a.sdf:3 | 'wxyz', but it must be"},
       {wing("m", "", "<pose relative_to=\"gone\">0 0 0 0 0 0</pose>"), "'gone', but this"},
       {wing("m", "", "<pose relative_to=\"world\">0 0 0 0 0 0</pose>"), "'world', but this frame"},
       {"<model name=\"m\"><frame name=\"a\" attached_to=\"b\"/><frame name=\"b\" attached_to=\"a\"/>"
        "<link name=\"l\"><pose relative_to=\"a\">0 0 0 0 0 0</pose></link></model>",
        "relative to itself"},
       {"<model name=\"m\"><link name=\"l\"><collision><geometry><box/></geometry></collision></link></model>",
        "has no triangle | not their <collision>s"},
       {"<model name=\"m\"><link name=\"l\"/>\n<link name=\"l\"><pose>5 0 0 0 0 0</pose></link></model>",
        "a.sdf:4 | 'l', as another link"},
       {"<model name=\"m\"><origin pose=\"0 0 1 0 0 0\"/></model>", "gz sdf -c"},
       {model("<mesh><uri>gone.obj</uri></mesh>"), "a.sdf:3 | gone.obj"},
       {model("<box><size>1 2</size></box>"), "a.sdf:3 | 2 numbers, but must have 3"},
       {model("<sphere><radius>-1</radius></sphere>"), "above 0"},
       {include("model://odd"), "model.config:1 | 'abc', which is no number"},
       {include("r.urdf"), "r.urdf:1 | is a URDF | a.sdf:3 | gz sdf -p"},
       {include("https://fuel.gazebosim.org/x"), "download"},
       {include("model://"), "model://"},
       {include("model://empty"), "a.sdf:3 | of this name exists | model.sdf"},
       {include("model://egg"), "include itself"}});
}

// An element in a wrong place means nothing. Of elements that may stand once, the first counts.
TEST_F(Sdf, ElementsInWrongPlacesAreTold) {
  const auto told = [&](const std::string& inside) {
    folder_.write("misplaced.sdf", "<sdf version=\"1.9\"><world name=\"w\">" + inside + "</world></sdf>");
    return printedBy([&] { EXPECT_NEAR(boundsOf(readAsset(folder_.path() / "misplaced.sdf", {})).high.x, 0.5, 1e-9); });
  };
  const std::string big = "<geometry><box><size>9 9 9</size></box></geometry>";
  const auto model = [](const std::string& inModel, const std::string& inLink = "", const std::string& inVisual = "",
                        const std::string& shape = "") {
    return "<model name=\"m\">" + inModel + "<link name=\"l\">" + inLink + "<visual name=\"v\">" + inVisual +
           "<geometry>" + shape + "<box><size>1 1 1</size></box></geometry></visual></link></model>";
  };
  EXPECT_THAT(
      told(model("<pose/><frame name=\"f\"><pose/></frame>", "<pose/><collision name=\"c\">" + big + "</collision>",
                 "<pose/><material><script><uri>a</uri><uri>b</uri></script></material>") +
           "<state world_name=\"w\"><model name=\"m\"><scale>1 1 1</scale><link name=\"l\"/></model></state>"),
      Not(AnyOf(HasSubstr("misplaced <"), HasSubstr("second <"))));
  EXPECT_THAT(told(model("<visual name=\"u\">" + big + "</visual>")), HasSubstr("1 misplaced <visual> in <model>"));
  EXPECT_THAT(told(model("") + "<link name=\"k\"><visual name=\"u\">" + big + "</visual></link>"),
              HasSubstr("1 misplaced <link> in <world>"));
  EXPECT_THAT(told(model("", model("<pose>5 0 0 0 0 0</pose>"))), HasSubstr("1 misplaced <model> in <link>"));
  EXPECT_THAT(told(model("", "", "<scale>2 2 2</scale>")), HasSubstr("1 misplaced <scale> in <visual>"));
  EXPECT_THAT(told(model("", "", "", "<pose>3 0 0 0 0 0</pose>")), HasSubstr("1 misplaced <pose> in <geometry>"));
  EXPECT_THAT(told(model("<pose/><pose>3 0 0 0 0 0</pose>")), HasSubstr("1 second <pose> in <model>"));
  EXPECT_THAT(told(model("", "", "<geometry><box><size>1 1 1</size></box></geometry>")),
              HasSubstr("1 second <geometry> in <visual>"));
  EXPECT_THAT(told(model("", "", "<material><diffuse>255 128 0 1</diffuse></material>")),
              HasSubstr("1 numbers of colours above 1 (they count as 1)"));
}

}  // namespace
}  // namespace scanmill
