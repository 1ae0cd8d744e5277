#include <string>
#include <vector>

#include "assets/meshes/imported_file.h"
#include "assets/meshes/references.h"
#include "base/error.h"
#include "base/file.h"
#include "tests/core/assets/meshes/triangle_files.h"
#include "tests/core/assets/read_assets.h"
#include "tests/support/message_of.h"

namespace scanmill {
namespace {

using testing::AllOf;
using testing::HasSubstr;

TEST_F(AssetFiles, TexturesAreUprightInEveryKind) {
  write("a.mtl", kMtl);
  writeColours(folder_.path() / "colours.png");
  Gltf gltf;
  gltf.material = R"({"name":"paint","pbrMetallicRoughness":{"baseColorTexture":{"index":0},
                      "baseColorFactor":[0.5,0.5,0.5,1],"roughnessFactor":0.25,"metallicFactor":1}})";
  gltf.extra = R"(,"textures":[{"source":0}],"images":[{"uri":"colours.png"}])";
  for (const auto& [name, text] :
       std::vector<std::pair<std::string, std::string>>{{"a.obj", kObj}, {"a.ac", kAc}, {"a.gltf", gltf.text()}}) {
    const Asset asset = read(name, text, {.up = 'z'});
    const AssetPart& part = asset.parts.at(0);
    expectColours(part, name);
    EXPECT_EQ(part.texture, "colours.png") << name;
    EXPECT_TRUE(part.fileMaterial.textured);
    EXPECT_FALSE(part.fileMaterial.alphaTested);
    EXPECT_NEAR(part.fileMaterial.textureMean, kColoursMean, 1e-5);
    EXPECT_NEAR(part.fileMaterial.reflectance, name == "a.gltf" ? 0.5 * kColoursMean : kColoursMean, 1e-5) << name;
    const Asset plain = read(name, text, {.textures = false});
    EXPECT_FALSE(plain.parts.at(0).fileMaterial.textured);
    EXPECT_FALSE(plain.parts.at(0).fileMaterial.texture);
    EXPECT_EQ(plain.parts.at(0).texture, "colours.png");
  }
  const Asset asset = read("a.gltf", gltf.text());
  EXPECT_EQ(asset.parts[0].fileMaterial.roughness, 0.25f);
  EXPECT_EQ(asset.parts[0].fileMaterial.metallic, 1.0f);
}

TEST_F(AssetFiles, WebpAndEmbeddedTexturesOfGltfAreFound) {
  std::filesystem::create_directories(folder_.path() / "my textures");
  writeColours(folder_.path() / "my textures" / "colours.webp");
  const std::string image = readFile(folder_.path() / "my textures" / "colours.webp");
  Gltf gltf;
  gltf.material = R"({"name":"paint","pbrMetallicRoughness":{"baseColorTexture":{"index":0}}})";
  const std::string texture = R"(,"textures":[{"extensions":{"EXT_texture_webp":{"source":0}}}],"images":[)";
  for (const std::string& source :
       {std::string(R"({"uri":"my%20textures%2Fcolours.webp"})"),
        R"({"mimeType":"image/webp","uri":"data:image/webp;base64,)" + base64(image) + "\"}"}) {
    gltf.extra = texture + source + "]";
    const Asset asset = read("a.gltf", gltf.text(), {.up = 'z'});
    expectColours(asset.parts.at(0), source.substr(0, 30));
    EXPECT_NEAR(asset.parts[0].fileMaterial.reflectance, kColoursMean, 0.02);
  }
  gltf.extra = texture + R"({"uri":"my%20textures%2Fcolours.webp"}])";
  EXPECT_EQ(read("a.gltf", gltf.text()).parts.at(0).texture, "my textures/colours.webp");
}

TEST_F(AssetFiles, AlphaIsTestedWhereTheFileAndItsTextureSaySo) {
  writeColours(folder_.path() / "opaque.png");
  writeColours(folder_.path() / "holes.png", 0);
  const auto material = [&](const std::string& mode, const std::string& image, bool textures,
                            AlphaUse alpha = AlphaUse::Auto) {
    Gltf gltf;
    gltf.material = R"({"name":"leaf",)" + mode + R"("pbrMetallicRoughness":{"baseColorTexture":{"index":0}}})";
    gltf.extra = R"(,"textures":[{"source":0}],"images":[{"uri":")" + image + R"("}])";
    return read("a.gltf", gltf.text(), {.alpha = alpha, .textures = textures}).parts.at(0).fileMaterial;
  };
  for (const bool textures : {true, false}) {
    EXPECT_FALSE(material("", "holes.png", textures).alphaTested);
    EXPECT_EQ(material("", "holes.png", textures, AlphaUse::Test).alphaTested, true);
    EXPECT_EQ(material("", "holes.png", textures, AlphaUse::Test).alphaCutoff, 0.5f);
    EXPECT_FALSE(material(R"("alphaMode":"BLEND",)", "holes.png", textures, AlphaUse::Ignore).alphaTested);
    EXPECT_FALSE(material(R"("alphaMode":"MASK",)", "opaque.png", textures).alphaTested);
    EXPECT_EQ(material(R"("alphaMode":"MASK",)", "opaque.png", textures).texture != nullptr, textures);
    const Material mask = material(R"("alphaMode":"MASK","alphaCutoff":0.25,)", "holes.png", textures);
    EXPECT_TRUE(mask.alphaTested);
    EXPECT_EQ(mask.alphaCutoff, 0.25f);
    EXPECT_TRUE(mask.texture);
    EXPECT_EQ(mask.textured, textures);
    // What a beam meets has no part in the hole, which is blue.
    EXPECT_NEAR(mask.reflectance, (0.2126 + 0.7152 + 1) / 3, 1e-5);
    EXPECT_TRUE(material(R"("alphaMode":"BLEND",)", "holes.png", textures).alphaTested);
  }
}

TEST_F(AssetFiles, OpacityMapsOfObjMakeHoles) {
  writeColours(folder_.path() / "colours.png");
  writeColours(folder_.path() / "holes.png", 0);
  write("a.mtl", std::string(kMtl) + "map_d holes.png\n");
  const Material material = read("a.obj", kObj).parts.at(0).fileMaterial;
  EXPECT_TRUE(material.alphaTested);
  EXPECT_EQ(material.texture->texel(0.25f, 0.25f)[3], 0);
  EXPECT_EQ(material.texture->texel(0.25f, 0.75f)[3], 255);
  write("a.mtl", "newmtl paint\nKd 0.5 0.5 0.5\nmap_d holes.png\n");
  const Material plain = read("a.obj", kObj).parts.at(0).fileMaterial;
  EXPECT_TRUE(plain.alphaTested);
  EXPECT_FALSE(plain.textured);
  EXPECT_NEAR(plain.reflectance, 0.5, 1e-6);
}

// Squares of the picture of writeColours(), whose blue quarter has no alpha: `squares` of the whole picture, of white
// alone and of blue alone, of equal size.
std::string squares(int whole, int white, int blue) {
  std::string text =
      "mtllib a.mtl\nusemtl paint\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nvt 0.6 0.1\nvt 0.9 0.1\nvt 0.9 0.4\nvt 0.6 0.4\n"
      "vt 0.1 0.1\nvt 0.4 0.1\nvt 0.4 0.4\nvt 0.1 0.4\n";
  for (int i = 0; i < whole + white + blue; ++i) {
    const int uv = i < whole ? 1 : i < whole + white ? 5 : 9;
    for (const auto& [x, y] : {std::pair(0, 0), {1, 0}, {1, 1}, {0, 1}}) {
      text += "v " + std::to_string(x) + " " + std::to_string(y) + " " + std::to_string(i) + "\n";
    }
    text += "f";
    for (int k = 0; k < 4; ++k) text += " " + std::to_string(4 * i + k + 1) + "/" + std::to_string(uv + k);
    text += "\n";
  }
  return text;
}

TEST_F(AssetFiles, AlphaThatNobodyDeclaresCountsWhereItLooksLikeCutOuts) {
  const std::string plain = "newmtl paint\nKd 0.5 0.5 0.5\nmap_Kd holes.png\n";
  const auto tested = [&](const std::string& mtl, const std::string& obj, const AssetOptions& options = {}) {
    write("a.mtl", mtl);
    const Material material = read("a.obj", obj, options).parts.at(0).fileMaterial;
    EXPECT_EQ(material.texture != nullptr, material.alphaTested || options.textures);
    EXPECT_EQ(material.textured, options.textures);
    return material.alphaTested;
  };
  writeColours(folder_.path() / "holes.png", 0);
  for (const bool textures : {true, false}) {
    const AssetOptions options{.textures = textures};
    EXPECT_TRUE(tested(plain, squares(10, 0, 0), options)) << "every card has a hole";
    EXPECT_TRUE(tested(plain, squares(5, 4, 1), options)) << "a tenth would vanish";
    EXPECT_FALSE(tested(plain, squares(5, 2, 3), options)) << "three tenths would vanish";
    EXPECT_FALSE(tested(plain, squares(0, 10, 0), options)) << "nothing is cut away";
    // Whatever it looks like, the material's word counts; `d 0` is no word, for the material would not be there.
    for (const char* word : {"map_d holes.png\n", "d 0.9\n", "Tr 0.1\n"}) {
      EXPECT_TRUE(tested(plain + word, squares(5, 2, 3), options)) << word;
    }
    for (const char* word : {"d 1\n", "d 0\n", "Tr 0\n", "illum 2\n"}) {
      EXPECT_FALSE(tested(plain + word, squares(5, 2, 3), options)) << word;
      EXPECT_TRUE(tested(plain + word, squares(10, 0, 0), options)) << word;
    }
    // And the caller's word before that.
    EXPECT_TRUE(tested(plain, squares(5, 2, 3), {.alpha = AlphaUse::Test, .textures = textures}));
    EXPECT_FALSE(tested(plain, squares(10, 0, 0), {.alpha = AlphaUse::Ignore, .textures = textures}));
    EXPECT_FALSE(
        tested(plain + "map_d holes.png\n", squares(10, 0, 0), {.alpha = AlphaUse::Ignore, .textures = textures}));
  }
  EXPECT_TRUE(tested(plain, squares(18, 0, 2)));
  writeColours(folder_.path() / "holes.png", 100);
  EXPECT_TRUE(tested(plain, squares(10, 0, 0)));
  EXPECT_FALSE(tested(plain, squares(18, 0, 2))) << "a third of the surface is neither on nor off";
}

// dae() with an image; its texture coordinates are in the quarter without alpha.
std::string texturedDae() {
  std::string collada = dae("Z_UP", "1");
  collada = replaced(collada, "<library_geometries>",
                     R"(<library_images><image id="i"><init_from>holes.png</init_from></image></library_images>
<library_effects><effect id="e"><profile_COMMON>
<newparam sid="s"><surface type="2D"><init_from>i</init_from></surface></newparam>
<newparam sid="t"><sampler2D><source>s</source></sampler2D></newparam>
<technique sid="common"><lambert><diffuse><texture texture="t" texcoord="UV"/></diffuse><!--alpha--></lambert></technique>
</profile_COMMON></effect></library_effects>
<library_materials><material id="m" name="paint"><instance_effect url="#e"/></material></library_materials>
<library_geometries>)");
  collada = replaced(collada, "<vertices ",
                     R"(<source id="u"><float_array id="ua" count="6">0.1 0.1 0.4 0.1 0.1 0.4</float_array>
<technique_common><accessor source="#ua" count="3" stride="2"><param name="S" type="float"/><param name="T" type="float"/>
</accessor></technique_common></source><vertices )");
  collada = replaced(collada, R"(<triangles count="1">)", R"(<triangles count="1" material="p">)");
  collada = replaced(collada, "<p>0 1 2</p>",
                     R"(<input semantic="TEXCOORD" source="#u" offset="1" set="0"/><p>0 0 1 1 2 2</p>)");
  collada = replaced(collada, R"(<instance_geometry url="#g"/>)",
                     R"(<instance_geometry url="#g"><bind_material><technique_common>
<instance_material symbol="p" target="#m"/></technique_common></bind_material></instance_geometry>)");
  return collada;
}

// A triangle wholly in the quarter without alpha: not how cut-outs look, so the declaration alone decides.
TEST_F(AssetFiles, TransparencyOfColladaAndAc3dIsADeclaration) {
  writeColours(folder_.path() / "holes.png", 0);
  const auto tested = [&](const std::string& name, const std::string& text) {
    const Material material = read(name, text).parts.at(0).fileMaterial;
    EXPECT_TRUE(material.texture) << name;
    return material.alphaTested;
  };
  std::string ac = replaced(kAc, "colours.png", "holes.png");
  ac = replaced(replaced(ac, "1 0.75 0.25", "1 0.4 0.25"), "2 0.25 0.75", "2 0.25 0.4");
  EXPECT_FALSE(tested("a.ac", ac));
  EXPECT_TRUE(tested("a.ac", replaced(ac, "trans 0", "trans 0.25")));

  const std::string collada = texturedDae();
  const auto with = [&](const std::string& alpha) { return tested("a.dae", replaced(collada, "<!--alpha-->", alpha)); };
  EXPECT_FALSE(with(""));
  EXPECT_FALSE(with(R"(<transparent opaque="A_ONE"><color>1 1 1 1</color></transparent>
                       <transparency><float>1</float></transparency>)"));
  EXPECT_TRUE(with(R"(<transparent opaque="A_ONE"><color>1 1 1 1</color></transparent>
                      <transparency><float>0.5</float></transparency>)"));
  EXPECT_TRUE(with(R"(<transparent opaque="A_ONE"><texture texture="t" texcoord="UV"/></transparent>)"));
}

// COLLADA 1.4.1, 7-5: A_ZERO and RGB_ZERO are opaque where the image, times `transparency`, is 0.
TEST_F(AssetFiles, ImagesOfTransparencyAreInvertedWhereTheFileSaysSo) {
  writeColours(folder_.path() / "holes.png", 0);
  const auto alphas = [&](const std::string& opaque, const std::string& number = "1") {
    const std::string alpha = "<transparent opaque=\"" + opaque +
                              R"("><texture texture="t" texcoord="UV"/></transparent>
<transparency><float>)" + number +
                              "</float></transparency>";
    testing::internal::CaptureStderr();
    const Material material = read("a.dae", replaced(texturedDae(), "<!--alpha-->", alpha)).parts.at(0).fileMaterial;
    const std::string told = testing::internal::GetCapturedStderr();
    EXPECT_EQ(told.find("1 numbers of `transparency` beside images") != std::string::npos, number == "0.5") << told;
    if (!material.alphaTested) return std::string("solid");
    return std::to_string(material.texture->texel(0.25f, 0.25f)[3]) + " " +
           std::to_string(material.texture->texel(0.75f, 0.75f)[3]);
  };
  EXPECT_EQ(alphas("A_ONE"), "0 255");
  EXPECT_EQ(alphas("A_ONE", "0.5"), "0 255");
  EXPECT_EQ(alphas("A_ZERO"), "255 0");
  EXPECT_EQ(alphas("RGB_ZERO"), "255 0");
  EXPECT_EQ(alphas("RGB_ZERO", "0"), "solid");
}

TEST_F(AssetFiles, MaterialsOfColladaWithoutAPlainColourAreCounted) {
  writeColours(folder_.path() / "holes.png");
  const std::string image = R"(<diffuse><texture texture="t" texcoord="UV"/></diffuse>)";
  for (const auto& [name, other] : {std::pair("param.dae", R"(<diffuse><param ref="c"/></diffuse>)"),
                                    {"light.dae", "<emission><color>1 1 1 1</color></emission>"}}) {
    testing::internal::CaptureStderr();
    const Material material = read(name, replaced(texturedDae(), image, other)).parts.at(0).fileMaterial;
    EXPECT_THAT(testing::internal::GetCapturedStderr(),
                HasSubstr(std::string(name) + ": left out: 1 materials without a plain diffuse colour\n"));
    EXPECT_EQ(material.reflectance, Material().reflectance);
    EXPECT_THAT(material.source, HasSubstr("has no colour"));
  }
  const std::string grey = "<diffuse><color>0.5 0.5 0.5 1</color></diffuse>";
  EXPECT_EQ(read("a.dae", replaced(texturedDae(), image, grey)).parts.at(0).fileMaterial.reflectance, 0.5f);
}

TEST_F(AssetFiles, ImagesOfColladaThatAreClampedAreCounted) {
  writeColours(folder_.path() / "colours.png");
  AssetPart part;
  std::string sampler, name = "a.dae";  // a warning is printed once, so that each needs a name of its own
  const auto warnings = [&](const std::string& extra, const std::string& uvs) {
    std::string text = replaced(replaced(replaced(texturedDae(), "holes.png", "colours.png"), R"(texcoord="UV"/>)",
                                         R"(texcoord="UV">)" + extra + "</texture>"),
                                "0.1 0.1 0.4 0.1 0.1 0.4", uvs);
    text = replaced(text, "<source>s</source>", "<source>s</source>" + sampler);
    testing::internal::CaptureStderr();
    part = read(name, text).parts.at(0);
    return testing::internal::GetCapturedStderr();
  };
  const auto extra = [](const std::string& keys) {
    return R"(<extra><technique profile="MAYA">)" + keys + "</technique></extra>";
  };
  const std::string clamped = extra("<wrapU>0</wrapU><wrapV>0</wrapV>");
  EXPECT_THAT(warnings(clamped, "0 0 2 0 0 2"), HasSubstr("left out: 1 clamped or mirrored textures (they repeat)\n"));
  EXPECT_EQ(warnings(clamped, "0 0 1 0 0 1"), "");
  EXPECT_EQ(warnings(extra("<wrapU>1</wrapU><wrapV>1</wrapV>"), "0 0 2 0 0 2"), "");
  EXPECT_EQ(warnings(extra("<repeatU>3</repeatU><repeatV>3</repeatV>"), "0 0 1 0 0 1"), "");
  EXPECT_EQ(part.uvs.at(1).x, 3);
  EXPECT_THAT(warnings(extra("<rotateUV>90</rotateUV>"), "0 0 1 0 0 1"),
              HasSubstr("left out: 1 rotations of images (rotateUV)\n"));
  EXPECT_EQ(part.uvs.at(1).x, 1);
  for (const std::string mode : {"WRAP", "BORDER", "MIRROR"}) {
    sampler = "<wrap_s> " + mode + " </wrap_s>";
    name = mode + ".dae";
    EXPECT_EQ(warnings("", "0 0 2 0 0 2").find("left out: 1 clamped or mirrored") != std::string::npos, mode != "WRAP");
    EXPECT_EQ(warnings("", "0 0 1 0 0 1"), "");
  }
}

TEST_F(AssetFiles, OpacitiesThatNoImageShowsAreCounted) {
  const auto warnings = [&](const std::string& mtl) {
    write("a.mtl", "newmtl paint\nKd 0.5 0.5 0.5\n" + mtl);
    return printedBy([&] { read("pane.obj", kObj); });
  };
  EXPECT_EQ(warnings("d 1\n"), "");
  EXPECT_THAT(warnings("d 0.5\n"), HasSubstr("pane.obj: left out: 1 opacities of materials (they are solid)\n"));
}

TEST_F(AssetFiles, NamesOfImagesMayStandInQuotationMarks) {
  writeColours(folder_.path() / "my leaf.png");
  write("a.mtl", "newmtl paint\nmap_Kd \"my leaf.png\"\n");
  const auto textured = [&] { return read("a.obj", kObj).parts.at(0).fileMaterial.texture; };
  ASSERT_NE(textured(), nullptr);
  EXPECT_THAT(textured()->file, HasSubstr("/my leaf.png"));
  std::filesystem::copy_file(folder_.path() / "my leaf.png", folder_.path() / "\"my leaf.png\"");
  EXPECT_THAT(textured()->file, HasSubstr("\"my leaf.png\"")) << "the literal name goes first";
}

// Such a map means the alpha of the image. Its brightness would cut holes into dark walls.
TEST_F(AssetFiles, OpacityMapsThatAreTheImageOfTheColourNeedAlpha) {
  writeColours(folder_.path() / "colours.png");
  write("a.mtl", std::string(kMtl) + "map_d colours.png\n");
  EXPECT_THAT(printedBy([&] { EXPECT_FALSE(read("a.obj", kObj).parts.at(0).fileMaterial.alphaTested); }),
              HasSubstr("left out: 1 opacity maps that are the image of the colour too, and have no alpha\n"));
}

TEST_F(AssetFiles, ScenesOverrideTheUpAxisAndTheAlpha) {
  writeColours(folder_.path() / "holes.png", 0);
  write("a.mtl", "newmtl paint\nKd 0.5 0.5 0.5\nmap_Kd holes.png\n");
  write("leaves.obj", squares(10, 0, 0));
  write("z.dae", dae("Z_UP", "1"));
  const auto scene = [&](const std::string& object) {
    return sceneOf(folder_, "objects:\n  - {" + object + "class: tree}\n");
  };
  const auto tested = [&](const std::string& alpha) {
    const Scene s = scene("file: leaves.obj, " + alpha);
    return std::any_of(s.materials.begin(), s.materials.end(), [](const Material& m) { return m.alphaTested; });
  };
  EXPECT_TRUE(tested(""));
  EXPECT_TRUE(tested("alpha: auto, "));
  EXPECT_TRUE(tested("alpha: test, "));
  EXPECT_FALSE(tested("alpha: ignore, "));
  EXPECT_THROW(tested("alpha: perhaps, "), InputError);
  EXPECT_EQ(scene("file: z.dae, ").bounds().low, (Vec3d{10, 20, 30}));
  EXPECT_EQ(scene("file: z.dae, up: z, ").bounds().low, (Vec3d{10, 20, 30}));
  EXPECT_EQ(scene("file: z.dae, up: y, ").bounds().low, (Vec3d{10, -33, 20}));
}

TEST_F(AssetFiles, TexturesAreFoundWherePeoplePutThem) {
  const auto asset = folder_.path() / "car" / "meshes" / "car.dae";
  const auto expectFound = [&](const std::string& file, const std::string& name) {
    write(file, "image");
    const auto found = findTexture(asset, name, false);
    std::error_code error;
    EXPECT_TRUE(!found.empty() && std::filesystem::equivalent(found, folder_.path() / file, error)) << name;
    std::filesystem::remove(folder_.path() / file);
  };
  std::filesystem::create_directories(asset.parent_path());
  expectFound("car/meshes/a.png", "a.png");
  expectFound("car/meshes/a b.png", "a%20b.png");
  expectFound("car/meshes/a.png", "C:\\Users\\me\\a.png");
  expectFound("car/meshes/a.png", "../elsewhere/a.png");
  expectFound("car/meshes/textures/a.png", "a.png");
  expectFound("car/materials/textures/a.png", "a.png");
  expectFound("wheels/materials/textures/a.png", "model://wheels/materials/textures/a.png");
  expectFound("car/meshes/A.PNG", "a.png");
  EXPECT_TRUE(findTexture(asset, "a.png", false).empty());
  write("store/A.png", "image");
  EXPECT_TRUE(std::filesystem::equivalent(findTexture(asset, "x/a.png", false, {folder_.path() / "store"}),
                                          folder_.path() / "store/A.png"));
  EXPECT_TRUE(findTexture(asset, "", false).empty());
}

// A name that leads out of the folder is found where textures usually lie; elsewhere it has to be allowed.
TEST_F(AssetFiles, TexturesElsewhereHaveToBeAllowed) {
  const auto asset = folder_.path() / "car" / "meshes" / "car.dae";
  std::filesystem::create_directories(asset.parent_path());
  const auto absolute = write("abs.png", "image");
  write("car/textures/b.png", "image");
  for (const std::string& name :
       {absolute.string(), std::string("../../abs.png"), std::string("../meshes/../../abs.png"),
        std::string("..%2F..%2Fabs.png"), std::string("model://../../abs.png"), "file://" + absolute.string()}) {
    EXPECT_THAT(messageOf<InputError>([&] { findTexture(asset, name, false); }),
                AllOf(HasSubstr("car.dae: names '" + name), HasSubstr("allow_outside: true")));
    EXPECT_TRUE(std::filesystem::equivalent(findTexture(asset, name, true), absolute)) << name;
  }
  EXPECT_TRUE(std::filesystem::equivalent(findTexture(asset, "../textures/b.png", false),
                                          folder_.path() / "car/textures/b.png"));
}

TEST(AssetMaterials, MissingTexturesAreToldInOneLine) {
  const TemporaryFolder folder;
  std::string library;
  std::string object = "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\n";
  for (int i = 0; i < 10; ++i) {
    library += fmt::format("newmtl m{0}\nKd 0.5 0.5 0.5\nmap_Kd gone{0}.jpg\n", i);
    object += fmt::format("usemtl m{}\nf 1/1 2/2 3/3\n", i);
  }
  folder.write("a.mtl", library);
  const auto file = folder.write("a.obj", object);
  Asset asset;
  const std::string shown = printedBy([&] { asset = readAsset(file, {}); });
  EXPECT_NEAR(asset.parts.at(0).fileMaterial.reflectance, 0.5, 1e-6);
  EXPECT_FALSE(asset.parts[0].fileMaterial.textured);
  EXPECT_EQ(asset.parts[0].texture, "gone0.jpg");
  EXPECT_EQ(std::count(shown.begin(), shown.end(), '\n'), 1) << shown;
  EXPECT_THAT(shown, testing::HasSubstr("a.obj: missing textures: 'gone0.jpg', 'gone1.jpg'"));
  EXPECT_THAT(shown, testing::HasSubstr("'gone7.jpg' and 2 more; plain colours replace them, "));
}

}  // namespace
}  // namespace scanmill
