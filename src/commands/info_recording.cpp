#include <fmt/core.h>

#include <algorithm>
#include <string>

#include "base/error.h"
#include "base/short_text.h"
#include "base/terminal.h"
#include "commands/info.h"
#include "commands/table.h"
#include "dataset/recording.h"
#include "passes/exr/exr_file.h"

namespace scanmill {

void printRecording(const std::filesystem::path& folder) {
  const Recording r = readRecording(folder, recordingIn(folder).value_or(RecordingKind::Hits));
  std::uintmax_t bytes = 0;
  std::uint64_t images = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (!entry.is_regular_file()) continue;
    bytes += entry.file_size();
    images += entry.path().extension() == ".exr" ? 1 : 0;
  }
  printText("recording of {}{}: {} images, {}\n\n", nameOf(r.kind),
            r.programVersion.empty() ? std::string(", not made by scanmill")
                                     : fmt::format(", made by {}, scanmill {}", r.method, r.programVersion),
            grouped(images), shortBytes(static_cast<double>(bytes)));
  Rows sensors{{"sensor", "rings", "columns"}};
  for (const RecordedSensor& s : r.sensors) {
    sensors.push_back({s.name, std::to_string(s.rings), std::to_string(s.columns)});
  }
  printText("{}\n", formatTable(sensors));
  Rows sequences{{"scene", "seed", "trajectory", "frames", "materials"}};
  for (const RecordedSequence& s : r.sequences) {
    sequences.push_back({s.scene, std::to_string(s.seed), s.trajectory, std::to_string(s.frames),
                         std::to_string(r.materials[s.materials].size())});
  }
  printText("{}\n", formatTable(sequences));
  if (r.ontology.classes.empty()) {
    printText("no ontology: name one in the pipeline by the key `labels`\n");
  } else {
    printText("ontology {}: {} classes\n", r.ontology.name, r.ontology.classes.size());
  }
  for (const ModelledItem& item : r.modelled) printText("  {}\n", oneLine(lineOf(item)));
  printText("next: scanmill generate PIPELINE -o DIR --from-{} {}\n", nameOf(r.kind), folder.string());
}

void printExr(const std::filesystem::path& file) {
  const ExrReader exr(file);
  printText("{}: {} x {} pixels\n\n", file.filename().string(), exr.width(), exr.height());
  Rows rows{{"channel", "type"}};
  for (const ExrChannel& c : exr.channels()) rows.push_back({c.name, std::string(exrTypeName(c.type))});
  printText("{}\n", formatTable(rows));
  const auto& channels = exr.channels();
  if (std::any_of(channels.begin(), channels.end(), [](const ExrChannel& c) { return c.name == "range"; })) {
    printText("hits: an image row for each ring, an image column for each column of the sensor\n");
    return;
  }
  try {
    const Camera c = readCamera(exr);
    const Vec3d& t = c.worldFromCamera.translation;
    const Vec3d forward = toMatrix(c.worldFromCamera.rotation).z;
    printText("camera {}: {:.2f} x {:.2f} degrees, focal length {:.2f} x {:.2f} px, principal point {:.2f}, {:.2f}\n",
              c.name.empty() ? "without a name" : c.name, degrees(c.horizontalField()), degrees(c.verticalField()),
              c.fx, c.fy, c.cx, c.cy);
    printText("at {:.3f}, {:.3f}, {:.3f} m, looking along {:.4f}, {:.4f}, {:.4f}\n", t.x, t.y, t.z, forward.x,
              forward.y, forward.z);
  } catch (const InputError& e) {
    printText("the image cannot be used as a pass: {}\n", e.what());
  }
}

}  // namespace scanmill
