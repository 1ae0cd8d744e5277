// Damaged files of every kind that the program reads, and files that ask for attention: it refuses them by name and
// never crashes. The readers' own tests and the fuzzer try more.

#include <random>

#include "base/file.h"
#include "dataset/shard_writer.h"
#include "tests/commands/program.h"

namespace scanmill {
namespace {

using testing::AllOf;
using testing::HasSubstr;

class BadInput : public SmallWorld {};

// Each file is removed, emptied, replaced by noise and cut, one at a time; then the command is run.
TEST_F(BadInput, DamagedFilesAreRefusedByName) {
  std::mt19937 engine(5);
  std::string noise(3000, '\0');
  for (char& c : noise) c = static_cast<char>(engine());
  const float corners[9] = {9, 0, 0, 9, 4, 0, 9, 0, 4};
  const std::int32_t face[3] = {0, 1, 2};
  folder_.write("body.ply",
                "ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
                "property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n" +
                    std::string(reinterpret_cast<const char*>(corners), sizeof corners) + "\3" +
                    std::string(reinterpret_cast<const char*>(face), sizeof face));
  const std::string scene = readFile(at("scene.yaml"));
  folder_.write("scene.yaml", scene + "  - {file: body.ply, class: car, material: brick}\n");
  ASSERT_EQ(scanmill({"generate", pipeline_, "-q", "-o", at("out")}).code, 0);
  ASSERT_EQ(RunningProgram({"tar", "-xf", at("out/train/train-000000.tar"), "-C", at(".")}).wait().code, 0);
  const std::string scan = "scene-s1-drive-000001.top.ray_tracing.";
  const std::vector<std::string> make{"generate", pipeline_, "-q", "-o", at("x")};
  struct Case {
    std::string file;
    std::vector<std::string> command;
    int code = 2;
  };
  const std::vector<Case> cases{{"small.yaml", make},
                                {"scene.yaml", make},
                                {"body.ply", make},
                                {scan + "pcd", {"info", at(scan + "pcd")}},
                                {scan + "drc", {"info", at(scan + "drc")}},
                                {"out/train/train-000000.tar", {"info", at("out/train/train-000000.tar")}},
                                {"out/train/train-000000.tar", {"verify", at("out")}, 1},
                                {"out/manifest.json", {"verify", at("out")}}};
  for (const Case& one : cases) {
    const std::string whole = readFile(at(one.file));
    const std::string name = std::filesystem::path(one.file).filename().string();
    for (const std::string& damaged : {std::string(), std::string("\n"), noise, whole.substr(0, whole.size() / 2)}) {
      SCOPED_TRACE(one.file + ", " + std::to_string(damaged.size()) + " bytes");
      std::filesystem::remove(at(one.file));
      if (!damaged.empty()) folder_.write(one.file, damaged);
      const Outcome o = scanmill(one.command);
      EXPECT_EQ(o.code, one.code) << o.signal << o.error;
      EXPECT_THAT(o.error, HasSubstr(one.file.ends_with(".yaml") ? ".yaml" : name));
      EXPECT_FALSE(std::filesystem::exists(at("x")));
    }
    folder_.write(one.file, whole);
  }
}

TEST_F(BadInput, InstructionSets) {
  expectRefused(scanmill({"generate", pipeline_, "-q", "-o", at("out")}, {"SCANMILL_ISA=avx3"}), "sse4.2, avx, avx2");
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
