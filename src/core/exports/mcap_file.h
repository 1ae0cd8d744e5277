#pragma once

// Writes files in the container format MCAP: messages of topics with their times, in compressed and indexed chunks.

#include <algorithm>
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

// Only the current chunk and the indices of earlier chunks are in memory. Calls throw the Errors of AtomicFile. Without
// commit() no file remains on the disk.
class McapFile {
 public:
  // `profile`: a name from the specification's registry, such as "ros2". `library`: the program that writes the file.
  McapFile(const std::filesystem::path& path, std::string_view profile, std::string_view library);

  // Adds a named list of keys and values, which is independent of the messages.
  void addMetadata(std::string_view name, const McapMap& values);
  // Add a schema or a channel. Return its id, the argument `schema` of addChannel() or `channel` of addMessage().
  std::uint16_t addSchema(std::string_view name, std::string_view encoding, std::string_view text);
  std::uint16_t addChannel(std::uint16_t schema, std::string_view topic, std::string_view encoding,
                           const McapMap& metadata);
  // Adds a message. `time`: ns, used as the time of publishing and of recording. Times may come in any order.
  void addMessage(std::uint16_t channel, std::uint64_t time, std::string_view data);
  // Writes the summary and gives the file its final name. Nothing can be added afterwards.
  void commit();

 private:
  struct TimeSpan {
    std::uint64_t first = 0;
    std::uint64_t last = 0;
    bool empty = true;
    void add(std::uint64_t time) {
      first = empty ? time : std::min(first, time);
      last = std::max(last, time);
      empty = false;
    }
  };

  void write(std::string_view bytes);
  void endChunk();
  std::string statistics() const;

  AtomicFile file_;
  std::uint32_t crc_ = 0;  // CRC-32 of all bytes written so far

  std::string chunk_;  // records of the current chunk, uncompressed
  TimeSpan chunkTimes_;
  // Messages of the current chunk, by channel: time (ns) and offset in chunk_.
  std::map<std::uint16_t, std::vector<std::pair<std::uint64_t, std::uint64_t>>> chunkMessages_;

  // Records of the summary at the end of the file.
  std::string schemas_;
  std::string channels_;
  std::string chunkIndices_;
  std::string metadataIndices_;

  std::uint16_t schemaCount_ = 0;
  std::uint32_t chunkCount_ = 0;
  std::uint32_t metadataCount_ = 0;
  // Number of messages by channel, which is also the channel's next sequence number.
  std::map<std::uint16_t, std::uint64_t> messageCounts_;
  TimeSpan times_;
};

}  // namespace scanmill
