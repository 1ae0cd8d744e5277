#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <vector>

#include "base/instruction_sets.h"
#include "base/raw_vector.h"
#include "formats/draco_writer.h"

namespace scanmill {

namespace {

using Counts = std::vector<std::uint32_t>;

constexpr int kMaxRawBits = 18;      // largest number of bits of a symbol that is coded by its own probability
constexpr std::uint8_t kTagged = 0;  // Draco's numbers of the two ways in which symbols are coded
constexpr std::uint8_t kRaw = 1;
constexpr int kTagPrecisionBits = 12;

struct Histogram {
  Counts counts;             // number of occurrences of each symbol, up to the largest symbol
  std::uint64_t total = 0;   // number of coded symbols
  std::uint32_t unique = 0;  // number of different symbols
  double bits = 0;           // Shannon's bound for all coded symbols, without the table
};

// Counts symbols from 0 to `largest`. Long sequences of one symbol (labels, columns) are common. Four tables are filled
// in turn, so that an increment need not wait for the previous increment of the same counter.
template <class Symbol>
Histogram histogram(const Symbol* symbols, std::size_t count, std::uint32_t largest) {
  constexpr std::size_t kTables = 4;
  const std::size_t size = std::size_t{largest} + 1;
  const std::size_t tables = size <= 4096 ? kTables : 1;
  Counts counts(size * tables);
  std::size_t i = 0;
  if (tables == kTables) {
    for (; i + kTables <= count; i += kTables) {
      ++counts[symbols[i]];
      ++counts[size + symbols[i + 1]];
      ++counts[2 * size + symbols[i + 2]];
      ++counts[3 * size + symbols[i + 3]];
    }
  }
  for (; i < count; ++i) ++counts[symbols[i]];
  for (std::size_t table = 1; table < tables; ++table) {
    for (std::size_t s = 0; s < size; ++s) counts[s] += counts[table * size + s];
  }
  counts.resize(size);
  Histogram result{.counts = std::move(counts), .total = count};
  double sum = 0;
  for (const std::uint32_t n : result.counts) {
    if (n == 0) continue;
    ++result.unique;
    if (n > 1) sum += n * std::log2(static_cast<double>(n));
  }
  // Shannon's bound: the sum of n log2(count / n) over the different symbols, each of which occurs n times.
  result.bits = static_cast<double>(count) * std::log2(static_cast<double>(std::max<std::size_t>(count, 1))) - sum;
  return result;
}

// Estimates the size of the table of probabilities (bits): two bytes for each symbol that occurs, and one byte for up
// to 64 successive symbols that do not occur.
double tableBits(const Histogram& h) {
  return 16.0 * h.unique + 8.0 * std::min<double>(h.unique, static_cast<double>(h.counts.size() - h.unique)) +
         static_cast<double>(h.counts.size()) / 8;
}

// Returns the symbols' probabilities as integers in units of 2^-precisionBits. Symbols that occur get at least one
// unit; all units add up to 2^precisionBits.
std::vector<std::uint32_t> probabilities(const Histogram& h, int precisionBits) {
  const std::int64_t one = std::int64_t{1} << precisionBits;
  std::vector<std::uint32_t> result(h.counts.size());
  const double scale = static_cast<double>(one) / static_cast<double>(h.total);
  std::int64_t sum = 0;
  std::size_t largest = 0;
  for (std::size_t s = 0; s < result.size(); ++s) {
    if (h.counts[s] == 0) continue;
    result[s] = std::max(1u, static_cast<std::uint32_t>(h.counts[s] * scale + 0.5));
    sum += result[s];
    if (result[s] > result[largest]) largest = s;
  }
  if (sum <= one) {
    result[largest] += static_cast<std::uint32_t>(one - sum);
    return result;
  }
  // The sum is too large, since rare symbols were rounded up to 1 unit: reduce the greater probabilities in proportion.
  while (sum > one) {
    std::int64_t shrinkable = 0;
    for (const std::uint32_t p : result) shrinkable += p > 1 ? p - 1 : 0;
    const double share = static_cast<double>(sum - one) / static_cast<double>(shrinkable);
    for (std::uint32_t& p : result) {
      if (p <= 1 || sum == one) continue;
      const auto cut = std::min<std::int64_t>(static_cast<std::int64_t>(std::ceil((p - 1) * share)), sum - one);
      p -= static_cast<std::uint32_t>(cut);
      sum -= cut;
    }
  }
  return result;
}

// Appends the probability of each symbol in one to three bytes. The first byte states the number of further bytes.
void appendTable(const std::vector<std::uint32_t>& probability, std::string& out) {
  appendVarint(probability.size(), out);
  for (std::size_t s = 0; s < probability.size(); ++s) {
    const std::uint32_t p = probability[s];
    if (p == 0) {
      // The two low bits are 3; the six high bits count further symbols that do not occur. The table's last symbol
      // occurs.
      std::size_t further = 0;
      while (further < 63 && probability[s + further + 1] == 0) ++further;
      out.push_back(static_cast<char>((further << 2) | 3));
      s += further;
      continue;
    }
    const int furtherBytes = p >= (1u << 14) ? 2 : p >= (1u << 6) ? 1 : 0;
    out.push_back(static_cast<char>((p << 2) | static_cast<std::uint32_t>(furtherBytes)));
    for (int byte = 1; byte <= furtherBytes; ++byte) out.push_back(static_cast<char>(p >> (8 * byte - 2)));
  }
}

// The coder codes a symbol of probability p in this way: it writes the low bytes of its state until the state is below
// 1024 p. Then the state becomes (state / p) * 2^precision + state % p + start, which equals state + (state / p) *
// complement + start. The state is always between 4 and 1024 times 2^precision, so each symbol writes either `bits` or
// `bits` + 8 bits. The division is a multiplication by the reciprocal, exact for states below 2^31, and uses the state
// before its low bytes are written. Thus only two multiplications separate successive states, while Draco's coder has a
// division and unpredictable branches.
struct SymbolStep {
  std::uint32_t reciprocal;  // 2^(shift - bits) / p, rounded up
  std::uint32_t limit;       // least state from which 8 more bits are written
  std::uint32_t complement;  // 2^precision - p
  std::uint32_t start;       // sum of the probabilities of all earlier symbols
  std::uint16_t bits;        // number of bits that are written below `limit`
  std::uint16_t shift;       // bits by which the product of state and reciprocal is shifted right
};

// Returns the step of each symbol; the steps of symbols that do not occur are not set.
std::vector<SymbolStep> symbolSteps(const std::vector<std::uint32_t>& probability, int precisionBits) {
  std::vector<SymbolStep> result(probability.size());
  std::uint32_t start = 0;
  for (std::size_t s = 0; s < probability.size(); ++s) {
    const std::uint32_t p = probability[s];
    if (p == 0) continue;
    const auto division = 31 + static_cast<unsigned>(std::bit_width(p - 1));
    unsigned bits = 0;
    while ((4u << precisionBits >> bits) >= p << 10) bits += 8;
    result[s] = {.reciprocal = static_cast<std::uint32_t>(((std::uint64_t{1} << division) + p - 1) / p),
                 .limit = p << 10 << bits,
                 .complement = (1u << precisionBits) - p,
                 .start = start,
                 .bits = static_cast<std::uint16_t>(bits),
                 .shift = static_cast<std::uint16_t>(division + bits)};
    start += p;
  }
  return result;
}

// Codes h.total symbols by rANS and appends the table of probabilities, the size of the code (bytes) and the code. The
// last symbol is coded first, since a decoder returns the symbols in the reverse order. `h`: histogram of the symbols.
template <class Symbol>
void appendRans(const Symbol* symbols, const Histogram& h, int precisionBits, std::string& out) {
  const std::vector<std::uint32_t> probability = probabilities(h, precisionBits);
  appendTable(probability, out);
  const std::uint32_t leastState = 4u << precisionBits;
  std::uint32_t state = leastState;
  thread_local RawVector<char> scratch;
  scratch.resize(3 * h.total + 8);
  char* const begin = scratch.data();
  char* end = begin;   // end of the code so far
  if (h.unique > 1) {  // a single symbol has probability 1 and takes no bits
    const std::vector<SymbolStep> steps = symbolSteps(probability, precisionBits);
    for (std::size_t i = h.total; i-- > 0;) {
      const SymbolStep& step = steps[symbols[i]];
      std::memcpy(end, &state, sizeof(state));  // only the low bytes stay: the next bytes overwrite the others
      const unsigned furtherBits = state >= step.limit ? 8 : 0;
      const auto quotient =
          static_cast<std::uint32_t>((std::uint64_t{state} * step.reciprocal) >> (step.shift + furtherBits));
      const unsigned bits = step.bits + furtherBits;
      end += bits / 8;
      state = (state >> bits) + step.start + quotient * step.complement;
    }
  }
  // Appends the last state in one to four bytes. The two highest bits state the number of bytes.
  const std::uint32_t offset = state - leastState;
  const int bytes = offset < (1u << 6) ? 1 : offset < (1u << 14) ? 2 : offset < (1u << 22) ? 3 : 4;
  const std::uint32_t tail = offset | (static_cast<std::uint32_t>(bytes - 1) << (8 * bytes - 2));
  std::memcpy(end, &tail, sizeof(tail));
  end += bytes;
  appendVarint(static_cast<std::uint64_t>(end - begin), out);
  out.append(begin, end);
}

// Returns the number of bits of a symbol without leading zeros; 1 for 0.
std::uint8_t bitLength(std::uint32_t value) {
  return static_cast<std::uint8_t>(std::bit_width(value | 1u));
}

// Returns for each entry the bit length of its widest component. The memory is valid until this thread's next call.
template <std::size_t kComponents>
std::span<const std::uint8_t> bitLengths(std::span<const std::uint32_t> symbols) {
  thread_local RawVector<std::uint8_t> scratch;
  const std::size_t entries = symbols.size() / kComponents;
  scratch.resize(entries);
  std::uint8_t* const lengths = scratch.data();
  for (std::size_t i = 0; i < entries; ++i) {
    std::uint32_t unionOfBits = 0;
    for (std::size_t c = 0; c < kComponents; ++c) unionOfBits |= symbols[i * kComponents + c];
    lengths[i] = bitLength(unionOfBits);
  }
  return {lengths, entries};
}

// Appends the length of every entry by rANS, then the components of each entry. Each component takes as many bits as
// the entry's length. `h`: histogram of the lengths.
void appendTagged(std::span<const std::uint32_t> symbols, int components, std::span<const std::uint8_t> lengths,
                  const Histogram& h, std::string& out) {
  out.push_back(static_cast<char>(kTagged));
  appendRans(lengths.data(), h, kTagPrecisionBits, out);
  thread_local RawVector<char> scratch;
  scratch.resize(4 * symbols.size() + 8);
  char* const begin = scratch.data();
  char* end = begin;
  std::uint64_t pending = 0;
  unsigned pendingBits = 0;
  for (std::size_t i = 0; i < symbols.size(); ++i) {
    pending |= std::uint64_t{symbols[i]} << pendingBits;
    pendingBits += lengths[i / static_cast<std::size_t>(components)];
    std::memcpy(end, &pending, sizeof(pending));
    end += pendingBits / 8;
    pending >>= pendingBits & ~7u;
    pendingBits &= 7u;
  }
  if (pendingBits > 0) *end++ = static_cast<char>(pending);
  out.append(begin, end);
}

// Returns the bit length that Draco stores before raw symbols: the bit length of `unique`, the number of different
// symbols, adjusted by the compression level. The precision of the probabilities follows from this length.
int symbolBits(std::uint32_t unique, int level) {
  const int adjustment = level < 4 ? -2 : level < 6 ? -1 : level > 9 ? 2 : level > 7 ? 1 : 0;
  return std::clamp(static_cast<int>(std::bit_width(unique)) + adjustment, 1, kMaxRawBits);
}

}  // namespace

void appendVarint(std::uint64_t value, std::string& out) {
  for (; value >= 128; value >>= 7) out.push_back(static_cast<char>(value | 128));
  out.push_back(static_cast<char>(value));
}

SCANMILL_BEST_INSTRUCTIONS void appendSymbols(std::span<const std::uint32_t> symbols, int components, int level,
                                              std::string& out) {
  if (symbols.empty()) return;
  const std::uint32_t largest = *std::ranges::max_element(symbols);
  const std::span<const std::uint8_t> lengths = components == 3 ? bitLengths<3>(symbols) : bitLengths<1>(symbols);
  const Histogram tags = histogram(lengths.data(), lengths.size(), bitLength(largest));
  double taggedBits = tags.bits + tableBits(tags);  // size of what appendTagged() appends
  for (std::size_t length = 0; length < tags.counts.size(); ++length) {
    taggedBits += static_cast<double>(length) * tags.counts[length] * components;
  }
  if (bitLength(largest) <= kMaxRawBits) {
    const Histogram values = histogram(symbols.data(), symbols.size(), largest);
    if (values.bits + tableBits(values) <= taggedBits) {
      const int bits = symbolBits(values.unique, level);
      out.push_back(static_cast<char>(kRaw));
      out.push_back(static_cast<char>(bits));
      return appendRans(symbols.data(), values, std::clamp(3 * bits / 2, 12, 20), out);
    }
  }
  appendTagged(symbols, components, lengths, tags, out);
}

}  // namespace scanmill
