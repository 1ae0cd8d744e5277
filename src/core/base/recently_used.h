#pragma once

// A cache of the entries that were used last. It has no lock: callers that share a cache between threads must lock it.

#include <algorithm>
#include <cstddef>
#include <list>

namespace scanmill {

template <class Entry>
class RecentlyUsed {
 public:
  // Returns the entry that `isWanted` accepts, which becomes the most recently used one; null if there is none. The
  // entry stays where it is in memory until it is dropped.
  template <class Test>
  Entry* find(const Test& isWanted) {
    const auto found = std::ranges::find_if(entries_, isWanted);
    if (found == entries_.end()) return nullptr;
    entries_.splice(entries_.begin(), entries_, found);
    return &entries_.front();
  }

  // Returns the entry that find(isWanted) finds; if there is none, adds the result of make() and returns it. If there
  // are `most` entries (at least 1), the least recently used entry is dropped before make() is called.
  template <class Test, class Make>
  Entry& findOrAdd(const Test& isWanted, std::size_t most, const Make& make) {
    if (Entry* const found = find(isWanted)) return *found;
    if (entries_.size() >= most) entries_.pop_back();
    return entries_.emplace_front(make());
  }

 private:
  std::list<Entry> entries_;  // most recently used first
};

}  // namespace scanmill
