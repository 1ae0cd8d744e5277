// Writes the container format MCAP, version 0 (specification: mcap.dev/spec, registry of names:
// mcap.dev/spec/registry):
//
//   magic, Header
//   Metadata
//   Chunk (Schemas and Channels before their first message, Messages), a MessageIndex for each of its channels
//   ...
//   DataEnd
//   summary: Schemas, Channels, Statistics, ChunkIndices, MetadataIndices, and a SummaryOffset for each of these groups
//   Footer, magic
//
// A record consists of a byte for its kind, the length of its content (uint64) and the content; numbers are
// little-endian. A chunk is compressed as an LZ4 frame, unless that makes it larger. Check sums are the CRC-32 of zlib.

#include "exports/mcap_file.h"

#include <lz4frame.h>
#include <zlib.h>

#include "base/error.h"
#include "formats/little_endian.h"

namespace scanmill {

namespace {

enum class Kind : std::uint8_t {
  Header = 0x01,
  Footer = 0x02,
  Schema = 0x03,
  Channel = 0x04,
  Message = 0x05,
  Chunk = 0x06,
  MessageIndex = 0x07,
  ChunkIndex = 0x08,
  Statistics = 0x0B,
  Metadata = 0x0C,
  MetadataIndex = 0x0D,
  SummaryOffset = 0x0E,
  DataEnd = 0x0F,
};

constexpr std::string_view kMagic("\x89MCAP0\r\n", 8);
constexpr std::size_t kChunkBytes = std::size_t{4} << 20;  // a chunk ends when it reaches this size

template <class Number>
requires std::is_arithmetic_v<Number>
void put(Number value, std::string& bytes) {
  putNumber(value, bytes);
}

void put(std::string_view text, std::string& bytes) {
  putNumber(static_cast<std::uint32_t>(text.size()), bytes);
  bytes += text;
}

void put(const McapMap& values, std::string& bytes) {
  std::string entries;
  for (const auto& [key, value] : values) {
    put(key, entries);
    put(value, entries);
  }
  put(entries, bytes);
}

// Returns the bytes of some fields of a record, in their order. Texts and maps begin with their length (uint32).
template <class... Fields>
std::string fieldsOf(const Fields&... fields) {
  std::string bytes;
  (put(fields, bytes), ...);
  return bytes;
}

// Returns the bytes before the content of a record.
std::string headOf(Kind kind, std::size_t length) {
  return fieldsOf(static_cast<std::uint8_t>(kind), std::uint64_t{length});
}

template <class... Fields>
std::string record(Kind kind, const Fields&... fields) {
  const std::string content = fieldsOf(fields...);
  return headOf(kind, content.size()) + content;
}

std::uint32_t crcOf(std::string_view bytes, std::uint32_t before = 0) {
  return static_cast<std::uint32_t>(crc32_z(before, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size()));
}

std::string compressed(std::string_view bytes) {
  LZ4F_preferences_t preferences{};
  preferences.frameInfo.blockSizeID = LZ4F_max4MB;
  preferences.frameInfo.contentSize = bytes.size();
  std::string out(LZ4F_compressFrameBound(bytes.size(), &preferences), '\0');
  const std::size_t size = LZ4F_compressFrame(out.data(), out.size(), bytes.data(), bytes.size(), &preferences);
  if (LZ4F_isError(size) != 0) throw Error("LZ4 compression failed: {}", LZ4F_getErrorName(size));
  out.resize(size);
  return out;
}

}  // namespace

McapFile::McapFile(const std::filesystem::path& path, std::string_view profile, std::string_view library)
    : file_(path) {
  write(kMagic);
  write(record(Kind::Header, profile, library));
}

void McapFile::addMetadata(std::string_view name, const McapMap& values) {
  const std::string metadata = record(Kind::Metadata, name, values);
  metadataIndices_ += record(Kind::MetadataIndex, std::uint64_t{file_.size()}, std::uint64_t{metadata.size()}, name);
  ++metadataCount_;
  write(metadata);
}

std::uint16_t McapFile::addSchema(std::string_view name, std::string_view encoding, std::string_view text) {
  const std::uint16_t id = ++schemaCount_;  // ids start at 1, because 0 means that a channel has no schema
  const std::string schema = record(Kind::Schema, id, name, encoding, text);
  schemas_ += schema;
  chunk_ += schema;
  return id;
}

std::uint16_t McapFile::addChannel(std::uint16_t schema, std::string_view topic, std::string_view encoding,
                                   const McapMap& metadata) {
  const auto id = static_cast<std::uint16_t>(messageCounts_.size());
  messageCounts_[id] = 0;
  const std::string channel = record(Kind::Channel, id, schema, topic, encoding, metadata);
  channels_ += channel;
  chunk_ += channel;
  return id;
}

void McapFile::addMessage(std::uint16_t channel, std::uint64_t time, std::string_view data) {
  std::uint64_t& count = messageCounts_.at(channel);
  // The record has the time of recording and then the time of publishing; both are `time`.
  const std::string fields = fieldsOf(channel, static_cast<std::uint32_t>(count++), time, time);
  chunkMessages_[channel].emplace_back(time, chunk_.size());
  chunk_ += headOf(Kind::Message, fields.size() + data.size());
  chunk_ += fields;
  chunk_ += data;
  chunkTimes_.add(time);
  times_.add(time);
  if (chunk_.size() >= kChunkBytes) endChunk();
}

// Writes the current chunk with the message indices of its channels, and adds its chunk index to the summary.
void McapFile::endChunk() {
  if (chunk_.empty()) return;
  const std::string compressedChunk = compressed(chunk_);
  const bool isSmaller = compressedChunk.size() < chunk_.size();
  const std::string_view stored = isSmaller ? compressedChunk : chunk_;
  const std::string_view compression = isSmaller ? "lz4" : "";

  const std::string fields = fieldsOf(chunkTimes_.first, chunkTimes_.last, std::uint64_t{chunk_.size()}, crcOf(chunk_),
                                      compression, std::uint64_t{stored.size()});
  const std::size_t start = file_.size();
  write(headOf(Kind::Chunk, fields.size() + stored.size()));
  write(fields);
  write(stored);
  const std::size_t end = file_.size();

  std::string offsets;
  for (const auto& [channel, messages] : chunkMessages_) {
    offsets += fieldsOf(channel, std::uint64_t{file_.size()});
    std::string entries;
    for (const auto& [time, offset] : messages) entries += fieldsOf(time, offset);
    write(record(Kind::MessageIndex, channel, entries));
  }
  chunkIndices_ += record(Kind::ChunkIndex, chunkTimes_.first, chunkTimes_.last, std::uint64_t{start},
                          std::uint64_t{end - start}, offsets, std::uint64_t{file_.size() - end}, compression,
                          std::uint64_t{stored.size()}, std::uint64_t{chunk_.size()});
  ++chunkCount_;

  chunk_.clear();
  chunkMessages_.clear();
  chunkTimes_ = {};
}

std::string McapFile::statistics() const {
  std::uint64_t messages = 0;
  std::string counts;
  for (const auto& [channel, count] : messageCounts_) {
    messages += count;
    counts += fieldsOf(channel, count);
  }
  constexpr std::uint32_t kAttachments = 0;
  return record(Kind::Statistics, messages, schemaCount_, static_cast<std::uint32_t>(messageCounts_.size()),
                kAttachments, metadataCount_, chunkCount_, times_.first, times_.last, counts);
}

void McapFile::commit() {
  endChunk();
  write(record(Kind::DataEnd, crc_));

  const std::size_t start = file_.size();
  std::string summary;
  std::string offsets;
  const auto addGroup = [&](Kind kind, const std::string& records) {
    if (records.empty()) return;
    offsets += record(Kind::SummaryOffset, static_cast<std::uint8_t>(kind), std::uint64_t{start + summary.size()},
                      std::uint64_t{records.size()});
    summary += records;
  };
  addGroup(Kind::Schema, schemas_);
  addGroup(Kind::Channel, channels_);
  addGroup(Kind::Statistics, statistics());
  addGroup(Kind::ChunkIndex, chunkIndices_);
  addGroup(Kind::MetadataIndex, metadataIndices_);
  const std::size_t offsetsStart = start + summary.size();
  summary += offsets;

  summary += headOf(Kind::Footer, 2 * sizeof(std::uint64_t) + sizeof(std::uint32_t));
  summary += fieldsOf(std::uint64_t{start}, std::uint64_t{offsetsStart});
  put(crcOf(summary), summary);
  write(summary);
  write(kMagic);
  file_.commit();
}

void McapFile::write(std::string_view bytes) {
  crc_ = crcOf(bytes, crc_);
  file_.write(bytes);
}

}  // namespace scanmill
