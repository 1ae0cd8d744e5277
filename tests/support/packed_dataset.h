#pragma once

// Datasets of samples at hand: a shard of a split is closed before it would exceed so many bytes.

#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "base/hash.h"
#include "dataset/dataset_folder.h"
#include "dataset/names.h"
#include "dataset/shard_writer.h"

namespace scanmill {

class PackedDataset {
 public:
  PackedDataset(std::filesystem::path folder, bool replace, std::uint64_t shardBytes)
      : folder_(std::move(folder), replace ? FolderUse::Replace : FolderUse::New, DatasetPlan{"packed", 0, {}}),
        shardBytes_(shardBytes) {}

  void add(const Sample& sample) {
    std::uint64_t bytes = 2048;  // of the sample's description
    for (const Member& m : sample.files) bytes += ShardFile::memberBytes(120, m.bytes.size());
    std::unique_ptr<ShardWriter>& shard = open_[sample.split];
    std::uint64_t& size = size_[sample.split];
    if (shard && size + bytes > shardBytes_) close(sample.split);
    if (!shard) {
      size = ShardFile::kEndBytes;
      shard = std::make_unique<ShardWriter>(folder_.staging(), shardName(sample.split, count_[sample.split]++),
                                            sample.split);
      number_[sample.split] = parts_.size();
      parts_.emplace_back();
    }
    shard->add(sample);
    size += bytesInShard(sample);
    order_.push_back(sample.key);
  }

  void finish(Manifest& manifest) {
    for (auto& [split, shard] : open_) {
      if (shard) close(split);
    }
    manifest.shards.clear();
    manifest.samples.clear();
    std::map<std::string, SampleRecord> records;
    for (ShardPart& part : parts_) {
      Manifest own = manifest;
      own.shards = {part.shard};
      own.samples = part.samples;
      folder_.storeRecord({"packed", {}, own});
      for (SampleRecord& record : part.samples) {
        record.shard = static_cast<std::uint32_t>(manifest.shards.size());
        const std::string key = record.key;
        records[key] = std::move(record);
      }
      manifest.shards.push_back(part.shard);
    }
    for (const std::string& key : order_) manifest.samples.push_back(records.at(key));
    folder_.publish(manifest);
  }

 private:
  void close(const std::string& split) { parts_[number_[split]] = std::exchange(open_[split], nullptr)->finish(); }

  DatasetFolder folder_;
  std::uint64_t shardBytes_;
  std::map<std::string, std::unique_ptr<ShardWriter>> open_;
  std::map<std::string, std::uint64_t> size_;  // bytes of the open shard of a split
  std::map<std::string, std::uint64_t> count_;
  std::map<std::string, std::size_t> number_;  // of the open shard of a split, among all
  std::vector<ShardPart> parts_;               // in the order in which they were opened
  std::vector<std::string> order_;
};

}  // namespace scanmill
