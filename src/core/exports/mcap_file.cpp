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

#include <fmt/core.h>
#include <lz4frame.h>
#include <zlib.h>

#include <algorithm>

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

void putText(std::string_view text, std::string& bytes) {
  putNumber(static_cast<std::uint32_t>(text.size()), bytes);
  bytes += text;
}

void putMap(const McapMap& values, std::string& bytes) {
  std::string entries;
  for (const auto& [key, value] : values) {
    putText(key, entries);
    putText(value, entries);
  }
  putText(entries, bytes);
}

void putHead(Kind kind, std::size_t length, std::string& bytes) {
  putNumber(static_cast<std::uint8_t>(kind), bytes);
  putNumber(std::uint64_t{length}, bytes);
}

std::string record(Kind kind, std::string_view content) {
  std::string bytes;
  putHead(kind, content.size(), bytes);
  bytes += content;
  return bytes;
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
  if (LZ4F_isError(size) != 0) throw Error(fmt::format("LZ4 compression failed: {}", LZ4F_getErrorName(size)));
  out.resize(size);
  return out;
}

}  // namespace

void McapFile::TimeSpan::add(std::uint64_t time) {
  first = empty ? time : std::min(first, time);
  last = std::max(last, time);
  empty = false;
}

McapFile::McapFile(const std::filesystem::path& path, std::string_view profile, std::string_view library)
    : file_(path) {
  std::string content;
  putText(profile, content);
  putText(library, content);
  write(kMagic);
  write(record(Kind::Header, content));
}

void McapFile::addMetadata(std::string_view name, const McapMap& values) {
  std::string content;
  putText(name, content);
  putMap(values, content);
  const std::string metadata = record(Kind::Metadata, content);
  std::string index;
  putNumber(std::uint64_t{file_.size()}, index);
  putNumber(std::uint64_t{metadata.size()}, index);
  putText(name, index);
  metadataIndices_ += record(Kind::MetadataIndex, index);
  ++metadataCount_;
  write(metadata);
}

std::uint16_t McapFile::addSchema(std::string_view name, std::string_view encoding, std::string_view text) {
  const std::uint16_t id = ++schemaCount_;  // ids start at 1, because 0 means that a channel has no schema
  std::string content;
  putNumber(id, content);
  putText(name, content);
  putText(encoding, content);
  putText(text, content);
  const std::string schema = record(Kind::Schema, content);
  schemas_ += schema;
  chunk_ += schema;
  return id;
}

std::uint16_t McapFile::addChannel(std::uint16_t schema, std::string_view topic, std::string_view encoding,
                                   const McapMap& metadata) {
  const auto id = static_cast<std::uint16_t>(messageCounts_.size());
  messageCounts_[id] = 0;
  std::string content;
  putNumber(id, content);
  putNumber(schema, content);
  putText(topic, content);
  putText(encoding, content);
  putMap(metadata, content);
  const std::string channel = record(Kind::Channel, content);
  channels_ += channel;
  chunk_ += channel;
  return id;
}

void McapFile::addMessage(std::uint16_t channel, std::uint64_t time, std::string_view data) {
  std::uint64_t& count = messageCounts_.at(channel);
  std::string head;
  putNumber(channel, head);
  putNumber(static_cast<std::uint32_t>(count++), head);
  putNumber(time, head);  // time of recording
  putNumber(time, head);  // time of publishing
  chunkMessages_[channel].emplace_back(time, chunk_.size());
  putHead(Kind::Message, head.size() + data.size(), chunk_);
  chunk_ += head;
  chunk_ += data;
  chunkTimes_.add(time);
  times_.add(time);
  if (chunk_.size() >= kChunkBytes) endChunk();
}

void McapFile::endChunk() {
  if (chunk_.empty()) return;
  std::string packed = compressed(chunk_);
  const bool smaller = packed.size() < chunk_.size();
  const std::string_view stored = smaller ? packed : chunk_;
  const std::string_view compression = smaller ? "lz4" : "";

  std::string content;
  putNumber(chunkTimes_.first, content);
  putNumber(chunkTimes_.last, content);
  putNumber(std::uint64_t{chunk_.size()}, content);
  putNumber(crcOf(chunk_), content);
  putText(compression, content);
  putNumber(std::uint64_t{stored.size()}, content);
  std::string head;
  putHead(Kind::Chunk, content.size() + stored.size(), head);
  const std::size_t start = file_.size();
  write(head);
  write(content);
  write(stored);

  const std::size_t end = file_.size();
  std::string offsets;
  for (const auto& [channel, messages] : chunkMessages_) {
    putNumber(channel, offsets);
    putNumber(std::uint64_t{file_.size()}, offsets);
    std::string entries;
    for (const auto& [time, offset] : messages) {
      putNumber(time, entries);
      putNumber(offset, entries);
    }
    std::string index;
    putNumber(channel, index);
    putText(entries, index);
    write(record(Kind::MessageIndex, index));
  }

  std::string index;
  putNumber(chunkTimes_.first, index);
  putNumber(chunkTimes_.last, index);
  putNumber(std::uint64_t{start}, index);
  putNumber(std::uint64_t{end - start}, index);
  putText(offsets, index);
  putNumber(std::uint64_t{file_.size() - end}, index);
  putText(compression, index);
  putNumber(std::uint64_t{stored.size()}, index);
  putNumber(std::uint64_t{chunk_.size()}, index);
  chunkIndices_ += record(Kind::ChunkIndex, index);
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
    putNumber(channel, counts);
    putNumber(count, counts);
  }
  std::string content;
  putNumber(messages, content);
  putNumber(schemaCount_, content);
  putNumber(static_cast<std::uint32_t>(messageCounts_.size()), content);
  putNumber(std::uint32_t{0}, content);  // attachments
  putNumber(metadataCount_, content);
  putNumber(chunkCount_, content);
  putNumber(times_.first, content);
  putNumber(times_.last, content);
  putText(counts, content);
  return record(Kind::Statistics, content);
}

void McapFile::commit() {
  endChunk();
  std::string dataEnd;
  putNumber(crc_, dataEnd);
  write(record(Kind::DataEnd, dataEnd));

  const std::size_t start = file_.size();
  std::string summary;
  std::string offsets;
  const auto addGroup = [&](Kind kind, const std::string& records) {
    if (records.empty()) return;
    std::string offset;
    putNumber(static_cast<std::uint8_t>(kind), offset);
    putNumber(std::uint64_t{start + summary.size()}, offset);
    putNumber(std::uint64_t{records.size()}, offset);
    offsets += record(Kind::SummaryOffset, offset);
    summary += records;
  };
  addGroup(Kind::Schema, schemas_);
  addGroup(Kind::Channel, channels_);
  addGroup(Kind::Statistics, statistics());
  addGroup(Kind::ChunkIndex, chunkIndices_);
  addGroup(Kind::MetadataIndex, metadataIndices_);
  const std::size_t offsetsStart = start + summary.size();
  summary += offsets;

  putHead(Kind::Footer, 2 * sizeof(std::uint64_t) + sizeof(std::uint32_t), summary);
  putNumber(std::uint64_t{start}, summary);
  putNumber(std::uint64_t{offsetsStart}, summary);
  putNumber(crcOf(summary), summary);
  write(summary);
  write(kMagic);
  file_.commit();
}

void McapFile::write(std::string_view bytes) {
  crc_ = crcOf(bytes, crc_);
  file_.write(bytes);
}

}  // namespace scanmill
