#pragma once

// Writes a dataset sample by sample, for programs that decide in a loop of their own what each sample shows. Shards,
// manifest and locks are those of generate(), and so are the bytes of a sample with the same key and shots. An
// interrupted loop can be continued, if it gives the same frames in the same order again.
//
//   DatasetWriter writer({.folder = "out/loop"});
//   for (...) {
//     if (writer.hasNext(source, sequence, frame)) continue;  // an earlier run has written the sample
//     writer.add(source, sequence, makeSample(plan, scene, sequence, frame, work));
//   }
//   writer.finish();

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "dataset/dataset_folder.h"
#include "dataset/manifest.h"
#include "dataset/parts.h"
#include "dataset/shard_writer.h"
#include "pipeline/run/sample_maker.h"
#include "pipeline/scenes/shot_source.h"

namespace scanmill {

class DatasetWriter {
 public:
  struct Options {
    std::filesystem::path folder;
    FolderUse use = FolderUse::New;    // New, Replace or Resume
    std::uint64_t shardSamples = 100;  // number of samples in a shard; the last shard of a split may have fewer
  };
  // Throws InputError if the folder contains something that `use` does not allow. Creates nothing yet.
  explicit DatasetWriter(Options options);

  // Returns the index of a sequence in the order of first use, and the number of its samples so far. Together they are
  // the address of the next frame's random numbers.
  std::uint32_t indexOf(const Sequence& sequence);
  std::uint32_t framesOf(const Sequence& sequence) const;

  // Returns true if the next sample need not be made, since an interrupted run, or a complete run of the same loop, has
  // written it; the sample then counts as added. `placed`: a text that tells the poses and velocities of the objects
  // that the caller places. Throws InputError if that sample has another key, time, pose or text (a complete run has no
  // texts), and if the sequence has samples in another split.
  [[nodiscard]] bool hasNext(const ShotSource& source, const Sequence& sequence, const Frame& frame,
                             const std::string& placed);
  // Adds a sample, for which hasNext() has returned false. The first sample of each shard of an earlier run is made
  // again and compared with the shard, which shows whether scenes, objects and effects are still the same. All samples
  // must be of plans with the same sensors, effects and output. Throws InputError if the sample's scene has other
  // classes than the scenes before, and if the bytes differ from those of the earlier run.
  void add(const ShotSource& source, const Sequence& sequence, MadeSample made);
  // Completes the dataset and returns its manifest. Throws Error if there is no sample, or fewer than a complete shard
  // of the interrupted run has. Call no other function after this one.
  Manifest finish();

 private:
  struct OpenShard {
    OpenShard(const std::filesystem::path& folder, const std::string& name, const std::string& split)
        : writer(folder, name, split) {}
    ShardWriter writer;
    DatasetPart part;
  };
  struct Split {
    std::string name;
    std::uint64_t shards = 0;             // number of shards so far
    std::unique_ptr<OpenShard> open;      // null: the latest shard is complete
    std::optional<DatasetPart> complete;  // the latest shard, if an earlier run has completed it
    std::size_t passed = 0;               // number of its samples that the loop has given again
  };

  void open(const ShotSource& source);
  Split& splitOf(const std::string& name);
  const SampleRecord* written(const Sequence& sequence);
  void close(Split& split);

  Options options_;
  DatasetPlan plan_;
  std::unique_ptr<DatasetFolder> folder_;        // null: no sample yet, or `whole_`
  std::optional<Manifest> whole_;                // the complete dataset of the same loop; nothing: there is none
  std::vector<Split> splits_;                    // in the order of first use
  std::vector<std::string> sequences_;           // keys of the sequences, in the order of first use
  std::map<std::string, std::uint32_t> frames_;  // number of samples, by the key of the sequence
  std::map<std::string, std::string> splitOf_;   // split, by the key of the sequence
  std::string placed_;                           // hash of the text that hasNext() got last
  std::string classes_;                          // the ontology of all scenes, as JSON; empty: no sample yet
  const SampleRecord* compared_ = nullptr;       // the sample of an earlier run that the next add() compares
  TraceAccount account_;
};

}  // namespace scanmill
