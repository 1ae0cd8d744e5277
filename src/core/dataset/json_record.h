#pragma once

// Each record in the JSON files of datasets and recordings is described once, by a function describe() that names the
// keys in the order of the file and the limits of their values. The writer and the strict reader call describe().
//
//   void describe(RecordKeys& keys, ObjectCount& count) {
//     keys("objects", count.objects, wholeNumber(1));
//     keys("with_points", count.withPoints, wholeNumber(0, count.objects));
//   }
//
// A limit is a function of a JsonNode. It throws if the value, which has already been read, is not allowed.

#include <cstdint>
#include <limits>
#include <memory>
#include <set>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "dataset/json_text.h"
#include "dataset/manifest.h"

namespace scanmill {

inline const OrderedJson kAbsent(OrderedJson::value_t::discarded);

// Data that describe() needs beside a record of a sample or scan.
struct RecordContext {
  const Ontology* ontology = nullptr;  // null: names of classes are left out
  const Manifest* head = nullptr;      // the manifest without its samples
};

// Returns the JSON of a value or record. Throws Error for numbers that are not finite; the message begins with `name`.
template <class T>
OrderedJson jsonOf(const T& value, const std::string& name, const RecordContext& context = {});
// Reads a value or record. Throws InputError for keys and values that the description does not allow.
template <class T>
void readJson(const JsonNode& node, T& value, const RecordContext& context = {});

// The argument of describe(). Depending on the constructor it collects the keys of a record, writes a record to `json`,
// or reads a record.
class RecordKeys {
 public:
  RecordKeys() = default;  // collects the keys
  // Constructs an object that writes a record. `name`: the record's name in error messages.
  RecordKeys(std::string name, const RecordContext& records)
      : context(records), mode_(Mode::Write), name_(std::move(name)) {}
  // Constructs an object that reads `node`, which must outlive it. JsonNode::keys() must have checked the node's keys.
  RecordKeys(const JsonNode& node, const RecordContext& records) : context(records), mode_(Mode::Read), node_(&node) {}

  // Describes a key that every record has. `limits`: functions that check the key's value in reading, such as within().
  template <class T, class... Limits>
  void operator()(const char* key, T& value, const Limits&... limits) {
    custom(key, writing(key, value), reading(value, limits...));
  }
  // Describes a key that is always written, but may be missing in reading: `value` is then left as it is.
  template <class T, class... Limits>
  void mayBeMissing(const char* key, T& value, const Limits&... limits) {
    optionalIf(true, key, value, limits...);
  }
  // Describes a key that is left out if the value equals T{}: 0, an empty text, an empty list, ...
  template <class T, class... Limits>
  void optional(const char* key, T& value, const Limits&... limits) {
    optionalIf(value != T{}, key, value, limits...);
  }
  // Describes a key that is left out unless `written` is true.
  template <class T, class... Limits>
  void optionalIf(bool written, const char* key, T& value, const Limits&... limits) {
    const auto write = writing(key, value);
    customOptional(
        key, [&] { return written ? write() : kAbsent; }, reading(value, limits...));
  }
  // Describes a key whose value is always `text`. A record with another text is refused.
  void fixed(const char* key, std::string_view text) {
    custom(
        key, [&] { return OrderedJson(text); },
        [&](const JsonNode& node) {
          if (node.text() != text) node.fail("is not '{}'", text);
        });
  }
  // Describes a required key. write() returns the value as JSON (kAbsent: not written), read(node) reads the value.
  template <class Write, class Read>
  void custom(const char* key, const Write& write, const Read& read) {
    if (mode_ == Mode::Collect) requiredKeys.emplace_back(key);
    if (mode_ == Mode::Write) put(key, write());
    if (node_ != nullptr) read((*node_)[key]);
  }
  // Describes a key like custom(), but the key may be missing: read() is then not called.
  template <class Write, class Read>
  void customOptional(const char* key, const Write& write, const Read& read) {
    if (mode_ == Mode::Collect) optionalKeys.emplace_back(key);
    if (mode_ == Mode::Write) put(key, write());
    if (node_ != nullptr && node_->has(key)) read((*node_)[key]);
  }
  // Describes a nested map. describeMap(keys) describes the keys of this map.
  template <class Describe>
  void map(const char* key, const Describe& describeMap) {
    const auto write = [&] {
      RecordKeys nested(name_ + "/" + key, context);
      describeMap(nested);
      return nested.json;
    };
    custom(key, write, [&](const JsonNode& node) {
      RecordKeys collected, nested(node, context);
      describeMap(collected);
      node.keys(collected.requiredKeys, collected.optionalKeys);
      describeMap(nested);
    });
  }

  bool reads() const { return mode_ == Mode::Read; }

  RecordContext context;
  std::vector<std::string_view> requiredKeys, optionalKeys;  // the keys that were collected
  OrderedJson json = OrderedJson::object();                  // the record that was written

 private:
  enum class Mode { Collect, Write, Read };

  void put(const char* key, OrderedJson value) {
    if (!value.is_discarded()) json[key] = std::move(value);
  }
  template <class T>
  auto writing(const char* key, const T& value) const {
    return [this, key, &value] { return jsonOf(value, name_ + "/" + key, context); };
  }
  template <class T, class... Limits>
  auto reading(T& value, const Limits&... limits) const {
    return [&](const JsonNode& node) {
      readJson(node, value, context);
      (limits(node), ...);
    };
  }

  Mode mode_ = Mode::Collect;
  std::string name_;
  const JsonNode* node_ = nullptr;  // null unless a record is read
};

// An std::optional or a smart pointer.
template <class T>
concept Nullable = requires(const T& value) {
  *value;
};
template <class T>
concept List = requires(T& list) {
  list.emplace_back();
};

// Returns a value as JSON. A type without a branch below must have a describe(), which describes its keys. A nullable
// value must not be null. Throws an Error that begins with `name` for infinities and NaN.
template <class T>
OrderedJson jsonOf(const T& value, const std::string& name, const RecordContext& context) {
  if constexpr (std::is_floating_point_v<T>) {
    return finite(double{value}, name);
  } else if constexpr (std::is_same_v<T, Pose>) {
    return poseJson(value, name);
  } else if constexpr (std::is_same_v<T, Vec3d>) {
    return finiteList({value.x, value.y, value.z}, name);
  } else if constexpr (Nullable<T>) {
    return jsonOf(*value, name, context);
  } else if constexpr (std::is_same_v<T, std::vector<double>>) {
    return finiteList(value, name);
  } else if constexpr (List<T>) {
    OrderedJson list = OrderedJson::array();
    for (const auto& item : value) list.push_back(jsonOf(item, fmt::format("{}/{}", name, list.size()), context));
    return list;
  } else if constexpr (std::is_constructible_v<OrderedJson, const T&>) {  // integers, bools and texts
    return OrderedJson(value);
  } else {
    RecordKeys keys(name, context);
    describe(keys, const_cast<T&>(value));  // describe() takes a reference for reading; writing changes nothing
    return std::move(keys.json);
  }
}

template <class T>
void readJson(const JsonNode& node, T& value, const RecordContext& context) {
  if constexpr (std::is_same_v<T, bool>) {
    value = node.boolean();
  } else if constexpr (std::is_same_v<T, std::string>) {
    value = node.text();
  } else if constexpr (std::is_integral_v<T>) {
    value = node.integer<T>();
  } else if constexpr (std::is_floating_point_v<T>) {
    value = static_cast<T>(node.number());
  } else if constexpr (std::is_same_v<T, Pose>) {
    value = poseOf(node);
  } else if constexpr (std::is_same_v<T, Vec3d>) {
    const std::vector<double> v = node.numbers(3);
    value = {v[0], v[1], v[2]};
  } else if constexpr (std::is_same_v<T, std::array<std::uint8_t, 3>>) {  // a colour
    node.numbers(value.size());
    for (std::size_t i = 0; i < value.size(); ++i) value[i] = node.item(i).template integer<std::uint8_t>();
  } else if constexpr (Nullable<T>) {
    std::remove_cvref_t<decltype(*value)> content;
    readJson(node, content, context);
    if constexpr (std::is_assignable_v<T&, decltype(content)>) {
      value = std::move(content);
    } else {
      value = std::make_shared<decltype(content)>(std::move(content));
    }
  } else if constexpr (List<T>) {
    value.clear();
    node.forEach([&](const JsonNode& item) { readJson(item, value.emplace_back(), context); });
  } else {
    static const RecordKeys collected = [] {
      RecordKeys keys;
      T empty{};
      describe(keys, empty);
      return keys;
    }();
    node.keys(collected.requiredKeys, collected.optionalKeys);
    RecordKeys keys(node, context);
    describe(keys, value);
  }
}

// Limits: functions that throw InputError unless a node is a number from `low` to `high`, a list of numbers or a hash.
inline auto within(double low, double high = std::numeric_limits<double>::max()) {
  return [=](const JsonNode& node) { node.number(low, high); };
}
inline auto wholeNumber(std::uint64_t low, std::uint64_t high = std::numeric_limits<std::uint64_t>::max()) {
  return [=](const JsonNode& node) { node.integer<std::uint64_t>(low, high); };
}
inline auto numberCount(std::size_t numbers) {
  return [=](const JsonNode& node) { node.numbers(numbers); };
}
inline constexpr auto kSha256Digits = [](const JsonNode& node) { node.hash("a SHA-256", 64); };
inline constexpr auto kXxh3Digits = [](const JsonNode& node) { node.hash("an XXH3", 16); };
// Returns a limit for a list of records: no two records may have the same value of the key `key`.
inline auto distinct(const char* key) {
  return [=](const JsonNode& list) {
    std::set<std::string> values;
    list.forEach([&](const JsonNode& item) {
      const std::string value = item[key].dump();
      if (!values.insert(value).second) item[key].fail("another item of the list has {}, too", value);
    });
  };
}

void describe(RecordKeys& keys, FormatRecord& format);
void describe(RecordKeys& keys, FileRecord& file);
void describe(RecordKeys& keys, SequenceRecord& sequence);
void describe(RecordKeys& keys, ModelledItem& item);
void describe(RecordKeys& keys, Ontology& ontology);
void describe(RecordKeys& keys, ShardRecord& shard);
void describe(RecordKeys& keys, SensorRecord& sensor);
void describe(RecordKeys& keys, ScanRecord& scan);
void describe(RecordKeys& keys, SampleRecord& sample);

// Describes a key whose value is the name of the class `id`. The key is left out if the context has no ontology.
void describeClassName(RecordKeys& keys, const char* key, const std::uint16_t& id);
// Returns the JSON of the random values of a sample; kAbsent if it has none.
OrderedJson drawsJson(const SampleRecord& sample);

}  // namespace scanmill
