// Datasets and recordings: scans, shards, manifests, images, caches.

#include "base/error.h"
#include "base/file.h"
#include "base/hash.h"
#include "config/fields.h"
#include "dataset/manifest.h"
#include "dataset/objects.h"
#include "dataset/parts.h"
#include "dataset/reader.h"
#include "dataset/voxels.h"
#include "formats/format.h"
#include "formats/reasons_png.h"
#include "passes/exr/hits_exr.h"
#include "passes/exr/pass_exr.h"
#include "tests/fuzz/target.h"

namespace scanmill {
namespace {

FuzzTarget decoder(const FormatEntry& format) {
  return [&format](std::string_view bytes) {
    const Value none = parseYaml("{}", "options");
    Fields options(none, "options");
    format.make(options)->decode(bytes, "input");
  };
}

[[maybe_unused]] const bool kEveryFormat = [] {
  for (const FormatEntry& format : formats()) fuzzTargets()[std::string(format.name)] = decoder(format);
  return true;
}();
const AddFuzzTarget kReasons("reasons", [](std::string_view bytes) { decodeReasons(bytes, "input.png"); });

const AddFuzzTarget kTar("tar", [](std::string_view bytes) {
  const auto file = inputFile(bytes, ".tar");
  const ShardIndex index(file);
  for (const ShardMember& member : index.members()) index.read(member);
  readTar(file, [](const std::string&, std::string_view) {});
});

const AddFuzzTarget kManifest("manifest", [](std::string_view bytes) {
  const std::string text(bytes);
  static_cast<void>(digestProblem(text));
  parseManifest(text, "manifest.json");
});

const AddFuzzTarget kObjects("objects", [](std::string_view bytes) {
  Ontology ontology{"fuzz", "", {{0, "unlabeled", {}, false, {}}, {20, "car", {}, true, {}}}};
  parseObjects(bytes, "input.objects.json", ontology);
});

const AddFuzzTarget kVoxels("voxels", [](std::string_view bytes) { decodeVoxels(bytes, "input.voxels.npz"); });

const AddFuzzTarget kParts("parts", [](std::string_view bytes) {
  const bool plan = kindOf(bytes, 2) == 0;
  if (plan) {
    parsePlan(std::string(bytes), "plan");
  } else {
    parsePart(std::string(bytes), "part");
  }
});

const AddFuzzTarget kExr("exr", [](std::string_view bytes) {
  const bool hits = kindOf(bytes, 2) == 0;
  const auto file = inputFile(bytes, ".exr");
  if (hits) {
    Hits read;
    readHits(file, Channels::all(), read);
  } else {
    readPasses(file, passesIn(file));
  }
});

}  // namespace
}  // namespace scanmill
