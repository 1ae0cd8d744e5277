#include "dataset/card.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>

#include "base/short_text.h"
#include "dataset/json_text.h"
#include "dataset/objects.h"
#include "scan/columns.h"

namespace scanmill {

namespace {

// Returns the text for a cell of a Markdown table, with markup escaped and line breaks replaced by spaces.
std::string cell(std::string_view text) {
  std::string escaped;
  for (const char c : text) {
    if (c == '|' || c == '<' || c == '\\') escaped += '\\';
    escaped += c == '\n' ? ' ' : c;
  }
  return escaped;
}

// Returns the text of a key under `about` in the pipeline; `defaultText` if the pipeline does not have the key.
std::string aboutText(const Manifest& manifest, const std::string& key, const std::string& defaultText) {
  const auto entry = manifest.about.find(key);
  return entry == manifest.about.end() ? defaultText : entry->second;
}

// Returns the texts of all records.
template <class Record, class TextOf>
std::vector<std::string> textsOf(const std::vector<Record>& records, const TextOf& textOf) {
  std::vector<std::string> texts(records.size());
  std::ranges::transform(records, texts.begin(), textOf);
  return texts;
}

std::string summaryOf(const Manifest& manifest, const ScanTotals& totals) {
  const auto modelOf = [](const SensorRecord& sensor) { return sensor.beams.model; };
  return fmt::format("{} samples of simulated LiDAR scans ({}) with {} points, each labelled with its class and object",
                     grouped(manifest.samples.size()), fmt::join(textsOf(manifest.sensors, modelOf), ", "),
                     grouped(totals.points));
}

std::string splitTable(const Manifest& manifest) {
  struct Split {
    std::set<std::string> sequences;
    std::size_t samples = 0;
  };
  std::map<std::string, Split> splits;
  for (const SampleRecord& sample : manifest.samples) {
    splits[sample.split].sequences.insert(partsOfKey(sample.key).sequence);
    ++splits[sample.split].samples;
  }
  std::string text = "| split | sequences | samples |\n|---|---|---|\n";
  for (const auto& [name, split] : splits) {
    text += fmt::format("| {} | {} | {} |\n", name, split.sequences.size(), split.samples);
  }
  return text;
}

std::string sensorTable(const Manifest& manifest) {
  std::string text =
      "| sensor | model | beams | scans a second | range (m) | mounted at x, y, z (m) | yaw, pitch, roll (deg) | "
      "figures from |\n|---|---|---|---|---|---|---|---|\n";
  for (const SensorRecord& sensor : manifest.sensors) {
    const BeamTable& beams = sensor.beams;
    const MountSpans mount = mountSpans(manifest, sensor);
    text += fmt::format("| {} | {} | {} x {} | {:g} | {:g} to {:g} | {}, {}, {} | {}, {}, {} | {} |\n",
                        cell(sensor.name), cell(beams.model), beams.rings, beams.columns, 1 / beams.period,
                        beams.minRange, beams.maxRange, spanText(mount[0]), spanText(mount[1]), spanText(mount[2]),
                        spanText(mount[3]), spanText(mount[4]), spanText(mount[5]), cell(beams.source));
  }
  return text;
}

// Returns the table of the classes that have points, the class with most points first.
std::string classTable(const Manifest& manifest, const ScanTotals& totals) {
  std::vector<std::pair<std::uint64_t, std::uint16_t>> pointsAndIds;
  for (const auto& [id, points] : totals.perClass) pointsAndIds.emplace_back(points, id);
  std::ranges::sort(pointsAndIds, std::greater<>());
  std::string text = "| class | id | points | share |\n|---|---|---|---|\n";
  for (const auto& [points, id] : pointsAndIds) {
    text += fmt::format("| {} | {} | {} | {:.3g} % |\n",
                        cell(requireClass(id, std::string(kCardName), manifest.ontology).name), id, points,
                        100.0 * static_cast<double>(points) / static_cast<double>(totals.points));
  }
  return text;
}

std::string columnTable(const Manifest& manifest) {
  std::string text = "| column | unit | what |\n|---|---|---|\n";
  for (const std::string& name : manifest.columns) {
    const std::size_t index = columnIndex(name);
    if (index == kColumnCount) continue;  // x, y and z, which are not in the table of columns
    text += fmt::format("| {} | {} | {} |\n", name, kColumns[index].unit, cell(kColumns[index].meaning));
  }
  return text;
}

// Returns lists of the modelled and of the omitted features, without features that only concern the computation.
std::string modelText(const std::vector<ModelledItem>& items) {
  constexpr std::array<std::string_view, 3> kComputingTopics{"channels", "properties of hits that nothing reads",
                                                             "instancing"};
  std::string modelled, omitted;
  for (const ModelledItem& item : items) {
    if (std::ranges::find(kComputingTopics, item.topic) != kComputingTopics.end()) continue;
    (item.leftOut ? omitted : modelled) += "- " + cell(lineOf(item)) + "\n";
  }
  std::string text = "What was modelled:\n\n" + modelled;
  if (!omitted.empty()) text += "\nWhat was left out:\n\n" + omitted;
  return text;
}

// Returns the frame of the points, in words.
std::string frameText(const Manifest& manifest) {
  const bool anySensorMoves = std::ranges::any_of(manifest.samples, [](const SampleRecord& sample) {
    return std::ranges::any_of(sample.scans, [](const ScanRecord& scan) { return scan.worldFromSensor.size() > 1; });
  });
  const std::string_view when = manifest.deskewed ? " at the start of the revolution (deskewed)"
                                : anySensorMoves  ? " at the time when the point's column fired (not deskewed)"
                                                  : "";
  return fmt::format("x, y and z are in metres in the sensor's frame{}: x forward, y left, z up.", when);
}

// Returns a sentence on the full scale of the column intensity; empty if the scans do not have the column.
std::string intensityText(const Manifest& manifest) {
  if (!manifest.hasColumn("intensity")) return {};
  const auto scaleOf = [](const SensorRecord& sensor) {
    return fmt::format("{:g} ({})", sensor.intensityFullScale, cell(sensor.name));
  };
  return fmt::format(" Full scale of the intensity: {}.", fmt::join(textsOf(manifest.sensors, scaleOf), ", "));
}

// Returns true if any sample has a member whose name has this suffix.
bool hasMembers(const Manifest& manifest, std::string_view suffix) {
  return std::ranges::any_of(manifest.samples, [&](const SampleRecord& sample) {
    return std::ranges::any_of(sample.members, [&](const std::string& member) { return member.ends_with(suffix); });
  });
}

// Returns a text that lists the members of a sample.
std::string membersText(const Manifest& manifest) {
  return fmt::format(
      "The shards are tar files. A sample consists of the members whose names begin with its key: a scan for each "
      "sensor (`.{}`), and `.json` with the sample's description{}.",
      fmt::join(textsOf(manifest.formats, &FormatRecord::suffix), "`, `."),
      hasMembers(manifest, kObjectsSuffix) ? fmt::format(", and `.{}` with the boxes of objects", kObjectsSuffix) : "");
}

// Returns a Markdown fence for the text: three backticks, or one more than the longest run of backticks in the text.
std::string fenceFor(const std::string& text) {
  std::size_t longest = 2, run = 0;
  for (const char c : text) {
    run = c == '`' ? run + 1 : 0;
    longest = std::max(longest, run);
  }
  return std::string(longest + 1, '`');
}

}  // namespace

ScanTotals totalsOf(const Manifest& manifest) {
  ScanTotals totals;
  for (const SampleRecord& sample : manifest.samples) {
    for (const ScanRecord& scan : sample.scans) {
      totals.points += scan.points;
      totals.beams += scan.beams;
      totals.unresolved += scan.unresolved;
      totals.methods[scan.sensor].insert(scan.method);
      for (const auto& [id, points] : scan.pointsPerClass) totals.perClass[id] += points;
    }
  }
  return totals;
}

MountSpans mountSpans(const Manifest& manifest, const SensorRecord& sensor) {
  MountSpans spans;
  const auto extendBy = [&](const Pose& mount) {
    const Vec3d& t = mount.translation;
    const Quat& q = mount.rotation;
    // These are the angles from which fromYawPitchRoll() computes the rotation.
    const double yaw = std::atan2(2 * (q.w * q.z + q.x * q.y), 1 - 2 * (q.y * q.y + q.z * q.z));
    const double pitch = std::asin(std::clamp(2 * (q.w * q.y - q.z * q.x), -1.0, 1.0));
    const double roll = std::atan2(2 * (q.w * q.x + q.y * q.z), 1 - 2 * (q.x * q.x + q.y * q.y));
    const std::array<double, 6> values{t.x, t.y, t.z, degrees(yaw) + 0.0, degrees(pitch) + 0.0, degrees(roll) + 0.0};
    for (std::size_t i = 0; i < values.size(); ++i) {
      spans[i].least = std::min(spans[i].least, values[i]);
      spans[i].most = std::max(spans[i].most, values[i]);
    }
  };
  if (sensor.vehicleFromSensor) extendBy(*sensor.vehicleFromSensor);
  for (const SampleRecord& sample : manifest.samples) {
    for (const ScanRecord& scan : sample.scans) {
      if (scan.sensor == sensor.name && scan.vehicleFromSensor) extendBy(*scan.vehicleFromSensor);
    }
  }
  return spans;
}

std::string spanText(const Span& span) {
  if (span.least > span.most) return "none";
  // Adding 0.0 turns -0 into 0.
  const auto text = [](double value) { return fmt::format("{:g}", std::round(value * 1e4) / 1e4 + 0.0); };
  const std::string least = text(span.least), most = text(span.most);
  return least == most ? least : least + " to " + most;
}

std::string cardText(const Manifest& manifest) {
  const ScanTotals totals = totalsOf(manifest);
  const std::string license = aboutText(manifest, "license", "");
  std::string text = fmt::format("---\npretty_name: {}\n", scalarText(OrderedJson(manifest.name)));
  if (!license.empty()) text += fmt::format("license: {}\n", scalarText(OrderedJson(license)));
  text += "tags: [lidar, point-cloud, synthetic, semantic-segmentation]\n---\n\n";
  text += fmt::format("# {}\n\n{}.\n\n", cell(manifest.name),
                      aboutText(manifest, "description", summaryOf(manifest, totals)));
  text += fmt::format(
      "- Creator: {}\n- License: {}\n", aboutText(manifest, "creator", "not stated"),
      license.empty() ? "not stated; the licenses of the scenes' assets hold for what was made of them" : license);
  for (const auto& [key, title] : {std::pair("url", "Page"), std::pair("citation", "Cite as")}) {
    const std::string value = aboutText(manifest, key, "");
    if (!value.empty()) text += fmt::format("- {}: {}\n", title, value);
  }
  std::set<std::string> randomKeys, methods;
  for (const SampleRecord& sample : manifest.samples) {
    for (const DrawnValue& draw : sample.draws) randomKeys.insert(draw.key);
  }
  for (const auto& [sensor, sensorMethods] : totals.methods) methods.insert(sensorMethods.begin(), sensorMethods.end());
  text += fmt::format(
      "\n## What it contains\n\n{}\n{} points of {} beams. All samples of a sequence are in one split. `manifest.json` "
      "describes each sample, with poses, counts and hashes.\n\n{}\n{}\n{}\n{}{} {}\n\n",
      splitTable(manifest), grouped(totals.points), grouped(totals.beams), sensorTable(manifest), columnTable(manifest),
      classTable(manifest, totals), frameText(manifest), intensityText(manifest), membersText(manifest));
  text += fmt::format(
      "## How it was made\n\nSimulated with Scanmill {} by the method {}, with the seed {}. Labels are those of the "
      "surfaces that the beams hit, as the scenes or images state them. {}",
      manifest.programVersion, fmt::join(methods, ", "), manifest.seed, modelText(manifest.modelled));
  if (!randomKeys.empty()) {
    text += fmt::format("\nRandom values, which the manifest states for each sample: `{}`.\n",
                        fmt::join(randomKeys, "`, `"));
  }
  const std::string fence = fenceFor(manifest.pipelineText);
  text += fmt::format("\nThe pipeline, from which `scanmill generate` makes the same bytes:\n\n{0}yaml\n{1}{2}{0}\n\n",
                      fence, manifest.pipelineText, manifest.pipelineText.ends_with('\n') ? "" : "\n");
  text +=
      "## What it is for, and what it is not for\n\nIt is for training and for comparing networks that label, detect "
      "or complete LiDAR scans, and for testing programs that read them. Results on it do not show how a network or a "
      "vehicle performs in real traffic: judge that on recorded scans. It lacks whatever the scenes and the list "
      "above lack, and classes are as frequent as in the scenes, not as in any real place. `scanmill compare` "
      "measures how far it is from recorded scans of yours.\n";
  return text;
}

}  // namespace scanmill
