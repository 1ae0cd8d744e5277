// Missing, empty, truncated and garbage files of every kind that the program reads: it refuses them by name, or does
// without them, and never crashes.

#include <fmt/core.h>

#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <memory>
#include <random>

#include "base/file.h"
#include "dataset/shard.h"
#include "tests/commands/program.h"

namespace scanmill {
namespace {

using testing::AllOf;
using testing::AnyOf;
using testing::HasSubstr;

std::string garbage(std::size_t size) {
  std::mt19937 engine(5);
  std::string bytes(size, '\0');
  for (char& c : bytes) c = static_cast<char>(engine());
  return bytes;
}

template <class T>
std::string raw(std::initializer_list<T> values) {
  std::string bytes(values.size() * sizeof(T), '\0');
  std::memcpy(bytes.data(), values.begin(), bytes.size());
  return bytes;
}

constexpr const char* kOntology = R"(name: tiny
source: a test
classes:
  - {id: 0, name: unlabeled, color: [0, 0, 0]}
  - {id: 1, name: ground, color: [90, 80, 70]}
  - {id: 2, name: car, color: [0, 0, 255], thing: true}
)";

// A job and its files: what a run reads, by name. One of them is damaged at a time.
struct Damage {
  std::string name;
  std::string file;
  std::function<std::string(const std::string&)> change;  // null: the file is removed
  bool mayWork = false;                                   // what is left may still make sense
};

// `text`: a part of the file may still make sense.
std::vector<Damage> damagesOf(const std::string& file, bool text) {
  std::vector<Damage> damages{
      {"missing", file, {}, false},
      {"empty", file, [](const std::string&) { return std::string(); }, false},
      {"garbage", file, [](const std::string&) { return garbage(3000); }, false},
  };
  if (!text) damages.push_back({"zeros", file, [](const std::string&) { return std::string(500, '\0'); }, false});
  for (const double share : {0.25, 0.5, 0.85}) {
    const auto cut = [share](const std::string& s) {
      return s.substr(0, static_cast<std::size_t>(share * static_cast<double>(s.size())));
    };
    damages.push_back({fmt::format("cut at {}", share), file, cut, text});
  }
  return damages;
}

class BadInput : public SmallWorld {
 protected:
  // Runs a program in a copy of this test's folder for each damage, some at a time, and hands each outcome to `judge`.
  void tryAll(const std::vector<Damage>& damages, const std::vector<std::string>& arguments,
              const std::function<void(const Damage&, const Outcome&, const std::filesystem::path&)>& judge) const {
    constexpr std::size_t kAtATime = 4;
    for (std::size_t first = 0; first < damages.size(); first += kAtATime) {
      struct Run {
        TemporaryFolder folder;
        std::unique_ptr<RunningProgram> process;
      };
      std::vector<Run> runs(std::min(kAtATime, damages.size() - first));
      for (std::size_t i = 0; i < runs.size(); ++i) {
        const Damage& damage = damages[first + i];
        const std::filesystem::path& folder = runs[i].folder.path();
        std::filesystem::copy(folder_.path(), folder, std::filesystem::copy_options::recursive);
        if (damage.change) {
          runs[i].folder.write(damage.file, damage.change(readFile(folder / damage.file)));
        } else {
          std::filesystem::remove_all(folder / damage.file);
        }
        std::vector<std::string> command{testedProgram()};
        for (std::string a : arguments) {
          const std::size_t at = a.find("@");
          command.push_back(at == std::string::npos ? a : a.replace(at, 1, folder.string() + "/"));
        }
        runs[i].process = std::make_unique<RunningProgram>(command);
      }
      for (std::size_t i = 0; i < runs.size(); ++i) {
        const Damage& damage = damages[first + i];
        SCOPED_TRACE(damage.file + " " + damage.name);
        judge(damage, runs[i].process->wait(), runs[i].folder.path());
      }
    }
  }

  // Files that `generate` reads: refused with exit code 2 and the file's name, and nothing is written.
  void tryGenerate(const std::vector<Damage>& damages) const {
    tryAll(damages, {"generate", "@small.yaml", "-q", "-o", "@out"},
           [](const Damage& damage, const Outcome& o, const std::filesystem::path& folder) {
             if (damage.mayWork && o.code == 0) return;
             const std::string name = std::filesystem::path(damage.file).filename().string();
             // A list that was cut short is found where somebody names what it lacks.
             expectRefused(o, damage.mayWork ? ".yaml" : name);
             EXPECT_EQ(filesEndingIn("", folder / "out").size(), 0u);
           });
  }

  // A scene with one asset, and its other files.
  void writeAsset(const std::string& name, const std::string& bytes) const {
    folder_.write(name, bytes);
    folder_.write("scene.yaml", fmt::format("ontology: {0}/labels/scanmill.yaml\nmaterials: {0}/labels/materials.yaml\n"
                                            "objects:\n"
                                            "  - {{primitive: plane, size: [9, 9], class: ground, material: asphalt}}\n"
                                            "  - {{file: {1}, class: car}}\n",
                                            SCANMILL_SOURCE_DIR, name));
  }
};

TEST_F(BadInput, Yaml) {
  folder_.write("ontology.yaml", kOntology);
  folder_.write("paints.yaml", readFile(SCANMILL_SOURCE_DIR "/labels/materials.yaml"));
  folder_.write("sensor.yaml", "model: tiny\ncolumns: 64\nrate_hz: 10\nelevation_deg: [5, 0, -5]\nrange_m: [1, 50]\n");
  folder_.write("scene.yaml",
                "ontology: ontology.yaml\nmaterials: paints.yaml\nobjects:\n"
                "  - {name: floor, primitive: plane, size: [100, 100], class: ground, material: concrete}\n"
                "  - {name: car, primitive: box, size: [4, 2, 2], class: car, material: painted_metal}\n");
  folder_.write("small.yaml",
                "scenes: [{scene: scene.yaml}]\ntrajectories: [{poses: [{position: [9, 0, 2]}]}]\n"
                "sensors: [{preset: sensor.yaml}]\nmethod: ray_tracing\neffects: [intensity]\n"
                "output: {formats: [pcd]}\n");
  EXPECT_EQ(scanmill({"generate", at("small.yaml"), "-q", "-o", at("whole")}).code, 0);
  std::filesystem::remove_all(at("whole"));
  for (const std::string file : {"small.yaml", "scene.yaml", "ontology.yaml", "paints.yaml", "sensor.yaml"}) {
    std::vector<Damage> damages = damagesOf(file, true);
    damages.push_back({"list", file, [](const std::string&) { return std::string("[1, 2]\n"); }, false});
    damages.push_back({"unknown key", file, [](const std::string& s) { return s + "zzz: 1\n"; }, false});
    tryGenerate(damages);
  }
  // All are read by the same parser.
  const std::string file = "scene.yaml";
  tryGenerate({{"cycle", file, [](const std::string& s) { return s + "loop: &a [*a]\n"; }, false},
               {"duplicate key", file, [](const std::string& s) { return s + s; }, false},
               {"text", file, [](const std::string&) { return std::string("just words\n"); }, false},
               {"deep", file, [](const std::string&) { return std::string(100000, '['); }, false},
               {"bomb", file,
                [](const std::string& s) {
                  std::string bomb = s + "a0: &a0 [x, x, x, x, x, x, x, x, x, x]\n";
                  for (int i = 1; i < 9; ++i) {
                    bomb +=
                        fmt::format("a{0}: &a{0} [*a{1}, *a{1}, *a{1}, *a{1}, *a{1}, *a{1}, *a{1}, *a{1}]\n", i, i - 1);
                  }
                  return bomb;
                },
                false}});
}

struct AssetFile {
  std::string name;
  std::string bytes;
  bool text;
};

std::string binaryStl() {
  std::string stl(80, ' ');
  stl += raw<std::uint32_t>({4});
  for (int i = 0; i < 4; ++i) {
    const auto f = static_cast<float>(i);
    stl += raw<float>({0, 0, 1, f, 0, 0, f, 1, 0, f, 0, 1}) + std::string(2, '\0');
  }
  return stl;
}

std::string binaryPly() {
  return "ply\nformat binary_little_endian 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float "
         "z\n"
         "element face 2\nproperty list uchar int vertex_indices\nend_header\n" +
         raw<float>({0, 0, 0, 1, 0, 0, 1, 0, 1, 0, 0, 1}) + "\3" + raw<std::int32_t>({0, 1, 2}) + "\3" +
         raw<std::int32_t>({0, 2, 3});
}

// Positions of a triangle, then its indices.
std::string gltfBuffer() {
  return raw<float>({0, 0, 0, 1, 0, 0, 0, 1, 0}) + raw<std::uint32_t>({0, 1, 2});
}

std::string gltfJson(const std::string& uri) {
  return R"({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0, "name": "n"}],
 "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
 "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0]},
               {"bufferView": 1, "componentType": 5125, "count": 3, "type": "SCALAR"}],
 "bufferViews": [{"buffer": 0, "byteOffset": 0, "byteLength": 36}, {"buffer": 0, "byteOffset": 36, "byteLength": 12}],
 "buffers": [{"byteLength": 48)" +
         (uri.empty() ? "" : ", \"uri\": \"" + uri + "\"") + "}]}";
}

std::string glb() {
  std::string json = gltfJson("");
  json.resize((json.size() + 3) / 4 * 4, ' ');
  const std::string buffer = gltfBuffer();
  const auto size = [](std::size_t bytes) { return raw<std::uint32_t>({static_cast<std::uint32_t>(bytes)}); };
  return "glTF" + raw<std::uint32_t>({2}) + size(12 + 8 + json.size() + 8 + buffer.size()) + size(json.size()) +
         "JSON" + json + size(buffer.size()) + std::string("BIN\0", 4) + buffer;
}

constexpr const char* kObj = "o body\nv 0 0 0\nv 1 0 0\nv 1 0 1\nv 0 0 1\nf 1 2 3\nf 1 3 4\n";

constexpr const char* kDae = R"(<?xml version="1.0"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><unit name="metre" meter="1"/><up_axis>Z_UP</up_axis></asset>
<library_geometries><geometry id="g"><mesh>
<source id="p"><float_array id="pa" count="9">1 0 0 0 2 0 0 0 3</float_array><technique_common>
<accessor source="#pa" count="3" stride="3"><param name="X" type="float"/><param name="Y" type="float"/><param name="Z" type="float"/></accessor>
</technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<triangles count="1"><input semantic="VERTEX" source="#v" offset="0"/><p>0 1 2</p></triangles>
</mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="s"><node id="n"><instance_geometry url="#g"/></node></visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#s"/></scene>
</COLLADA>
)";

class BadAsset : public BadInput, public testing::WithParamInterface<AssetFile> {};

TEST_P(BadAsset, IsRefusedByName) {
  const AssetFile& asset = GetParam();
  writeAsset(asset.name, asset.bytes);
  folder_.write("body.bin", gltfBuffer());
  const Outcome whole = scanmill({"generate", pipeline_, "-q", "-o", at("whole")});
  ASSERT_EQ(whole.code, 0) << whole.error;
  EXPECT_EQ(whole.error, "");
  std::filesystem::remove_all(at("whole"));
  tryGenerate(damagesOf(asset.name, asset.text));
}

INSTANTIATE_TEST_SUITE_P(Kinds, BadAsset,
                         testing::Values(AssetFile{"body.obj", kObj, true}, AssetFile{"body.ply", binaryPly(), false},
                                         AssetFile{"body.stl", binaryStl(), false},
                                         AssetFile{"body.gltf", gltfJson("body.bin"), false},
                                         AssetFile{"body.glb", glb(), false}, AssetFile{"body.dae", kDae, true}),
                         [](const auto& test) { return test.param.name.substr(5); });

TEST_F(BadInput, InstructionSets) {
  expectRefused(scanmill({"generate", pipeline_, "-q", "-o", at("out")}, {"SCANMILL_ISA=avx3"}), "sse4.2, avx, avx2");
}

TEST_F(BadInput, BuffersOfGltf) {
  writeAsset("body.gltf", gltfJson("body.bin"));
  folder_.write("body.bin", gltfBuffer());
  tryAll(damagesOf("body.bin", true), {"generate", "@small.yaml", "-q", "-o", "@out"},
         [](const Damage& damage, const Outcome& o, const std::filesystem::path&) {
           // Any bytes are a buffer, if there are enough.
           if (o.code == 0) {
             EXPECT_THAT(damage.name, AnyOf("garbage", "zeros"));
           } else {
             expectRefused(o, "body.");
           }
         });
}

// A picture costs its material's pattern, not the dataset; the warning names it.
TEST_F(BadInput, Textures) {
  std::string bmp = "BM" + raw<std::uint32_t>({54 + 192, 0, 54, 40}) + raw<std::int32_t>({8, 8}) +
                    raw<std::uint16_t>({1, 24}) + raw<std::uint32_t>({0, 192, 2835, 2835, 0, 0}) + garbage(192);
  folder_.write("paint.bmp", bmp);
  folder_.write("body.mtl", "newmtl paint\nKd 0.5 0.5 0.5\nmap_Kd paint.bmp\n");
  writeAsset("body.obj",
             "mtllib body.mtl\nv 9 -9 0\nv 9 9 0\nv 9 9 9\nvt 0 0\nvt 1 0\nvt 1 1\nusemtl paint\nf 1/1 2/2 3/3\n");
  const Outcome whole = scanmill({"generate", pipeline_, "-q", "-o", at("whole")});
  EXPECT_EQ(whole.code, 0);
  EXPECT_EQ(whole.error, "");
  tryAll(damagesOf("paint.bmp", false), {"generate", "@small.yaml", "-q", "-o", "@out"},
         [](const Damage&, const Outcome& o, const std::filesystem::path& folder) {
           EXPECT_EQ(o.code, 0) << o.error;
           EXPECT_THAT(o.error, AllOf(HasSubstr("warning"), HasSubstr("paint.bmp")));
           EXPECT_EQ(o.error.find("warning"), o.error.rfind("warning")) << o.error;
           EXPECT_TRUE(std::filesystem::exists(folder / "out/manifest.json"));
         });
}

TEST_F(BadInput, Datasets) {
  ASSERT_EQ(scanmill({"generate", pipeline_, "-q", "-o", at("out")}).code, 0);
  const std::string shard = "out/train/train-000000.tar";
  tryAll(damagesOf("out/manifest.json", false), {"verify", "@out"},
         [](const Damage&, const Outcome& o, const std::filesystem::path&) { expectRefused(o, "manifest.json"); });
  tryAll(damagesOf(shard, false), {"verify", "@out"},
         [](const Damage&, const Outcome& o, const std::filesystem::path&) {
           EXPECT_EQ(o.code, 1) << o.signal;
           EXPECT_THAT(o.error, HasSubstr("train/train-000000.tar"));
           EXPECT_THAT(o.out, HasSubstr("problem"));
         });
  tryAll(damagesOf(shard, false), {"info", "@" + shard},
         [](const Damage&, const Outcome& o, const std::filesystem::path&) { expectRefused(o, "train-000000.tar"); });
}

TEST_F(BadInput, Scans) {
  ASSERT_EQ(scanmill({"generate", pipeline_, "-q", "-o", at("out")}).code, 0);
  ASSERT_EQ(RunningProgram({"tar", "-xf", at("out/train/train-000000.tar"), "-C", at(".")}).wait().code, 0);
  std::filesystem::remove_all(at("out"));
  for (const std::string suffix : {"pcd", "drc", "csv"}) {
    const std::string name = "scene-s1-drive-000001.top.ray_tracing." + suffix;
    ASSERT_EQ(scanmill({"info", at(name)}).code, 0);
    tryAll(damagesOf(name, suffix == "csv"), {"info", "@" + name},
           [&](const Damage& damage, const Outcome& o, const std::filesystem::path&) {
             if (!damage.mayWork || o.code != 0) expectRefused(o, name);
           });
  }
}

TEST_F(BadInput, BrokenTrianglesAreDroppedAndCounted) {
  writeAsset("body.ply",
             "ply\nformat ascii 1.0\nelement vertex 5\nproperty float x\nproperty float y\nproperty float z\n"
             "element face 5\nproperty list uchar int vertex_indices\nend_header\n"
             "0 0 0\n1 0 0\n1 0 1\nnan 0 0\n0 inf 1\n3 0 1 2\n3 0 1 3\n3 0 1 4\n3 0 0 1\n3 0 1 99\n");
  const Outcome info = scanmill({"info", at("scene.yaml")});
  EXPECT_EQ(info.code, 0) << info.error;
  EXPECT_THAT(
      info.out,
      HasSubstr("triangles left out: 1 without area, 2 with NaN or infinite corners, 1 with indices out of range"));
  EXPECT_EQ(scanmill({"generate", pipeline_, "-q", "-o", at("out")}).code, 0);
  EXPECT_EQ(scanmill({"verify", "-q", at("out")}).code, 0);
}

TEST_F(BadInput, SingularTransformsAreRefusedWithTheirPlace) {
  writeAsset("body.obj", kObj);
  const std::string scene = readFile(at("scene.yaml"));
  for (const std::string scale : {"0", "[1, 0, 1]", ".nan", "1e300", "[1, 1]"}) {
    std::string text = scene;
    text.replace(text.find("class: car}"), 11, "class: car, scale: " + scale + "}");
    folder_.write("scene.yaml", text);
    expectRefused(scanmill({"generate", pipeline_, "-q", "-o", at("out")}), "scene.yaml:5:");
    EXPECT_FALSE(std::filesystem::exists(at("out")));
  }
}

// Names in files may hold what terminals take for commands, and lines that look like ours.
TEST_F(BadInput, WhatNamesHoldIsWrittenOut) {
  const std::string evil = "a\x1b[2J\x1b]0;owned\x07\xc2\x9b";
  const std::string forged = "b\nerror: all is lost";
  folder_.write("evil.obj", "o " + evil + "\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  folder_.write("evil.csv", "x,y,z," + evil + "\n1,2,3,4\n");
  folder_.write("evil.yaml", "\"" + evil + "\": 1\n");
  folder_.write("named.yaml", "ontology: " + evil + "\n");
  {
    ShardFile shard(folder_.path(), folder_.path() / "evil.tar");
    shard.add("a\x1b[2J.json", "{}");
    shard.add(forged + ".pcd", "no points");
    shard.close();
  }
  ASSERT_EQ(scanmill({"generate", pipeline_, "-q", "-o", at("out")}).code, 0);
  std::string manifest = readFile(at("out/manifest.json"));
  manifest.replace(manifest.find("\"small\""), 7, R"("a\u001b[2J\nerror: all is lost")");
  folder_.write("out/manifest.json", manifest);
  for (const std::vector<std::string>& command : {std::vector<std::string>{"info", at("evil.obj")},
                                                  {"info", at("evil.csv")},
                                                  {"info", at("evil.yaml")},
                                                  {"info", at("named.yaml")},
                                                  {"info", at("evil.tar")},
                                                  {"info", at("out")},
                                                  {"verify", at("out")},
                                                  {"plan", at("evil.yaml"), "--check"},
                                                  {"info", at(evil)},
                                                  {"generate", pipeline_, "-o", at("x"), "--set", evil + "=1"}}) {
    const Outcome outcome = scanmill(command);
    for (const std::string& text : {outcome.out, outcome.error}) {
      EXPECT_EQ(text.find('\x1b'), std::string::npos) << command[0] << " " << command[1];
      EXPECT_EQ(text.find('\x07'), std::string::npos) << command[0] << " " << command[1];
      EXPECT_EQ(text.find("\xc2\x9b"), std::string::npos) << command[0] << " " << command[1];
      EXPECT_EQ(text.find("\nerror: all"), std::string::npos) << command[0] << " " << command[1];
    }
  }
}

// Messages of libraries, which are for programmers, are put into words for users.
TEST_F(BadInput, NoLibrarysWordsReachTheUser) {
  folder_.write("a.gltf", R"({"asset": {"version": "2.0"}, "nodes": [{"name": 1}], "scenes": [{"nodes": [0]}]})");
  folder_.write("b.gltf", "{");
  folder_.write("tileset.json", R"({"asset": {"version": 1}, "root": {}})");
  folder_.write("lidar.json", "[1");
  for (const char* const name : {"a.gltf", "b.gltf", "tileset.json", "lidar.json"}) {
    const Outcome o = scanmill({"info", at(name)});
    EXPECT_EQ(o.code, 2) << name;
    EXPECT_THAT(o.error, AllOf(HasSubstr(name), testing::Not(HasSubstr("exception")))) << name;
  }
  if (std::getenv("SCANMILL_TESTED_PROGRAM") != nullptr) return;  // sanitizers need more addresses than this
  std::filesystem::resize_file(folder_.write("large.pcd", ""), std::uintmax_t{390} << 20);
  const Outcome o =
      RunningProgram({"sh", "-c", "ulimit -v 400000; exec \"$0\" info \"$1\"", testedProgram(), at("large.pcd")})
          .wait();
  EXPECT_EQ(o.code, 1);
  EXPECT_THAT(o.error, AllOf(HasSubstr("scanmill info: the memory ran out, of which 390.6 MiB are allowed"),
                             HasSubstr("--threads"), HasSubstr("ulimit -v")));
}

}  // namespace
}  // namespace scanmill
