#include <fmt/core.h>

#include <algorithm>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "base/file.h"
#include "config/fields.h"
#include "sensors/pose_files.h"

namespace scanmill {
namespace {

using Json = nlohmann::json;
constexpr std::string_view kScans = "LIDAR_TOP";  // part of the file names of scans

// Calls `take` for each row of a table. Each row is freed after the call, because the largest table has millions of
// rows.
void forEachRow(const std::filesystem::path& file, const std::function<void(const Json&)>& take) {
  const std::string bytes = readFile(file);
  try {
    const Json rest = Json::parse(bytes, [&](int depth, Json::parse_event_t event, Json& row) {
      if (event != Json::parse_event_t::object_end || depth != 1) return true;
      take(row);
      return false;
    });
    if (!rest.is_array()) throw InputError({file.string()}, "is not a table of nuScenes: it must be a list");
  } catch (const nlohmann::json::exception& e) {
    throw InputError({file.string()}, fmt::format("is not a table of nuScenes: {}", reasonOf(e)));
  }
}

}  // namespace

std::vector<StampedPose> readNuScenesPoses(const std::filesystem::path& file, const std::string& scene) {
  const std::filesystem::path folder = file.parent_path();
  std::string token;
  std::vector<std::string> scenes;
  forEachRow(folder / "scene.json", [&](const Json& row) {
    scenes.push_back(row.at("name").get<std::string>());
    if (scenes.back() == scene) token = row.at("token").get<std::string>();
  });
  if (token.empty()) {
    throw InputError({(folder / "scene.json").string()},
                     fmt::format("has no scene '{}'{}", scene, suggestion(scene, scenes)));
  }
  std::set<std::string> samples;
  forEachRow(folder / "sample.json", [&](const Json& row) {
    if (row.at("scene_token") == token) samples.insert(row.at("token").get<std::string>());
  });
  std::set<std::string> wanted;
  forEachRow(folder / "sample_data.json", [&](const Json& row) {
    if (row.at("filename").get_ref<const std::string&>().find(kScans) == std::string::npos) return;
    if (samples.contains(row.at("sample_token").get_ref<const std::string&>())) {
      wanted.insert(row.at("ego_pose_token").get<std::string>());
    }
  });
  std::vector<StampedPose> poses;
  forEachRow(file, [&](const Json& row) {
    if (!wanted.contains(row.at("token").get_ref<const std::string&>())) return;
    const auto q = row.at("rotation").get<std::array<double, 4>>();
    const auto t = row.at("translation").get<std::array<double, 3>>();
    const Location where{fmt::format("{}: the pose {}", file.string(), row.at("token").get<std::string>())};
    poses.push_back({row.at("timestamp").get<double>() * 1e-6,
                     {checkedRotation({q[0], q[1], q[2], q[3]}, where), {t[0], t[1], t[2]}}});
  });
  std::sort(poses.begin(), poses.end(), [](const StampedPose& a, const StampedPose& b) { return a.time < b.time; });
  return poses;
}

}  // namespace scanmill
