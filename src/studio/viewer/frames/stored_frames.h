#pragma once

// Loads frames whose scans are on disk.

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

#include "dataset/manifest.h"
#include "dataset/scan_store.h"
#include "scan/scan.h"
#include "sensors/beams.h"
#include "viewer/frames/frame_source.h"

namespace scanmill {

class StoredFrames : public FrameSource {
 public:
  explicit StoredFrames(const ViewInput& input);

  std::string title() const override { return stores_.front().label; }
  const std::vector<std::string>& keys() const override { return mainStore().keys(); }
  const Ontology* ontology() const override { return ontology_ ? &*ontology_ : nullptr; }
  ViewFrame load(std::size_t frame) const override;
  std::vector<Pose> trajectory(std::size_t frame) const override;
  std::optional<SceneChoice> scene(std::size_t frame, std::string& why) const override;
  std::optional<std::filesystem::path> vehicle() const override;
  std::vector<std::uint16_t> classes() const override;

 private:
  struct Store {
    std::unique_ptr<const ScanStore> scans;
    std::string label;              // name of the file or folder, or its path if another store has the same name
    std::string classDifference{};  // text about a class whose name differs from the shown name; may be empty
  };
  struct Loading;

  const ScanStore& mainStore() const { return *stores_.front().scans; }
  void checkJoins() const;
  void chooseOntology();
  std::vector<Loading> findScans(const std::string& key, std::vector<std::string>& problems) const;
  void loadScan(Loading& loading, const std::string& key, bool sensorsDiffer) const;
  void addError(Loading& loading, const std::string& key, bool sensorsDiffer) const;
  void addReferenceError(ViewScan& scan, const std::string& key) const;
  void nameScans(std::vector<Loading>& scans) const;
  bool isShown(const ScanRecord& scan) const;
  const ScanRecord* firstScan(const std::string& key) const;
  std::optional<Pose> vehiclePose(const std::string& key) const;

  ViewInput input_;
  std::vector<Store> stores_;  // first the main store, then the stores that are shown on top of it
  std::unique_ptr<const ScanStore> reference_;
  std::optional<Ontology> ontology_;
  // The samples of each sequence, in the order of frames; the keys are the sequences' names.
  std::unordered_map<std::string, std::vector<const SampleRecord*>> sequences_;
};

// Returns the scene of a sequence at a time (s since the drive began). If the scene is not found or `sequence` is null,
// returns nothing, and `why` receives the reason.
std::optional<SceneChoice> sceneOf(const SequenceRecord* sequence, const std::filesystem::path& datasetFolder,
                                   double time, std::string& why);

// Returns the distance (m) of each point from the point of the same beam and return in the noise-free reference. The
// distance is NaN if the beam has no return in the reference, and for false positives, which come from no surface.
// Corresponding points have the same ring, column and return number; in an organised scan these follow from the
// position in the image.
//
// The return numbers of a beam start with the nearest return in each scan. They identify the same surface only if the
// beam has the same number of returns in both scans. If drop-out or false positives have changed the returns, or if a
// scan does not number its returns, each point is compared with the nearest of the beam's returns in the reference.
// This return is from the same surface as long as the noise is less than half the distance between two surfaces.
//
// Returns nothing if the scans cannot be compared; then `why` receives the reason as a text for the user.
std::vector<float> referenceErrors(const Scan& scan, const Scan& reference, std::string& why);

// Returns the absolute difference (m) between each point's range and its column `range_true`; NaN if a point has no
// range. Ranges are measured from the beam's origin, or from the sensor's origin if `beams` is null or the scan does
// not assign points to beams. Returns nothing if the scan has no column `range_true`.
std::vector<float> rangeErrors(const Scan& scan, const BeamTable* beams);

}  // namespace scanmill
