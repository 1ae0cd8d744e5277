#include "formats/ply_body.h"

#include <fmt/format.h>

#include <bit>

#include "base/error.h"
#include "base/text_scan.h"
#include "formats/text_rows.h"

namespace scanmill {

void PlyBody::beginRow(const PlyElement& element, std::uint64_t row) {
  element_ = &element;
  row_ = row;
  if (!isText()) return;
  if (at_ >= bytes_.size()) fail(fmt::format("is truncated or damaged: it ends within {}", place()));
  std::string_view rest = bytes_.substr(at_);
  text_ = takeLine(rest);
  at_ = bytes_.size() - rest.size();
  ++line_;
}

double PlyBody::next(const PlyProperty& property, const PlyType& type) {
  if (isText()) {
    const std::string_view word = takeWord(text_);
    if (word.empty()) fail(fmt::format("{} lacks values: the file is truncated or damaged", place()));
    double value = 0;
    readNumber(word, value, property.name, {file_, line_});
    return value;
  }
  if (type.size > bytes_.size() - at_) fail(fmt::format("is truncated or damaged: it ends within {}", place()));
  const bool big = header_.format == PlyHeader::Format::BigEndian;
  std::uint64_t bits = 0;
  for (std::uint64_t i = 0; i < type.size; ++i) {
    const auto byte = static_cast<unsigned char>(bytes_[at_ + i]);
    bits |= std::uint64_t{byte} << 8 * (big ? type.size - 1 - i : i);
  }
  at_ += type.size;
  if (type.kind == PlyType::Kind::Float) {
    return type.size == 8 ? std::bit_cast<double>(bits)
                          : double{std::bit_cast<float>(static_cast<std::uint32_t>(bits))};
  }
  // Integers have at most four bytes, which a double represents exactly.
  if (type.kind != PlyType::Kind::Signed) return static_cast<double>(bits);
  if (type.size == 1) return static_cast<std::int8_t>(bits);
  return type.size == 2 ? static_cast<std::int16_t>(bits) : static_cast<std::int32_t>(bits);
}

std::uint64_t PlyBody::length(const PlyProperty& property) {
  constexpr double kMost = 4294967296.0;  // above any 32-bit count
  const double length = next(property, property.count);
  if (length >= 0 && length < kMost) return static_cast<std::uint64_t>(length);
  fail(fmt::format("is damaged: {} has a list with an invalid length", place()));
}

void PlyBody::skip(const PlyProperty& property) {
  if (!property.isList()) return void(number(property));
  std::uint64_t left = length(property);
  if (isText()) {
    for (; left > 0; --left) number(property);
  } else if (left <= (bytes_.size() - at_) / property.value.size) {
    at_ += left * property.value.size;
  } else {
    fail(fmt::format("is truncated or damaged: it ends within {}", place()));
  }
}

void PlyBody::endRow() {
  if (!isText() || text_.empty()) return;
  fail(fmt::format("{} has more values than properties ({})", place(), element_->properties.size()));
}

std::string PlyBody::place() const {
  return fmt::format("'{}' {} of {}", element_->name, row_ + 1, element_->count);
}

void PlyBody::fail(const std::string& what) const {
  throw InputError({file_, isText() ? line_ : 0}, what);
}

}  // namespace scanmill
