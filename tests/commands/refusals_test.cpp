// Each row holds arguments that the program refuses and words of the error. Where a library's test states the law, the
// row shows that the error reaches the user.

#include "base/file.h"
#include "tests/commands/program.h"

namespace scanmill {
namespace {

constexpr const char* kScan =
    "VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 1\nHEIGHT 1\nPOINTS 1\nDATA ascii\n1 2 3\n";

// P is the small pipeline and A its dataset, @x a file of the folder, S the project.
struct Refusal {
  const char* command;
  std::string says;
};

const Refusal kRefusals[] = {
    {"generat", "did you mean 'generate'?"},
    {"picture A", "scanmill view INPUT --screenshot FILE.png"},
    {"list format", "did you mean 'formats'?"},
    {"list range_nois", "did you mean 'range_noise'?"},

    {"generate", "PIPELINE is missing"},
    {"generate P", "-o DIR is missing"},
    {"generate P -o ''", "-o DIR is missing"},
    {"generate P -o", "--help"},
    {"generate P Q -o @x", "'Q' is a second"},
    {"generate P -o @x --thread 2", "thread"},
    {"generate P -o @x --threads two", "two"},
    {"generate P -o @x --threads -1", "--threads must be from 0 to 1024"},
    {"generate P -o @x --threads 99999999999999999999", "9999"},
    {"generate P -o @x --memory-limit '8 parsecs'", "such as 8G, below 16 EiB, not '8 parsecs'"},
    {"generate P -o @x --memory-limit -1G", "such as 8G"},
    {"generate P -o @x --memory-limit 1e10T", "below 16 EiB, not '1e10T'"},
    {"generate P -o @x --memory-limit 0.5", "such as 8G, below 16 EiB, not '0.5'"},
    {"generate P -o @x --resume --overwrite", "only one of the two"},
    {"generate P -o @x --resume --keep-hits @y", "cannot continue a recording"},
    {"generate P -o @x --shards 0 --workers 2", "give only one of the two"},
    {"generate P -o @x --shards 1000", "such as 0-9,12"},
    {"generate P -o @x --worker 1", "give both --worker I and --workers N"},
    {"generate P -o @x --workers 3", "give both --worker I and --workers N"},
    {"generate P -o @x --worker 3 --workers 3", "numbered from 0"},
    {"generate P -o @x --worker -1 --workers 3", "whole number"},
    {"generate P -o @x --worker 0 --workers auto", "leave it out"},
    {"generate P -o @x --workers auto --overwrite", "--overwrite"},
    {"generate P -o @x --workers auto --keep-hits @y", "one process"},
    {"generate P -o A", "--overwrite"},
    {"generate P -o P", "is a file"},
    {"generate P -o @filled --overwrite", "has no dataset"},
    {"generate P -o @x --keep-hits @hits", "--overwrite"},
    {"generate P -o @x --keep-hits ''", "--keep-hits: the name of the folder is empty"},
    {"generate P -o @x --from-hits @hits --from-passes @hits", "give only one of"},
    {"generate P -o @x --from-passes @hits", "--from-hits"},
    {"generate P -o @x --from-hits A", "no recording.json"},
    {"generate @scene.yaml -o @x", "scene.yaml: this is a scene: name it under `scenes:` of a pipeline"},

    {"plan", "PIPELINE is missing"},
    {"plan absent.yaml", "absent.yaml"},
    {"plan streat", "did you mean 'street'"},
    {"plan S/pipelines/sensors/vlp_16.yaml", "this is a sensor"},
    {"plan P --set method.depth_camera.renderer=blender", "'method' is a single value and has no 'depth_camera'"},
    {"plan P --set nonsense", "nonsense"},
    {"plan P --set output.shard_md=3", "did you mean 'shard_mb'?"},
    {"plan P --set sensors.0.preset=os1_182", "did you mean 'os1_128'"},
    {"plan P --set name=\xff", "UTF-8"},
    {"plan P --seed minus", "seed"},
    {"plan P --frames 0", "must be a whole number from 1"},
    {"plan P --frames many", "must be a whole number"},
    {"plan P --from-hits A", "no recording.json"},
    {"plan P --from-passes ''", "--from-passes: the name of the folder is empty"},
    {"plan P --set trajectories.0.frames=10000000 --set trajectories.0.every_s=1e-5 --set sensors.0.columns=15625",
     "10000000 frames x 125000 beams = 1.25e+12 rays"},

    {"verify", "DIR is missing"},
    {"verify absent", "absent"},
    {"verify P", "is a file: name the folder of a dataset"},
    {"verify @filled", "is not a dataset: it has no manifest.json"},
    {"verify @begun", "has an unfinished dataset: `scanmill generate` writes manifest.json last"},
    {"verify @hits", "is a recording"},

    {"info", "FILE|DIR is missing"},
    {"info absent,too.pcd", "absent,too.pcd: does not exist"},
    {"info aaaa", "aaaa: does not exist"},
    {"info vlp-17", "vlp-17: does not exist (did you mean 'vlp_16', which comes with the program?)"},
    {"info @filled", "is not a dataset"},
    {"info @notes.zzz", "BLEND"},
    {"info @shed.obj --up w", "--up must be x, y or z"},
    {"info @shed.obj --unit cm", "--unit"},
    {"info @own.yaml", "own.yaml:5:11: unknown effect 'range_nois' (did you mean 'range_noise'?)"},
    {"info semantic_kitti", "scanmill list ontologies"},
    {"info S/scenes/village.osm", "town: {map: FILE}"},

    {"report", "DATASET is missing"},
    {"report absent", "absent: does not exist"},
    {"report A -o @there.html", "--overwrite"},
    {"report A -o A", "is a folder"},
    {"report A -o @there.html/a.html", "there.html: cannot be made"},
    {"report A -o @there.html/b/a.html", "there.html/b: cannot be made"},
    {"report A -o ''", "-o: the name of the file is empty"},
    {"report A --samples 65 -o @x", "from 0 to 64"},
    {"report A --samples -1 -o @x", "-1"},
    {"report A --seed one -o @x", "one"},

    {"tradeoff P", "-o DIR is missing"},
    {"tradeoff P -o @x --budget 0", "--budget must be above 0"},
    {"tradeoff P -o @x --budget soon", "soon"},
    {"tradeoff P -o @x --set 'tradeoff={settings: [rays]}'", "unknown method 'rays'"},
    {"tradeoff P -o P", "is a file"},
    {"tradeoff P -o @filled --overwrite", "no tradeoff.json"},

    {"repeatability", "PIPELINE is missing"},
    {"repeatability P", "-o DIR is missing"},
    {"repeatability P -o @x --set repeatability.scan=3", "did you mean 'scans'?"},
    {"repeatability P -o @r --set repeatability.object=nothing", "no thing 'nothing'"},
    {"repeatability P -o @filled --overwrite", "filled"},

    {"compare A -o @c", "compare takes two sets, REAL and SIMULATED, not 1"},
    {"compare A A", "-o DIR is missing"},
    {"compare A absent -o @c", "does not exist"},
    {"compare A A -o @c --sensor nosuch", "neither set has a sensor of this name"},
    {"compare @filled A -o @c", "is not a dataset"},
    {"compare @damaged A -o @c", "no whole records of 4 float32"},
    {"compare A A -o @filled", "filled"},

    {"fit-noise --sensor os1_128 -o @x", "SCAN is missing"},
    {"fit-noise @one.pcd -o @x", "--sensor is missing"},
    {"fit-noise @one.pcd --sensor os1_128", "--out is missing"},
    {"fit-noise @one.pcd --sensor os1_12 -o @x", "did you mean 'os1_128'"},
    {"fit-noise @one.pcd --sensor os1_128 -o @there.html", "--overwrite"},
    {"fit-noise @filled --sensor os1_128 -o @x", "is not a dataset"},
    {"fit-noise @one.pcd --sensor P -o @x", "pipeline"},
    {"fit-sensor -o @x", "SCAN is missing"},
    {"fit-sensor @one.pcd", "--out is missing"},
    {"fit-sensor @one.pcd -o @x", "the beams of the scans' points are unknown"},

    {"draft -o @x", "name 3D files"},
    {"draft @shed.obj", "-o FILE.yaml"},
    {"draft @none.obj -o @x.yaml", "none.obj: the file does not exist"},
    {"draft @filled -o @x.yaml", "contains no 3D file"},
    {"draft @shed.obj -o @x.yaml --ontology nowhere", "nowhere"},
    {"draft @shed.obj -o @there.yaml", "there.yaml: exists: name another place"},

    {"render P -o @x", "method: depth_camera"},
    {"render P --set method=depth_camera", "-o DIR is missing"},
    {"render P -o @x --set method=depth_camera --passes depth,normals", "did you mean 'normal'"},
};

TEST_F(SmallWorld, WrongUseIsRefusedWithAdviceAndMakesNothing) {
  ASSERT_EQ(scanmill({"generate", pipeline_, "-q", "-o", at("a"), "--keep-hits", at("hits")}).code, 0);
  folder_.write("own.yaml",
                "columns: 60\nrate_hz: 10\nelevation_deg: {top: 15, bottom: -15, rings: 16}\nrange_m: [1, 100]\n"
                "effects: [range_nois]\n");
  for (const char* name : {"there.html", "there.yaml", "filled/mine.txt", "notes.zzz"}) folder_.write(name, "mine");
  folder_.write("begun/.scanmill/plan", "{}");
  folder_.write("damaged/velodyne/000000.bin", "abc");
  folder_.write("bad.yaml", "objects: 3\n");
  folder_.write("one.pcd", kScan);
  folder_.write("shed.obj", "v 0 0 0\nv 1 0 0\nv 0 0 1\nf 1 2 3\n");
  std::vector<std::vector<std::string>> commands;
  for (const Refusal& row : kRefusals) {
    commands.push_back(wordsOf(row.command));
    for (std::string& word : commands.back()) {
      if (word == "P") word = pipeline_;
      if (word == "A") word = at("a");
      if (word.starts_with("S/")) word.replace(0, 1, SCANMILL_SOURCE_DIR);
      if (const std::size_t file = word.find('@'); file != std::string::npos) word.replace(file, 1, at(""));
    }
  }
  const std::vector<Outcome> outcomes = scanmillEach(commands);
  for (std::size_t i = 0; i < outcomes.size(); ++i) {
    SCOPED_TRACE(kRefusals[i].command);
    expectRefused(outcomes[i], kRefusals[i].says);
  }
  for (const char* name : {"x", "x.yaml", "y"}) EXPECT_FALSE(std::filesystem::exists(at(name))) << name;
  for (const char* name : {"there.html", "there.yaml", "filled/mine.txt"}) EXPECT_EQ(readFile(at(name)), "mine");
  EXPECT_EQ(filesEndingIn("", at("filled")).size(), 1u);
}

}  // namespace
}  // namespace scanmill
