#include "formats/npz_reader.h"

#include <archive.h>
#include <archive_entry.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <cstring>
#include <limits>
#include <memory>
#include <optional>
#include <vector>

#include "base/error.h"
#include "formats/column_value.h"

namespace scanmill {

namespace {

constexpr std::size_t kMostBytes = std::size_t{4} << 30;  // of an array

struct Array {
  std::string name;
  std::string type;  // "<f4"
  std::vector<std::size_t> shape;
  std::string bytes;
};

// Calls visit(name, bytes) for each file of a ZIP archive whose name wanted() takes.
template <class Wanted, class Visit>
void readZip(std::string_view bytes, const std::string& what, const Wanted& wanted, const Visit& visit) {
  const std::unique_ptr<archive, decltype(&archive_read_free)> zip(archive_read_new(), &archive_read_free);
  const auto fail = [&] {
    const char* const text = archive_error_string(zip.get());
    throw InputError({what}, fmt::format("is no sound archive .npz: {}", text != nullptr ? text : "unknown"));
  };
  archive_read_support_format_zip(zip.get());
  if (archive_read_open_memory(zip.get(), bytes.data(), bytes.size()) != ARCHIVE_OK) fail();
  archive_entry* entry = nullptr;
  for (;;) {
    const int result = archive_read_next_header(zip.get(), &entry);
    if (result == ARCHIVE_EOF) return;
    if (result != ARCHIVE_OK) fail();
    const char* const path = archive_entry_pathname(entry);
    const std::string name = path != nullptr ? path : "";
    if (!wanted(name)) continue;
    std::string content;
    std::string piece(std::size_t{1} << 16, '\0');
    la_ssize_t read = 0;
    while ((read = archive_read_data(zip.get(), piece.data(), piece.size())) > 0) {
      if (content.size() + static_cast<std::size_t>(read) > kMostBytes) {
        throw InputError({what}, fmt::format("{} is larger than 4 GiB", name));
      }
      content.append(piece, 0, static_cast<std::size_t>(read));
    }
    if (read < 0) fail();
    visit(name, std::move(content));
  }
}

// The text behind `key` of a Python dictionary, up to the end of the header; empty where it is not there.
std::string_view valueIn(std::string_view header, std::string_view key) {
  for (const char quote : {'\'', '"'}) {
    const std::string quoted = fmt::format("{}{}{}:", quote, key, quote);
    const std::size_t at = header.find(quoted);
    if (at == std::string_view::npos) continue;
    const std::string_view rest = header.substr(at + quoted.size());
    return rest.substr(std::min(rest.find_first_not_of(' '), rest.size()));
  }
  return {};
}

std::size_t elementBytes(std::string_view type) {
  for (const std::string_view known : {"f4", "f8", "u1", "u2", "u4", "u8", "i1", "i2", "i4", "i8"}) {
    if (type.size() == 3 && type.substr(1) == known) return static_cast<std::size_t>(type[2] - '0');
  }
  return 0;
}

Array parseNpy(const std::string& name, const std::string& file, const std::string& what) {
  const std::string place = what + ": " + name;
  const auto fail = [&](const std::string& why) { throw InputError({place}, why); };
  if (file.size() < 12 || file.compare(0, 6, "\x93NUMPY") != 0) fail("is no array of NumPy");
  const auto byte = [&](std::size_t at) { return static_cast<std::size_t>(static_cast<unsigned char>(file[at])); };
  const bool first = byte(6) == 1;
  const std::size_t before = first ? 10 : 12;
  const std::size_t length = first ? byte(8) | byte(9) << 8 : byte(8) | byte(9) << 8 | byte(10) << 16 | byte(11) << 24;
  if (before + length > file.size()) fail("ends within its header");
  const std::string_view header = std::string_view(file).substr(before, length);
  Array array;
  array.name = name.substr(0, name.size() - std::string_view(".npy").size());
  const std::string_view type = valueIn(header, "descr");
  if (type.size() > 4) array.type = type.substr(1, 3);
  if (!valueIn(header, "fortran_order").starts_with("False")) fail("is in Fortran's order: save it in C's");
  const std::string_view shape = valueIn(header, "shape");
  const char* at = shape.data();
  const char* const end = shape.data() + shape.size();
  if (at == end || *at != '(') fail("its header states no shape");
  for (++at; at != end && *at != ')';) {
    std::size_t size = 0;
    const auto read = std::from_chars(at, end, size);
    if (read.ec != std::errc()) fail("its header states no shape");
    array.shape.push_back(size);
    at = read.ptr;
    while (at != end && (*at == ',' || *at == ' ' || *at == 'L')) ++at;
  }
  const std::size_t element = elementBytes(array.type);
  array.bytes = file.substr(before + length);
  if (element == 0) return array;  // no number: whoever wants numbers refuses it
  if (element > 1 && array.type[0] != '<')
    fail(fmt::format("is of the type {}, big-endian: save it as <f4", array.type));
  std::size_t expected = element;
  for (const std::size_t size : array.shape) {
    if (size != 0 && expected > kMostBytes / size) fail("states a shape of more than 4 GiB");
    expected *= size;
  }
  if (array.bytes.size() != expected) {
    fail(fmt::format("has {} bytes where its shape ({}) of {} has {}", array.bytes.size(), fmt::join(array.shape, ", "),
                     array.type, expected));
  }
  return array;
}

// Calls visit(values) with the array's numbers in their own type.
template <class Visit>
void visitNumbers(const Array& array, const std::string& what, const Visit& visit) {
  const auto as = [&](auto sample) {
    std::vector<decltype(sample)> values(array.bytes.size() / sizeof(sample));
    if (!values.empty()) std::memcpy(values.data(), array.bytes.data(), array.bytes.size());
    visit(std::move(values));
  };
  const std::string_view kind = array.type.size() == 3 ? std::string_view(array.type).substr(1) : "";
  if (kind == "f4") return as(float{});
  if (kind == "f8") return as(double{});
  if (kind == "u1") return as(std::uint8_t{});
  if (kind == "u2") return as(std::uint16_t{});
  if (kind == "u4") return as(std::uint32_t{});
  if (kind == "u8") return as(std::uint64_t{});
  if (kind == "i1") return as(std::int8_t{});
  if (kind == "i2") return as(std::int16_t{});
  if (kind == "i4") return as(std::int32_t{});
  if (kind == "i8") return as(std::int64_t{});
  throw InputError({what}, fmt::format("{} is of no type of numbers that is read", array.name));
}

void addColumn(const Array& array, std::string_view name, const std::string& what, Scan& scan) {
  visitNumbers(array, what, [&](auto values) {
    const std::size_t index = columnIndex(name);
    if (index == kColumnCount) {
      scan.foreign.push_back({std::string(name), std::move(values)});
      return;
    }
    visitTable(scan, [&](auto key, auto& column) {
      if (key.index != index) return;
      using Value = typename decltype(key)::Value;
      column.clear();
      column.reserve(values.size());
      for (std::size_t i = 0; i < values.size(); ++i) column.push_back(columnValue<Value>(values[i], name, i, {what}));
    });
  });
}

void addPositions(const Array& array, const std::string& what, Scan& scan) {
  const std::size_t wide = array.shape.back();
  visitNumbers(array, what, [&](const auto& values) {
    for (std::size_t i = 0; i + wide <= values.size(); i += wide) {
      scan.position.push_back(
          {static_cast<float>(values[i]), static_cast<float>(values[i + 1]), static_cast<float>(values[i + 2])});
      if (wide > 3) scan[kIntensity].push_back(static_cast<float>(values[i + 3]));
      if (wide == 5) scan[kRing].push_back(columnValue<std::uint16_t>(values[i + 4], "ring", i / wide, {what}));
    }
  });
}

}  // namespace

Scan readNpz(std::string_view bytes, const std::string& what) {
  std::vector<Array> arrays;
  readZip(
      bytes, what, [](const std::string& name) { return name.ends_with(".npy"); },
      [&](const std::string& name, const std::string& file) { arrays.push_back(parseNpy(name, file, what)); });
  const auto positions = std::find_if(arrays.begin(), arrays.end(), [](const Array& a) {
    return (a.name == "xyz" || a.name == "points") && (a.shape.size() == 2 || a.shape.size() == 3) &&
           a.shape.back() >= 3 && a.shape.back() <= 5;
  });
  if (positions == arrays.end()) {
    std::vector<std::string> names;
    names.reserve(arrays.size());
    for (const Array& a : arrays) names.push_back(a.name);
    throw InputError({what},
                     fmt::format("has no array `xyz` or `points` of shape (N, 3), (N, 4) or (rings, columns, 3); "
                                 "it has {}",
                                 names.empty() ? "none" : fmt::format("{}", fmt::join(names, ", "))));
  }
  Scan scan;
  addPositions(*positions, what, scan);
  std::vector<std::size_t> shape = positions->shape;
  shape.pop_back();
  for (const Array& array : arrays) {
    const bool column = columnIndex(array.name) < kColumnCount;
    if (column && array.shape != shape) {
      throw InputError({what}, fmt::format("{} has the shape ({}), the points ({})", array.name,
                                           fmt::join(array.shape, ", "), fmt::join(shape, ", ")));
    }
    if (&array == &*positions || array.shape != shape || elementBytes(array.type) == 0) continue;
    const bool label = array.name == "labels" || array.name == "classes" || array.name == "semantic";
    addColumn(array, label ? "label" : std::string_view(array.name), what, scan);
  }
  const auto most = [](const std::vector<std::uint16_t>& values) {
    return values.empty() ? 0u : *std::max_element(values.begin(), values.end()) + 1u;
  };
  scan.rings = most(scan[kRing]);
  scan.columns = most(scan[kColumn]);
  if (shape.size() == 2) {  // the planes of several returns stand below one another, each with all rings
    const auto rows = static_cast<std::uint32_t>(shape[0]);
    scan.organised = true;
    scan.planes = scan.rings > 0 && rows % scan.rings == 0 ? rows / scan.rings : 1;
    scan.rings = scan.planes == 0 ? 0 : rows / scan.planes;
    scan.columns = static_cast<std::uint32_t>(shape[1]);
  }
  return scan;
}

}  // namespace scanmill
