// Writes the tables of nuScenes: lists of rows that refer to each other by tokens; sample_annotation has a row for each
// box, and instance a row for each object of a scene that has boxes. docs/schema_nuscenes.md in
// github.com/nutonomy/nuscenes-devkit describes their fields.

#include <fmt/core.h>
#include <png.h>

#include <algorithm>
#include <array>
#include <map>
#include <span>
#include <utility>
#include <vector>

#include "base/error.h"
#include "exports/nuscenes_rows.h"
#include "images/images.h"

namespace scanmill {

namespace fs = std::filesystem;

namespace {

// The rotation from the axes of nuScenes' LIDAR_TOP (x right, y forward, z up) to the sensor's axes (x forward, y left,
// z up): -90 degrees about z.
constexpr Quat kSensorFromLidarTop{0.70710678118654752440, 0, 0, -0.70710678118654752440};

// The numbers of the scenes in nuScenes' splits, as ranges from first to last (nuscenes-devkit,
// python-sdk/nuscenes/utils/splits.py). Training programs recognise the splits by these numbers.
using SceneRun = std::pair<std::size_t, std::size_t>;
constexpr SceneRun kTrainScenes[] = {
    {1, 2},     {4, 11},    {19, 34},   {41, 76},    {120, 135},   {138, 139},   {149, 152},  {154, 155}, {157, 168},
    {170, 185}, {187, 188}, {190, 196}, {199, 200},  {202, 204},   {206, 214},   {218, 220},  {222, 222}, {224, 264},
    {283, 306}, {315, 318}, {321, 321}, {323, 324},  {328, 328},   {347, 386},   {388, 403},  {405, 408}, {410, 459},
    {461, 465}, {467, 469}, {471, 472}, {474, 480},  {499, 502},   {504, 515},   {517, 518},  {525, 539}, {541, 546},
    {566, 566}, {568, 568}, {570, 578}, {580, 580},  {582, 600},   {639, 679},   {681, 681},  {683, 689}, {695, 698},
    {700, 701}, {703, 719}, {726, 728}, {730, 731},  {733, 741},   {744, 744},   {746, 747},  {749, 752}, {757, 765},
    {767, 769}, {786, 787}, {789, 792}, {803, 806},  {808, 813},   {815, 817},   {819, 822},  {847, 856}, {858, 858},
    {860, 866}, {868, 873}, {875, 878}, {880, 880},  {882, 903},   {945, 945},   {947, 947},  {949, 949}, {952, 953},
    {955, 961}, {975, 984}, {988, 992}, {994, 1025}, {1044, 1058}, {1074, 1102}, {1104, 1110}};
constexpr SceneRun kValScenes[] = {{3, 3},     {12, 18},   {35, 36},   {38, 39},   {92, 110},   {221, 221}, {268, 278},
                                   {329, 332}, {344, 346}, {519, 524}, {552, 565}, {625, 627},  {629, 630}, {632, 638},
                                   {770, 771}, {775, 775}, {777, 778}, {780, 784}, {794, 800},  {802, 802}, {904, 917},
                                   {919, 931}, {962, 963}, {966, 969}, {971, 972}, {1059, 1073}};
constexpr std::size_t kFirstOther = 9001;  // number of the first scene that is in none of nuScenes' splits

// The cameras that training programs require, and their azimuths (deg, counter-clockwise from ahead). All cameras are
// at the first lidar's origin, look horizontally and have one black image. Intrinsics (px) are typical of nuScenes.
constexpr std::array<std::pair<std::string_view, double>, 6> kCameras{{{"CAM_FRONT", 0},
                                                                       {"CAM_FRONT_RIGHT", -55},
                                                                       {"CAM_FRONT_LEFT", 55},
                                                                       {"CAM_BACK", 180},
                                                                       {"CAM_BACK_LEFT", 110},
                                                                       {"CAM_BACK_RIGHT", -110}}};
constexpr int kCameraWidth = 1600;
constexpr int kCameraHeight = 900;
constexpr double kCameraFocal = 1266;
// The rotation from camera axes (x right, y down, z forward) to the vehicle's.
constexpr Quat kVehicleFromCamera{0.5, -0.5, 0.5, -0.5};

constexpr std::uint32_t kMapSide = 64;  // pixels along each side of the square map; a pixel is 0.1 m

constexpr std::array<std::pair<std::string_view, std::string_view>, 8> kAttributes{{
    {"vehicle.moving", "it moves"},
    {"vehicle.stopped", "it stands, but moves at another time of the scene"},
    {"vehicle.parked", "it stands in the whole scene"},
    {"cycle.with_rider", "it moves at any time of the scene"},
    {"cycle.without_rider", "it stands in the whole scene"},
    {"pedestrian.sitting_lying_down", "nobody is called so here"},
    {"pedestrian.standing", "they stand, sit or lie"},
    {"pedestrian.moving", "they move"},
}};

// Returns the map's mask as PNG. All of it is foreground, because objects may be anywhere.
std::string mapMask() {
  const std::vector<std::uint8_t> pixels(kMapSide * kMapSide, 255);  // 255: foreground
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  image.width = image.height = kMapSide;
  image.format = PNG_FORMAT_GRAY;
  png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(image);
  std::string bytes(size, '\0');
  if (png_image_write_to_memory(&image, bytes.data(), &size, 0, pixels.data(), 0, nullptr) == 0) {
    throw Error("a map cannot be written as a PNG: {}", image.message);
  }
  bytes.resize(size);
  return bytes;
}

class Tables {
 public:
  Tables(const ExportPlan& plan, const ReadObjects& read, const ExportFolder& folder)
      : plan_(plan), read_(read), folder_(folder), rows_(folder) {}

  std::size_t write() {
    addFixed();
    for (std::size_t s = 0; s < plan_.sequences.size(); ++s) addScene(s);
    rows_.commit();
    folder_.write(fs::path(kNuScenesVersion) / "splits.json", layOut(splits_) + "\n");
    folder_.write(mapFile(), mapMask());
    for (std::size_t i = 0; i < plan_.sensors.size(); ++i) folder_.prepareFile(fs::path("sweeps") / channel(i) / "");
    const std::vector<std::uint8_t> black(std::size_t{3} * kCameraWidth * kCameraHeight);
    const std::string image = encodePng(black.data(), kCameraWidth, kCameraHeight);
    for (const auto& [camera, side] : kCameras) folder_.write(cameraFile(camera), image);
    return annotations_;
  }

 private:
  std::string token(std::string_view table, std::string_view row) const { return nuScenesToken(plan_, table, row); }

  void add(const std::string& table, const OrderedJson& row) { rows_.add(table, row); }

  std::string channel(std::size_t sensor) const { return nuScenesChannel(plan_, sensor); }
  std::string sensorToken(std::size_t sensor) const { return token("sensor", sensor == 0 ? "" : channel(sensor)); }
  std::string mountToken(std::size_t sensor, const ExportSequence& sequence) const {
    return token("calibrated_sensor", sensor == 0 ? sequence.name : sequence.name + " " + channel(sensor));
  }

  static std::string cameraFile(std::string_view camera) { return fmt::format("samples/{}/black.png", camera); }
  std::string cameraToken(std::string_view table, std::string_view camera, const std::string& row) const {
    return token(table, fmt::format("{} {}", row, camera));
  }

  std::string mapFile() const { return fmt::format("maps/{}.png", token("map", "")); }

  // Adds the rows that are the same for all scenes.
  void addFixed() {
    for (const char* name : {"attribute", "calibrated_sensor", "category", "ego_pose", "instance", "log", "map",
                             "sample", "sample_annotation", "sample_data", "scene", "sensor", "visibility"}) {
      rows_.open(name);  // the file must exist even without rows
    }
    if (plan_.manifest.hasColumn("label")) rows_.open("lidarseg");
    if (plan_.manifest.hasColumn("label") && plan_.manifest.hasColumn("instance")) rows_.open("panoptic");
    for (const auto& [name, description] : kAttributes) {
      add("attribute", {{"token", token("attribute", name)}, {"name", name}, {"description", description}});
    }
    addCategories();
    constexpr std::array<std::string_view, 5> kSteps{"0", "40", "60", "80", "100"};
    for (std::size_t i = 0; i + 1 < kSteps.size(); ++i) {
      add("visibility", {{"token", std::to_string(i + 1)},
                         {"level", fmt::format("v{}-{}", kSteps[i], kSteps[i + 1])},
                         {"description", fmt::format("between {} and {} % of the beams at the object meet it",
                                                     kSteps[i], kSteps[i + 1])}});
    }
    for (std::size_t i = 0; i < plan_.sensors.size(); ++i) {
      add("sensor", {{"token", sensorToken(i)}, {"channel", channel(i)}, {"modality", "lidar"}});
    }
    for (const auto& [camera, side] : kCameras) {
      add("sensor", {{"token", cameraToken("sensor", camera, "")}, {"channel", camera}, {"modality", "camera"}});
    }
    OrderedJson logs = OrderedJson::array();
    for (const ExportSequence& sequence : plan_.sequences) logs.push_back(token("log", sequence.name));
    add("map", {{"token", token("map", "")},
                {"log_tokens", std::move(logs)},
                {"category", "semantic_prior"},
                {"filename", mapFile()}});
  }

  // Adds a category for each class of the exported ontology, in the order of the class ids, as the devkit requires.
  void addCategories() {
    std::map<std::uint16_t, std::string> sourceNames;  // names of the dataset's classes, by target class
    for (const SemanticClass& c : plan_.manifest.ontology.classes) {
      std::string& names = sourceNames[plan_.classes.targetId(c.id)];
      names += (names.empty() ? "" : ", ") + c.name;
    }
    std::vector<SemanticClass> classes = plan_.classes.target().classes;
    std::ranges::sort(classes, [](const auto& a, const auto& b) { return a.id < b.id; });
    for (const SemanticClass& c : classes) {
      const std::string& from = sourceNames[c.id];
      add("category", {{"token", token("category", std::to_string(c.id))},
                       {"name", c.id == 0 ? "noise" : c.name},
                       {"description", from.empty() ? "nothing in this dataset"
                                                    : fmt::format("{}: {}", plan_.manifest.ontology.name, from)},
                       {"index", c.id}});
    }
  }

  // Adds all rows of the sequence with the index `s`, which is a scene.
  void addScene(std::size_t s) {
    const ExportSequence& sequence = plan_.sequences[s];
    const std::vector<SampleRecord>& samples = plan_.manifest.samples;
    const std::string name = fmt::format("scene-{:04}", sceneNumber(sequence.split));
    const std::string scene = token("scene", sequence.name);
    add("log", {{"token", token("log", sequence.name)},
                {"logfile", sequence.name},
                {"vehicle", "simulated"},
                {"date_captured", nuScenesDate(s)},
                {"location", plan_.manifest.name}});
    for (std::size_t i = 0; i < plan_.sensors.size(); ++i) {
      const SensorRecord& sensor = *plan_.sensors[i];
      const Pose& vehicleFromSensor = mountOf(sensor, scanOf(plan_, samples[sequence.samples.front()], i));
      add("calibrated_sensor", {{"token", mountToken(i, sequence)},
                                {"sensor_token", sensorToken(i)},
                                {"translation", listOf(vehicleFromSensor.translation, sensor.name)},
                                {"rotation", listOf(vehicleFromSensor.rotation * kSensorFromLidarTop, sensor.name)},
                                {"camera_intrinsic", OrderedJson::array()}});
    }
    const Pose& top = mountOf(*plan_.sensors[0], scanOf(plan_, samples[sequence.samples.front()], 0));
    for (const auto& [camera, side] : kCameras) {
      const Quat rotation = fromYawPitchRoll(radians(side), 0, 0) * kVehicleFromCamera;
      add("calibrated_sensor",
          {{"token", cameraToken("calibrated_sensor", camera, sequence.name)},
           {"sensor_token", cameraToken("sensor", camera, "")},
           {"translation", listOf(top.translation, sequence.name)},
           {"rotation", listOf(rotation, sequence.name)},
           {"camera_intrinsic",
            {{kCameraFocal, 0.0, kCameraWidth / 2.0}, {0.0, kCameraFocal, kCameraHeight / 2.0}, {0.0, 0.0, 1.0}}}});
    }
    add("scene", {{"token", scene},
                  {"log_token", token("log", sequence.name)},
                  {"nbr_samples", sequence.samples.size()},
                  {"first_sample_token", token("sample", samples[sequence.samples.front()].key)},
                  {"last_sample_token", token("sample", samples[sequence.samples.back()].key)},
                  {"name", name},
                  {"description", sequence.name}});
    for (const std::string& split : {sequence.split, "scanmill_" + sequence.split}) splits_[split].push_back(name);
    for (std::size_t f = 0; f < sequence.samples.size(); ++f) addSample(s, f, scene);
    annotations_ += addAnnotations(plan_, read_, s, rows_);
    rows_.flush();
  }

  const SampleRecord& sampleAt(std::size_t s, std::size_t f) const {
    return plan_.manifest.samples[plan_.sequences[s].samples[f]];
  }

  // Adds the rows of the frame `f` of the sequence `s`. `scene`: token of the scene.
  void addSample(std::size_t s, std::size_t f, const std::string& scene) {
    const ExportSequence& sequence = plan_.sequences[s];
    const bool isFirst = f == 0, isLast = f + 1 == sequence.samples.size();
    const auto sampleToken = [&](std::size_t frame) { return token("sample", sampleAt(s, frame).key); };
    const SampleRecord& sample = sampleAt(s, f);
    add("sample", {{"token", sampleToken(f)},
                   {"timestamp", nuScenesTime(s, scanOf(plan_, sample, 0))},
                   {"prev", isFirst ? "" : sampleToken(f - 1)},
                   {"next", isLast ? "" : sampleToken(f + 1)},
                   {"scene_token", scene}});
    for (std::size_t i = 0; i < plan_.sensors.size(); ++i) addScans(s, f, i);
    for (const auto& each : kCameras) {
      const std::string_view camera = each.first;
      const auto imageToken = [&](std::size_t frame) {
        return cameraToken("sample_data", camera, sampleAt(s, frame).key);
      };
      add("sample_data", {{"token", imageToken(f)},
                          {"sample_token", sampleToken(f)},
                          {"ego_pose_token", token("ego_pose", nuScenesScan(plan_, sample, 0))},
                          {"calibrated_sensor_token", cameraToken("calibrated_sensor", camera, sequence.name)},
                          {"timestamp", nuScenesTime(s, scanOf(plan_, sample, 0))},
                          {"fileformat", "png"},
                          {"is_key_frame", true},
                          {"height", kCameraHeight},
                          {"width", kCameraWidth},
                          {"filename", cameraFile(camera)},
                          {"prev", isFirst ? "" : imageToken(f - 1)},
                          {"next", isLast ? "" : imageToken(f + 1)}});
    }
  }

  // Returns the number of the next scene of the split: the next number in nuScenes' split of the same name (train and
  // val) or, if there is none, the next number from kFirstOther on.
  std::size_t sceneNumber(const std::string& split) {
    std::size_t index = scenesOf_[split]++;  // index among the numbers of this run and of later runs
    const std::span<const SceneRun> runs = split == "train" ? std::span<const SceneRun>(kTrainScenes)
                                           : split == "val" ? std::span<const SceneRun>(kValScenes)
                                                            : std::span<const SceneRun>();
    for (const auto& [first, last] : runs) {
      if (index <= last - first) return first + index;
      index -= last - first + 1;
    }
    return kFirstOther + others_++;
  }

  std::string scanToken(std::string_view table, const SampleRecord& sample, std::size_t sensor, std::size_t r) const {
    return token(table, nuScenesScan(plan_, sample, sensor, static_cast<std::uint32_t>(r)));
  }

  // Adds the rows of a sensor's scans of a sample: ego_pose, sample_data and, for the first scan, labels.
  void addScans(std::size_t s, std::size_t f, std::size_t sensor) {
    const ExportSequence& sequence = plan_.sequences[s];
    const SampleRecord& sample = sampleAt(s, f);
    const std::vector<const ScanRecord*> scans = revolutionsOf(plan_, sample, sensor);
    // Tokens of the sensor's last scan in the frame before, its scans in this frame, and its first scan in the next
    // frame; empty where the sequence has no such frame.
    std::vector<std::string> tokens(scans.size() + 2);
    if (f > 0) {
      const SampleRecord& previous = sampleAt(s, f - 1);
      tokens.front() = scanToken("sample_data", previous, sensor, revolutionsOf(plan_, previous, sensor).size() - 1);
    }
    for (std::size_t r = 0; r < scans.size(); ++r) tokens[r + 1] = scanToken("sample_data", sample, sensor, r);
    if (f + 1 < sequence.samples.size()) tokens.back() = scanToken("sample_data", sampleAt(s, f + 1), sensor, 0);
    for (std::size_t r = 0; r < scans.size(); ++r) {
      const ScanRecord& scan = *scans[r];
      const std::int64_t time = nuScenesTime(s, scan);
      const Pose worldFromVehicle = scan.worldFromSensor.front() * inverse(mountOf(*plan_.sensors[sensor], scan));
      const std::string pose = scanToken("ego_pose", sample, sensor, r);
      add("ego_pose", {{"token", pose},
                       {"timestamp", time},
                       {"rotation", listOf(worldFromVehicle.rotation, sample.key)},
                       {"translation", listOf(worldFromVehicle.translation, sample.key)}});
      add("sample_data", {{"token", tokens[r + 1]},
                          {"sample_token", token("sample", sample.key)},
                          {"ego_pose_token", pose},
                          {"calibrated_sensor_token", mountToken(sensor, sequence)},
                          {"timestamp", time},
                          {"fileformat", "pcd"},
                          {"is_key_frame", r == 0},
                          {"height", 0},
                          {"width", 0},
                          {"filename", pointsFile(plan_, s, sample, sensor, scan).generic_string()},
                          {"prev", tokens[r]},
                          {"next", tokens[r + 2]}});
    }
    // The devkit finds the labels of the first scan by the scan's token, so the row of the labels has the same token.
    const std::string& keyFrame = tokens[1];
    const auto addLabels = [&](const char* table, NuScenesLabels kind) {
      if (!rows_.has(table)) return;
      const std::string file = labelFile(plan_, sample, sensor, kind).generic_string();
      add(table, {{"token", keyFrame}, {"sample_data_token", keyFrame}, {"filename", file}});
    };
    addLabels("lidarseg", NuScenesLabels::Lidarseg);
    addLabels("panoptic", NuScenesLabels::Panoptic);
  }

  const ExportPlan& plan_;
  const ReadObjects& read_;
  const ExportFolder& folder_;
  NuScenesRows rows_;
  OrderedJson splits_ = OrderedJson::object();
  std::map<std::string, std::size_t> scenesOf_;  // number of scenes so far, by split
  std::size_t annotations_ = 0;                  // number of rows of sample_annotation so far
  std::size_t others_ = 0;                       // number of scenes so far with numbers from kFirstOther on
};

}  // namespace

std::size_t writeNuScenesTables(const ExportPlan& plan, const ReadObjects& read, const ExportFolder& folder) {
  return Tables(plan, read, folder).write();
}

}  // namespace scanmill
