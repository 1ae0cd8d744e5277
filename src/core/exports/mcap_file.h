#pragma once

// Writes the container MCAP: messages of topics with their times, in compressed and indexed chunks.

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/file.h"

namespace scanmill {

using McapMap = std::map<std::string, std::string>;

// Memory holds the chunk that is being filled and the indices of those before. Calls throw the Errors of AtomicFile;
// without commit() nothing is left on the disk.
class McapFile {
 public:
  // `profile`: of the specification's registry, "ros2". `library`: the program that writes.
  McapFile(const std::filesystem::path& path, std::string_view profile, std::string_view library);

  // A named list of keys and values, beside the messages.
  void addMetadata(std::string_view name, const McapMap& values);
  // Give the number that channels and messages name them by.
  std::uint16_t addSchema(std::string_view name, std::string_view encoding, std::string_view text);
  std::uint16_t addChannel(std::uint16_t schema, std::string_view topic, std::string_view encoding,
                           const McapMap& metadata);
  // `time`: ns, at which it is both published and recorded. Times may come in any order.
  void addMessage(std::uint16_t channel, std::uint64_t time, std::string_view data);
  // Writes the summary and gives the file its name. Nothing can be added afterwards.
  void commit();

 private:
  struct TimeSpan {
    std::uint64_t first = 0;
    std::uint64_t last = 0;
    bool empty = true;
    void add(std::uint64_t time);
  };

  void write(std::string_view bytes);
  void endChunk();
  std::string statistics() const;

  AtomicFile file_;
  std::uint32_t crc_ = 0;  // of all that was written

  std::string chunk_;  // its records, uncompressed
  TimeSpan chunkTimes_;
  std::map<std::uint16_t, std::vector<std::pair<std::uint64_t, std::uint64_t>>> chunkMessages_;  // time and offset

  // Records of the summary.
  std::string schemas_;
  std::string channels_;
  std::string chunkIndices_;
  std::string metadataIndices_;

  std::uint16_t schemaCount_ = 0;
  std::uint32_t chunkCount_ = 0;
  std::uint32_t metadataCount_ = 0;
  std::map<std::uint16_t, std::uint64_t> messageCounts_;  // by channel; they number messages too
  TimeSpan times_;
};

}  // namespace scanmill
