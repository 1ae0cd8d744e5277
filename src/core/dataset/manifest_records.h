#pragma once

// The descriptions of the records in manifests: see json_record.h.

#include <cstdint>
#include <string>
#include <vector>

#include "dataset/json_record.h"

namespace scanmill {

void describe(RecordKeys& keys, FormatRecord& format);
void describe(RecordKeys& keys, FileRecord& file);
void describe(RecordKeys& keys, SequenceRecord& sequence);
void describe(RecordKeys& keys, ModelledItem& item);
void describe(RecordKeys& keys, Ontology& ontology);
void describe(RecordKeys& keys, ShardRecord& shard);
void describe(RecordKeys& keys, SensorRecord& sensor);
void describe(RecordKeys& keys, ScanRecord& scan);
void describe(RecordKeys& keys, SampleRecord& sample);

// Describes a key with the name that the ontology gives to a class.
void describeClassName(RecordKeys& keys, const char* key, const std::uint16_t& id);
// Reads what is modelled. `mayBeLines`: true accepts lines of text, too, as earlier versions wrote them.
void readModelled(const JsonNode& list, bool mayBeLines, std::vector<ModelledItem>& items);
// Returns the JSON of the values that were drawn at random, or kLeftOut.
OrderedJson drawsJson(const SampleRecord& sample);

}  // namespace scanmill
