#include "commands/recorded_scans.h"

#include <fmt/core.h>

#include "base/error.h"
#include "dataset/scan_store.h"

namespace scanmill {

std::string requiredText(const Arguments& parsed, const std::string& option, const std::string& what) {
  std::string text = parsed.options.count(option) == 0 ? std::string() : parsed.options[option].as<std::string>();
  if (text.empty()) throw InputError(fmt::format("--{} is missing: {}", option, what));
  return text;
}

void forEachScan(const std::vector<std::string>& given,
                 const std::function<void(const Scan&, const std::string&)>& visit) {
  for (const std::string& path : given) {
    const ScanStore store(path);
    for (std::size_t i = 0; i < store.keys().size(); ++i) {
      visit(store.decode(i, store.scans(i).front()), store.single() ? path : store.keys()[i]);
    }
  }
}

std::filesystem::path requiredFile(const Arguments& parsed, const std::string& what) {
  std::filesystem::path out = requiredText(parsed, "out", what);
  std::error_code ignored;
  if (std::filesystem::is_directory(out, ignored)) throw InputError({out.string()}, "is a folder: name a file");
  if (std::filesystem::exists(out, ignored) && parsed.options.count("overwrite") == 0) {
    throw InputError({out.string()}, "exists: choose another name or pass --overwrite");
  }
  return out;
}

}  // namespace scanmill
