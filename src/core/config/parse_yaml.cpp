// parseYaml() checks yaml-cpp's events one by one as they arrive, so that a hostile file is refused before it costs
// memory.

#include <fmt/core.h>
#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/exceptions.h>
#include <yaml-cpp/mark.h>
#include <yaml-cpp/parser.h>

#include <algorithm>
#include <array>
#include <new>
#include <sstream>
#include <unordered_map>

#include "config/text.h"
#include "config/value.h"

namespace scanmill {

namespace {

constexpr std::size_t kMaxDepth = 64;
constexpr std::size_t kMaxNodes = 1'000'000;
constexpr std::size_t kMaxTextBytes = 4 * kMaxYamlBytes;  // largest size of all scalars together, with aliases expanded

// The size of a value with all values within it.
struct Extent {
  std::size_t nodes = 1;
  std::size_t bytes = 0;  // size of all scalars and keys
  std::size_t depth = 0;  // nesting depth of the lists and maps
};

Extent extentOf(const Value& value) {
  Extent extent{.bytes = value.text.size()};
  const auto addChild = [&](const Value& child) {
    const Extent childExtent = extentOf(child);
    extent.nodes += childExtent.nodes;
    extent.bytes += childExtent.bytes;
    extent.depth = std::max(extent.depth, childExtent.depth);
  };
  for (const Value& item : value.items) addChild(item);
  for (const auto& [key, entry] : value.entries) {
    extent.bytes += key.size();
    addChild(entry);
  }
  if (value.kind == Value::Kind::Sequence || value.kind == Value::Kind::Map) ++extent.depth;
  return extent;
}

// Returns a message that contains yaml-cpp's message and, for the commonest mistakes, what the author can do.
std::string explain(const std::string& message) {
  static const std::array<std::pair<std::string_view, std::string_view>, 10> kAdvice{{
      {YAML::ErrorMsg::END_OF_SEQ_FLOW, "a list [ ... ] is not closed"},
      {YAML::ErrorMsg::END_OF_MAP_FLOW, "a map { ... } is not closed"},
      {YAML::ErrorMsg::FLOW_END, "a closing bracket has no opening bracket"},
      {YAML::ErrorMsg::EOF_IN_SCALAR, "a quotation mark is not closed"},
      {YAML::ErrorMsg::MAP_VALUE, "a colon that does not follow a key: check the indentation, or quote the text"},
      {YAML::ErrorMsg::MAP_KEY, "a key cannot stand here: check the indentation"},
      {YAML::ErrorMsg::BLOCK_ENTRY, "a list item cannot stand here: put it on a line of its own"},
      {YAML::ErrorMsg::END_OF_MAP, "this does not belong to the map above: check the indentation"},
      {YAML::ErrorMsg::END_OF_SEQ, "this does not belong to the list above: check the indentation"},
      {YAML::ErrorMsg::UNKNOWN_TOKEN, "text cannot start with this character: quote it"},
  }};
  for (const auto& [words, advice] : kAdvice) {
    if (message == words) return fmt::format("invalid YAML: {} ({})", advice, message);
  }
  return "invalid YAML: " + message;
}

// Builds the tree from events. A list or map that has begun stays in `open_` until its end, when it is added to the
// list or map around it. While a map is innermost, its keys and values arrive alternately.
class TreeBuilder : public YAML::EventHandler {
 public:
  TreeBuilder(std::string_view text, std::string file) : text_(text), file_(std::move(file)) {
    root_.where = {file_, 1, 1};
  }

  Value take() { return std::move(root_); }

  Location locationOf(const YAML::Mark& mark) const {
    if (mark.is_null()) return {file_};
    return {file_, mark.line + 1, mark.column + 1};
  }

  // Returns where the innermost unclosed list or map begins, since yaml-cpp's error does not say it.
  const Location& innermost() const { return open_.empty() ? root_.where : open_.back().value.where; }

  void OnDocumentStart(const YAML::Mark& mark) override {
    if (documents_++ == 0) return;
    const bool hasMarker = text_.substr(std::min(text_.size(), static_cast<std::size_t>(mark.pos))).starts_with("---");
    throw InputError(locationOf(mark), hasMarker ? "a second YAML document begins here, but a file must have only one"
                                                 : "this does not belong to the lines above: check the indentation");
  }
  void OnDocumentEnd() override {}

  void OnNull(const YAML::Mark& mark, YAML::anchor_t anchor) override {
    refuseAsKey(mark, "is empty");
    Value value;
    value.where = locationOf(mark);
    // yaml-cpp marks a key's empty value at the next token. If this token is on another line, use the key's position.
    if (!open_.empty() && open_.back().value.kind == Value::Kind::Map && open_.back().keyWhere.line != mark.line + 1) {
      value.where = open_.back().keyWhere;
    }
    count(mark, {});
    add(std::move(value), anchor);
  }

  void OnAlias(const YAML::Mark& mark, YAML::anchor_t anchor) override {
    refuseAsKey(mark, "is an alias");
    const auto anchored = anchors_.find(anchor);
    if (anchored == anchors_.end())
      throw InputError(locationOf(mark), "this alias refers to a node that contains the alias");
    count(mark, extentOf(anchored->second));
    add(anchored->second, 0);
  }

  void OnScalar(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                const std::string& text) override {
    if (text.find('\0') != std::string::npos) throw InputError(locationOf(mark), "a text has a NUL character");
    if (awaitsKey()) {
      if (text == "<<" && tag != "!") {
        throw InputError(locationOf(mark), "merge keys (<<) are not supported: write the keys out");
      }
      openKey(mark, text);
      return;
    }
    Value value = scalarValue({}, locationOf(mark));
    value.quoted = checkTag(mark, tag);
    value.text = expandVariables(text, value.where);
    count(mark, {.bytes = value.text.size()});
    add(std::move(value), anchor);
  }

  void OnSequenceStart(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                       YAML::EmitterStyle::value /*style*/) override {
    open(mark, tag, anchor, Value::Kind::Sequence);
  }
  void OnMapStart(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                  YAML::EmitterStyle::value /*style*/) override {
    open(mark, tag, anchor, Value::Kind::Map);
  }
  void OnSequenceEnd() override { close(); }
  void OnMapEnd() override { close(); }

 private:
  // A list or map that has begun but not ended.
  struct Open {
    Value value;
    YAML::anchor_t anchor = 0;
    bool hasKey = false;  // true: the next value belongs to `key`; false: a map's next scalar is a key
    std::string key;
    Location keyWhere;
    std::unordered_map<std::string, std::pair<int, int>> keyPositions;  // line and column, to report duplicates
  };

  bool awaitsKey() const {
    return !open_.empty() && open_.back().value.kind == Value::Kind::Map && !open_.back().hasKey;
  }

  void refuseAsKey(const YAML::Mark& mark, const char* what) const {
    if (awaitsKey()) throw InputError(locationOf(mark), "a key must be text, but this key {}", what);
  }

  // True if the tag says that a scalar is text, even if it looks like a number: scalars in quotes have the tag "!".
  // Throws InputError for other tags than those of text, lists and maps.
  bool checkTag(const YAML::Mark& mark, const std::string& tag) const {
    if (tag.empty() || tag == "?" || tag == "tag:yaml.org,2002:map" || tag == "tag:yaml.org,2002:seq") return false;
    if (tag == "!" || tag == "tag:yaml.org,2002:str") return true;
    throw InputError(locationOf(mark), "the tag {} is not supported: leave it out", quotedForMessage(tag));
  }

  void openKey(const YAML::Mark& mark, const std::string& key) {
    Open& map = open_.back();
    const auto [first, isNew] = map.keyPositions.try_emplace(key, mark.line + 1, mark.column + 1);
    if (!isNew) {
      throw InputError(locationOf(mark), "duplicate key {} (first at {}:{})", quotedForMessage(key),
                       first->second.first, first->second.second);
    }
    count(mark, {.nodes = 0, .bytes = key.size()});
    map.key = key;
    map.keyWhere = locationOf(mark);
    map.hasKey = true;
  }

  void open(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor, Value::Kind kind) {
    refuseAsKey(mark, kind == Value::Kind::Map ? "is a map, or belongs to a map that is not closed"
                                               : "is a list, or belongs to a list that is not closed");
    checkTag(mark, tag);
    count(mark, {.depth = 1});
    Open& node = open_.emplace_back();
    node.value.kind = kind;
    node.value.where = locationOf(mark);
    node.anchor = anchor;
  }

  void close() {
    Value value = std::move(open_.back().value);
    const YAML::anchor_t anchor = open_.back().anchor;
    open_.pop_back();
    add(std::move(value), anchor);
  }

  // Counts a node that will be added. Throws an InputError at `mark` if a limit is exceeded, before the node takes
  // memory.
  void count(const YAML::Mark& mark, const Extent& extent) {
    nodes_ += extent.nodes;
    bytes_ += extent.bytes;
    if (open_.size() + extent.depth > kMaxDepth) {
      throw InputError(locationOf(mark), "the file is nested more than {} levels deep", kMaxDepth);
    }
    if (nodes_ > kMaxNodes) {
      throw InputError(locationOf(mark), "the file has more than {} values, with aliases expanded", kMaxNodes);
    }
    if (bytes_ > kMaxTextBytes) {
      throw InputError(locationOf(mark), "the file has more than {} bytes of text, with aliases expanded",
                       kMaxTextBytes);
    }
  }

  // Adds a complete value to the innermost open list or map; without one, the value becomes the root. `anchor`: 0 if
  // the value has none.
  void add(Value value, YAML::anchor_t anchor) {
    if (anchor != 0) {
      // A copy is stored for the anchor and counts towards the limits, since nested anchors could otherwise multiply
      // the memory that a document needs.
      const Extent extent = extentOf(value);
      nodes_ += extent.nodes;
      bytes_ += extent.bytes;
      anchors_[anchor] = value;
    }
    if (open_.empty()) {
      root_ = std::move(value);
      return;
    }
    Open& parent = open_.back();
    if (parent.value.kind == Value::Kind::Sequence) return parent.value.items.push_back(std::move(value));
    value.keyLine = parent.keyWhere.line;
    value.keyColumn = parent.keyWhere.column;
    parent.value.entries.push_back({std::move(parent.key), std::move(value)});
    parent.hasKey = false;
  }

  std::string_view text_;
  std::string file_;
  Value root_;
  std::vector<Open> open_;
  std::unordered_map<YAML::anchor_t, Value> anchors_;
  std::size_t nodes_ = 0;
  std::size_t bytes_ = 0;
  int documents_ = 0;
};

}  // namespace

Value parseYaml(std::string_view text, const std::string& file) {
  constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
  if (text.starts_with(kByteOrderMark)) text.remove_prefix(kByteOrderMark.size());
  checkText(text, file);
  TreeBuilder builder(text, file);
  try {
    std::istringstream stream{std::string(text)};
    YAML::Parser parser(stream);
    while (parser.HandleNextDocument(builder)) {
    }
  } catch (const Error&) {
    throw;
  } catch (const YAML::Exception& e) {
    const bool unclosed = e.msg == YAML::ErrorMsg::END_OF_SEQ_FLOW || e.msg == YAML::ErrorMsg::END_OF_MAP_FLOW;
    const Location where = unclosed ? builder.innermost() : builder.locationOf(e.mark);
    throw InputError(where, explain(e.msg));
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception& e) {
    throw InputError({file}, "invalid YAML: {}", reasonOf(e));
  }
  return builder.take();
}

}  // namespace scanmill
