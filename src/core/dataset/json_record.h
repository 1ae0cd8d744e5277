#pragma once

// Each record in the JSON files of datasets and recordings is described once, by a function describe() that names the
// keys in the order of the file and the limits of their values. The writer and the strict reader follow it.
//
//   void describe(RecordKeys& keys, ObjectCount& count) {
//     keys("objects", count.objects, wholeNumber(1));
//     keys("with_points", count.withPoints, wholeNumber(0, count.objects));
//   }
//
// Limits are functions of the JsonNode that has been read, which fail if they do not allow its value.

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

// Things that records refer to. `ontology`: null leaves the names of classes out. `head`: the manifest without its
// samples.
struct RecordContext {
  const Ontology* ontology = nullptr;
  const Manifest* head = nullptr;
};

// Returns the JSON of a value or record. Throws Error for numbers that are not finite; the message begins with `name`.
template <class T>
OrderedJson jsonOf(const T& value, const std::string& name, const RecordContext& context = {});
// Reads a value or record. Throws InputError for keys and values that the description does not allow.
template <class T>
void readJson(const JsonNode& node, T& value, const RecordContext& context = {});

// The argument of describe(): it lists a record's keys, writes a record, or reads one.
class RecordKeys {
 public:
  RecordKeys() = default;  // lists the keys
  RecordKeys(std::string name, const RecordContext& known) : context(known), writes_(true), name_(std::move(name)) {}
  RecordKeys(const JsonNode& node, const RecordContext& known) : context(known), node_(&node) {}

  // A key that every record has.
  template <class T, class... Limits>
  void operator()(const char* key, T& value, const Limits&... limits) {
    custom(key, writing(key, value), reading(value, limits...));
  }
  // A key that is always written, but may be missing where another version or another program wrote the record.
  template <class T, class... Limits>
  void mayBeMissing(const char* key, T& value, const Limits&... limits) {
    optionalIf(true, key, value, limits...);
  }
  // A key that is left out if the value is that of an empty record, or unless `written` is true.
  template <class T, class... Limits>
  void optional(const char* key, T& value, const Limits&... limits) {
    optionalIf(value != T{}, key, value, limits...);
  }
  template <class T, class... Limits>
  void optionalIf(bool written, const char* key, T& value, const Limits&... limits) {
    const auto write = writing(key, value);
    customOptional(
        key, [&] { return written ? write() : kAbsent; }, reading(value, limits...));
  }
  // A key with a fixed text. A record with another text is refused.
  void fixed(const char* key, std::string_view text) {
    custom(
        key, [&] { return OrderedJson(text); },
        [&](const JsonNode& node) {
          if (node.text() != text) node.fail(fmt::format("is not '{}'", text));
        });
  }
  // A key that is not written any more, and not read.
  void former(const char* key) {
    customOptional(
        key, [] { return kAbsent; }, [](const JsonNode&) {});
  }
  // A key that every record that is read has, whose JSON write() returns (kAbsent: not written) and read(node) reads.
  template <class Write, class Read>
  void custom(const char* key, const Write& write, const Read& read) {
    if (!writes_ && !reads()) all.emplace_back(key);
    add(key, write);
    if (reads()) read((*node_)[key]);
  }
  // The same for a key that may be missing.
  template <class Write, class Read>
  void customOptional(const char* key, const Write& write, const Read& read) {
    if (!writes_ && !reads()) others.emplace_back(key);
    add(key, write);
    if (reads() && node_->has(key)) read((*node_)[key]);
  }
  // A map of its own, whose keys fill(keys) describes.
  template <class Fill>
  void map(const char* key, const Fill& fill) {
    const auto write = [&] {
      RecordKeys nested(name_ + "/" + key, context);
      fill(nested);
      return nested.json;
    };
    custom(key, write, [&](const JsonNode& node) {
      RecordKeys list, nested(node, context);
      fill(list);
      node.keys(list.all, list.others);
      fill(nested);
    });
  }

  bool reads() const { return node_ != nullptr; }

  RecordContext context;
  std::vector<std::string_view> all, others;  // the keys that all records have, and other keys
  OrderedJson json = OrderedJson::object();   // the record that was written

 private:
  template <class Write>
  void add(const char* key, const Write& write) {
    if (!writes_) return;
    if (OrderedJson value = write(); !value.is_discarded()) json[key] = std::move(value);
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

  bool writes_ = false;
  std::string name_;
  const JsonNode* node_ = nullptr;
};

template <class T>
OrderedJson jsonOf(const T& value, const std::string& name, const RecordContext& context) {
  if constexpr (std::is_floating_point_v<T>) {
    return finite(double{value}, name);
  } else if constexpr (std::is_same_v<T, Pose>) {
    return poseJson(value, name);
  } else if constexpr (std::is_same_v<T, Vec3d>) {
    return finiteList({value.x, value.y, value.z}, name);
  } else if constexpr (requires { *value; }) {  // a value that may be absent
    return jsonOf(*value, name, context);
  } else if constexpr (std::is_same_v<T, std::vector<double>>) {
    return finiteList(value, name);
  } else if constexpr (requires(T list) { list.emplace_back(); }) {
    OrderedJson list = OrderedJson::array();
    for (const auto& item : value) list.push_back(jsonOf(item, fmt::format("{}/{}", name, list.size()), context));
    return list;
  } else if constexpr (std::is_constructible_v<OrderedJson, const T&>) {
    return OrderedJson(value);
  } else {
    RecordKeys keys(name, context);
    describe(keys, const_cast<T&>(value));  // which writing does not change
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
  } else if constexpr (std::is_same_v<T, std::array<std::uint8_t, 3>>) {
    node.numbers(value.size());
    for (std::size_t i = 0; i < value.size(); ++i) value[i] = node.item(i).template integer<std::uint8_t>();
  } else if constexpr (requires { *value; }) {
    auto content = std::make_shared<std::remove_cvref_t<decltype(*value)>>();
    readJson(node, *content, context);
    if constexpr (std::is_assignable_v<T&, decltype(content)>) {
      value = std::move(content);
    } else {
      value = std::move(*content);
    }
  } else if constexpr (requires(T list) { list.emplace_back(); }) {
    value.clear();
    node.forEach([&](const JsonNode& item) { readJson(item, value.emplace_back(), context); });
  } else {
    static const RecordKeys list = [] {
      RecordKeys keys;
      T none{};
      describe(keys, none);
      return keys;
    }();
    node.keys(list.all, list.others);
    RecordKeys keys(node, context);
    describe(keys, value);
  }
}

// Limits of values: of numbers, of whole numbers, of the length of a list of numbers, of hashes, and of lists of
// records no two of which may have the same value of a key.
inline auto within(double low, double high = std::numeric_limits<double>::max()) {
  return [=](const JsonNode& node) { node.number(low, high); };
}
inline auto wholeNumber(std::uint64_t low, std::uint64_t high = std::numeric_limits<std::uint64_t>::max()) {
  return [=](const JsonNode& node) { node.integer<std::uint64_t>(low, high); };
}
inline auto numberCount(std::size_t numbers) {
  return [=](const JsonNode& node) { node.numbers(numbers); };
}
inline constexpr auto kSha256Digits = [](const JsonNode& node) { node.sha256(); };
inline constexpr auto kXxh3Digits = [](const JsonNode& node) { node.xxh3(); };
inline auto distinct(const char* key) {
  return [=](const JsonNode& list) {
    std::set<std::string> values;
    list.forEach([&](const JsonNode& item) {
      const std::string value = item[key].dump();
      if (!values.insert(value).second) item[key].fail(fmt::format("another item of the list has {}, too", value));
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

// Describes a key that repeats a class's name from the ontology, if there is one; when read, it must agree with `id`.
void describeClassName(RecordKeys& keys, const char* key, const std::uint16_t& id);
// Reads what is modelled. `mayBeLines`: true accepts lines of text, too, as earlier versions wrote them.
void readModelled(const JsonNode& list, bool mayBeLines, std::vector<ModelledItem>& items);
// Returns the JSON of the values that were drawn at random, or kAbsent.
OrderedJson drawsJson(const SampleRecord& sample);

}  // namespace scanmill
