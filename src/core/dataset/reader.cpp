#include "dataset/reader.h"

#include <fmt/core.h>

#include "base/error.h"
#include "dataset/tar_reader.h"
#include "formats/format.h"

namespace scanmill {

namespace {

constexpr std::size_t kBlockBytes = 1 << 20;  // bytes to read at a time

}  // namespace

void readTar(const std::filesystem::path& file,
             const std::function<void(const std::string&, std::string_view)>& visit) {
  TarReader tar(file, kBlockBytes);
  std::string bytes;
  while (tar.next()) {
    tar.readInto(bytes);
    visit(tar.name(), bytes);
  }
}

Scan decodeMember(const std::string& name, std::string_view bytes) {
  const std::size_t dot = name.rfind('.');
  const std::string suffix = dot == std::string::npos ? std::string() : name.substr(dot + 1);
  const FormatEntry* entry = formatBySuffix(suffix);
  if (entry == nullptr) {
    std::string known;
    for (const FormatEntry& format : formats()) known += fmt::format("{}.{}", known.empty() ? "" : ", ", format.suffix);
    throw InputError({name}, fmt::format("no format reads '.{}' (known: {})", suffix, known));
  }
  Value none;
  none.kind = Value::Kind::Map;
  Fields options(none, "format");
  return entry->make(options)->decode(bytes, name);
}

}  // namespace scanmill
