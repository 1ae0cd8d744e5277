// Small files that ask for any amount of files, copies, memory or time: each is refused by name, by all commands that
// read it, before it costs more than its budget (docs/reliability.md).

#include <fmt/format.h>
#include <zlib.h>

#include "base/file.h"
#include "tests/commands/program.h"

namespace scanmill {
namespace {

// A file below 10 MB may take 2 GiB and 64 times its size, and the program as much again while it turns one form of the
// data into another.
constexpr long kMostBytes = 5'500'000'000;

class InputLimits : public testing::Test {
 protected:
  std::string write(const std::string& name, const std::string& bytes) const {
    const std::filesystem::path file = folder_.path() / name;
    std::filesystem::create_directories(file.parent_path());
    writeFile(file, bytes);
    return file.string();
  }

  // Expects that `info`, `draft` and a scene with the file refuse it with a message that holds `text`.
  void expectRefusedByAll(const std::string& file, const std::string& text) const {
    const std::string scene =
        write("scene.yaml",
              fmt::format("ontology: scanmill\nmaterials: materials\nobjects:\n  - {{file: {}, class: road}}\n", file));
    const std::vector<std::vector<std::string>> commands{
        {"info", file}, {"draft", file, "-o", (folder_.path() / "drafted.yaml").string()}, {"info", scene}};
    for (const std::vector<std::string>& command : commands) {
      SCOPED_TRACE(command[0] + " " + command[1]);
      const Outcome outcome = scanmill(command);
      expectRefused(outcome, text);
      EXPECT_LT(outcome.peakBytes, kMostBytes);
    }
  }

  TemporaryFolder folder_;
};

std::string bigEndian(std::size_t value) {
  std::string bytes(4, '\0');
  for (int i = 0; i < 4; ++i) bytes[static_cast<std::size_t>(i)] = static_cast<char>(value >> (24 - 8 * i));
  return bytes;
}

std::string chunk(const std::string& kind, const std::string& bytes) {
  const std::string checked = kind + bytes;
  const auto sum = crc32(0, reinterpret_cast<const Bytef*>(checked.data()), static_cast<uInt>(checked.size()));
  return bigEndian(bytes.size()) + checked + bigEndian(sum);
}

// The rows of a black square of `side` pixels of one bit, compressed.
std::string blackRows(std::size_t side) {
  const std::string rows((side / 8 + 1) * side, '\0');
  std::string packed(compressBound(rows.size()), '\0');
  uLongf size = packed.size();
  compress2(reinterpret_cast<Bytef*>(packed.data()), &size, reinterpret_cast<const Bytef*>(rows.data()), rows.size(),
            9);
  packed.resize(size);
  return packed;
}

// An image of such rows, and a text, so that no two images are the same.
std::string largePng(std::size_t side, const std::string& packed, const std::string& text) {
  const std::string head = bigEndian(side) + bigEndian(side) + std::string("\1\0\0\0\0", 5);
  return "\x89PNG\r\n\x1a\n" + chunk("IHDR", head) + chunk("tEXt", "k" + std::string(1, '\0') + text) +
         chunk("IDAT", packed) + chunk("IEND", "");
}

std::string tileset(const std::string& children) {
  return fmt::format(
      R"({{"asset":{{"version":"1.0"}},"geometricError":1,"root":{{"boundingVolume":{{"sphere":[0,0,0,1]}},)"
      R"("geometricError":1,"refine":"ADD","children":[{}]}}}})",
      children);
}

std::string tile(const std::string& uri) {
  return fmt::format(R"({{"boundingVolume":{{"sphere":[0,0,0,1]}},"geometricError":0,"content":{{"uri":"{}"}}}})", uri);
}

// A glTF file of one strip of so many triangles, in binary data beside it.
void writeStrip(const std::filesystem::path& folder, std::size_t triangles) {
  std::string bin;
  for (std::size_t i = 0; i < triangles + 2; ++i) {
    const float point[3] = {static_cast<float>(i), static_cast<float>(i % 2), 0};
    bin.append(reinterpret_cast<const char*>(point), sizeof point);
  }
  writeFile(folder / "strip.bin", bin);
  writeFile(folder / "strip.gltf",
            fmt::format(R"({{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0]}}],"nodes":[{{"mesh":0}}],)"
                        R"("meshes":[{{"primitives":[{{"mode":5,"attributes":{{"POSITION":0}}}}]}}],)"
                        R"("accessors":[{{"bufferView":0,"componentType":5126,"count":{},"type":"VEC3",)"
                        R"("min":[0,0,0],"max":[{},1,0]}}],"bufferViews":[{{"buffer":0,"byteLength":{}}}],)"
                        R"("buffers":[{{"byteLength":{},"uri":"strip.bin"}}]}})",
                        triangles + 2, triangles + 1, bin.size(), bin.size()));
}

TEST_F(InputLimits, TilesetsThatEachNameTheNextTwice) {
  constexpr int kLevels = 30;
  writeStrip(folder_.path(), 4);
  for (int i = 0; i < kLevels; ++i) {
    const std::string next = tile(i + 1 < kLevels ? fmt::format("t{}.json", i + 1) : "strip.gltf");
    write(fmt::format("t{}.json", i), tileset(next + "," + next));
  }
  expectRefusedByAll((folder_.path() / "t0.json").string(), "is one file too many");
}

TEST_F(InputLimits, ATileFiftyThousandTimes) {
  writeStrip(folder_.path(), 2000);
  std::string tiles = tile("strip.gltf");
  for (int i = 1; i < 50'000; ++i) tiles += "," + tile("strip.gltf");
  expectRefusedByAll(write("tileset.json", tileset(tiles)), "unpacked and with all copies");
}

TEST_F(InputLimits, ModelsThatEachIncludeTheNextTenTimes) {
  constexpr int kLevels = 9;
  for (int i = 0; i < kLevels; ++i) {
    std::string inside =
        "<link name='l'><visual name='v'><geometry><box><size>1 1 1</size></box></geometry></visual></link>";
    if (i + 1 < kLevels) {
      inside.clear();
      for (int k = 0; k < 10; ++k) {
        inside += fmt::format("<include><uri>model://m{}</uri><name>n{}</name></include>", i + 1, k);
      }
    }
    write(fmt::format("m{}/model.sdf", i),
          fmt::format("<sdf version='1.6'><model name='m{}'>{}</model></sdf>", i, inside));
  }
  expectRefusedByAll((folder_.path() / "m0/model.sdf").string(), "unpacked and with all copies");
}

TEST_F(InputLimits, AWorldOfSpheres) {
  std::string models;
  for (int i = 0; i < 20'000; ++i) {
    models += fmt::format(
        "<model name='s{}'><pose>{} {} 0 0 0 0</pose><link name='l'><visual name='v'><geometry><sphere><radius>.4"
        "</radius></sphere></geometry></visual></link></model>",
        i, i % 200, i / 200);
  }
  expectRefusedByAll(write("spheres.sdf", "<sdf version='1.6'><world name='w'>" + models + "</world></sdf>"),
                     "unpacked and with all copies");
}

TEST_F(InputLimits, NodesThatAreEachCopiedTwice) {
  constexpr int kLevels = 26;
  std::string nodes;
  for (int i = 0; i < kLevels; ++i) {
    nodes += fmt::format("<node id='n{0}'><instance_node url='#n{1}'/><instance_node url='#n{1}'/></node>", i, i + 1);
  }
  const std::string file = write(
      "nested.dae",
      fmt::format("<COLLADA xmlns='http://www.collada.org/2005/11/COLLADASchema' version='1.4.1'><library_geometries>"
                  "<geometry id='g'><mesh><source id='p'><float_array id='a' count='9'>0 0 0 1 0 0 0 1 0</float_array>"
                  "<technique_common><accessor source='#a' count='3' stride='3'><param name='X' type='float'/>"
                  "<param name='Y' type='float'/><param name='Z' type='float'/></accessor></technique_common></source>"
                  "<vertices id='v'><input semantic='POSITION' source='#p'/></vertices><triangles count='1'>"
                  "<input semantic='VERTEX' source='#v' offset='0'/><p>0 1 2</p></triangles></mesh></geometry>"
                  "</library_geometries><library_nodes>{}<node id='n{}'><instance_geometry url='#g'/></node>"
                  "</library_nodes><library_visual_scenes><visual_scene id='s'><node id='r'>"
                  "<instance_node url='#n0'/></node></visual_scene></library_visual_scenes><scene>"
                  "<instance_visual_scene url='#s'/></scene></COLLADA>",
                  nodes, kLevels));
  expectRefusedByAll(file, "places more than 10000000");
}

TEST_F(InputLimits, SixtyLargeImagesOfAFewBytes) {
  std::string obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nmtllib images.mtl\n";
  std::string mtl;
  const std::string rows = blackRows(16384);
  for (int i = 0; i < 60; ++i) {
    write(fmt::format("{}.png", i), largePng(16384, rows, std::to_string(i)));
    mtl += fmt::format("newmtl m{0}\nmap_Kd {0}.png\n", i);
    obj += fmt::format("usemtl m{}\nf 1/1 2/1 3/1\n", i);
  }
  write("images.mtl", mtl);
  const std::string file = write("images.obj", obj);
  const Outcome outcome = scanmill({"info", file, "--colors"});
  expectRefused(outcome, "pixels");
  EXPECT_LT(outcome.peakBytes, kMostBytes);
}

TEST_F(InputLimits, AMapOfThreeThousandCrossingRoads) {
  std::string nodes;
  std::string ways;
  constexpr int kRoads = 3000;
  for (int i = 0; i < kRoads; ++i) {
    const double at = 0.018 * (i / 2) / (kRoads / 2);
    const bool east = i % 2 == 1;
    nodes += fmt::format("<node id='{}' lat='{:.6f}' lon='{:.6f}'/><node id='{}' lat='{:.6f}' lon='{:.6f}'/>",
                         2 * i + 1, 48 + (east ? at : 0), 11 + (east ? 0 : 1.5 * at), 2 * i + 2,
                         48 + (east ? at : 0.018), 11 + (east ? 0.027 : 1.5 * at));
    ways += fmt::format("<way id='{}'><nd ref='{}'/><nd ref='{}'/><tag k='highway' v='residential'/></way>", i + 1,
                        2 * i + 1, 2 * i + 2);
  }
  write("roads.osm", "<osm version='0.6'>" + nodes + ways + "</osm>");
  const std::string scene =
      write("roads.yaml", "ontology: scanmill\nmaterials: materials\nobjects:\n  - town: {map: roads.osm}\n");
  expectRefused(scanmill({"info", scene}), "km of roads in a square of 100 m");
}

TEST_F(InputLimits, ARoadThatGoesToAndFroThirtyThousandTimes) {
  std::string refs;
  for (int i = 0; i < 30'000; ++i) refs += "<nd ref='1'/><nd ref='2'/>";
  write("fro.osm",
        "<osm version='0.6'><node id='1' lat='48' lon='11'/><node id='2' lat='48.009' lon='11'/><way id='1'>" + refs +
            "<tag k='highway' v='residential'/></way></osm>");
  const std::string scene =
      write("fro.yaml", "ontology: scanmill\nmaterials: materials\nobjects:\n  - town: {map: fro.osm}\n");
  const Outcome outcome = scanmill({"info", scene});
  expectRefused(outcome, "km of roads in a square of 100 m");
  EXPECT_LT(outcome.peakBytes, 500'000'000);
}

// The triangles of each primitive are those of one list.
TEST_F(InputLimits, PrimitivesThatShareTheirVertices) {
  writeStrip(folder_.path(), 10'000);
  std::string text = readFile(folder_.path() / "strip.gltf");
  const std::string one = R"({"mode":5,"attributes":{"POSITION":0}})";
  std::string all = one;
  for (int i = 1; i < 3000; ++i) all += "," + one;
  text.replace(text.find(one), one.size(), all);
  expectRefusedByAll(write("strip.gltf", text), "unpacked and with all copies");
}

TEST_F(InputLimits, TwoHundredThousandSeeds) {
  std::string seeds = "1";
  for (int i = 2; i <= 200'000; ++i) seeds += "," + std::to_string(i);
  const std::string file = write(
      "seeds.yaml", fmt::format("scenes: [{{scene: town, seeds: [{}]}}]\n"
                                "trajectories: [{{name: drive, along: lane, speed: 9, every_s: 0.1, frames: 8}}]\n"
                                "sensors: [{{name: top, preset: hdl_64e}}]\n"
                                "method: ray_tracing\neffects: [intensity]\noutput: {{formats: [pcd]}}\n",
                                seeds));
  expectRefused(scanmill({"plan", file}), "more than limits.max_rays");
}

TEST_F(InputLimits, AreRaisedByTheOption) {
  writeStrip(folder_.path(), 2000);
  std::string tiles = tile("strip.gltf");
  for (int i = 1; i < 9500; ++i) tiles += "," + tile("strip.gltf");
  const std::string file = write("tileset.json", tileset(tiles));
  expectRefused(scanmill({"info", file}), "--input-limit 10");
  EXPECT_EQ(scanmill({"info", file, "--input-limit", "2"}).code, 0);
  expectRefused(scanmill({"info", file, "--input-limit", "0.5"}), "input-limit");
}

}  // namespace
}  // namespace scanmill
