#include "study/text_template.h"

#include <fmt/core.h>

#include <cmath>
#include <deque>
#include <kainjow/mustache.hpp>
#include <optional>

#include "base/error.h"
#include "base/short_text.h"
#include "study/figure_text.h"

namespace scanmill {

namespace {

using kainjow::mustache::data;

// Converts JSON to template data. Numbers become text with all digits; only a format in the template shortens them.
data dataOf(const Json& json) {
  if (json.is_object()) {
    data object(data::type::object);
    for (const auto& [key, value] : json.items()) object.set(key, dataOf(value));
    return object;
  }
  if (json.is_array()) {
    data list(data::type::list);
    for (const Json& item : json) list.push_back(dataOf(item));
    return list;
  }
  if (json.is_boolean()) return data(json.get<bool>());
  if (json.is_string() && !json.get_ref<const std::string&>().empty()) return {json.get<std::string>()};
  if (json.is_number() && std::isfinite(json.get<double>())) return {json.dump()};
  return data(false);
}

// Returns a value as a number; nothing if the value is absent (null) or not a finite number.
std::optional<double> numberOf(const data* value) {
  if (value == nullptr || !value->is_string()) return std::nullopt;
  const std::string& text = value->string_value();
  char* end = nullptr;
  const double number = std::strtod(text.c_str(), &end);
  if (text.empty() || *end != 0 || !std::isfinite(number)) return std::nullopt;
  return number;
}

// Functions that format a number, by the format's name in templates; text_template.h lists the formats.
const std::map<std::string, std::function<std::string(double)>> kNumberFormats{
    {"m", metresText},
    {"s", secondsText},
    {"amount", shortNumber},
    {"share", shareText},
    {"factor", factorText},
    {"bytes", [](double value) { return shortBytes(value); }},
    {"count", [](double value) { return grouped(static_cast<std::uint64_t>(value)); }}};

// True if the value is present and counts as not empty; the number 0 counts as empty here.
bool isAny(const data* value) {
  if (value == nullptr || value->is_false() || value->is_empty_list()) return false;
  return numberOf(value).value_or(1) != 0;
}

std::string joined(const data* list) {
  std::string text;
  if (list == nullptr || !list->is_list()) return text;
  for (const data& item : list->list_value()) text += (text.empty() ? "" : ", ") + item.string_value();
  return text;
}

// The values of a template, by "name", by "name:format" (formatted) or by "name/name" (the ratio of two values).
class FormatContext : public kainjow::mustache::context<std::string> {
 public:
  explicit FormatContext(const data* values) { context::push(values); }

  // Returns the value for a name in the template, formatted if the name has a format; null if the value is empty.
  const data* get(const std::string& name) const override {
    const std::size_t colon = name.find(':');
    if (colon == std::string::npos) return context::get(name);
    const std::string path = name.substr(0, colon), format = name.substr(colon + 1);
    if (format == "any") return keep(data(isAny(context::get(path))));
    if (format == "join") return keepText(joined(context::get(path)));
    const std::optional<double> number = numberAt(path);
    if (!number) return nullptr;
    if (format.starts_with("plural=")) {
      return keepText(pluralOf(static_cast<std::uint64_t>(*number), format.substr(format.find('=') + 1)));
    }
    if (format == "unit") {
      const data* unit = context::get("unit");
      const std::string suffix = unit != nullptr && unit->is_string() ? " " + unit->string_value() : "";
      return keepText(fmt::format("{:.3g}{}", *number, suffix));
    }
    const auto named = kNumberFormats.find(format);
    return keepText(named != kNumberFormats.end() ? named->second(*number)
                                                  : fmt::format(fmt::runtime("{:" + format + "}"), *number));
  }

 private:
  // Returns the number named `path`, or the ratio of two numbers if `path` is "numerator/denominator" (0 if the
  // denominator is 0). Returns nothing if a number is absent.
  std::optional<double> numberAt(const std::string& path) const {
    const std::size_t slash = path.find('/');
    if (slash == std::string::npos) return numberOf(context::get(path));
    const std::optional<double> numerator = numberOf(context::get(path.substr(0, slash)));
    const std::optional<double> denominator = numberOf(context::get(path.substr(slash + 1)));
    if (!numerator || !denominator) return std::nullopt;
    return *denominator == 0 ? 0 : *numerator / *denominator;
  }

  const data* keep(data value) const { return &kept_.emplace_back(std::move(value)); }
  const data* keepText(const std::string& text) const { return keep(text.empty() ? data(false) : data(text)); }

  mutable std::deque<data> kept_;  // owns the data to which get() has returned pointers
};

}  // namespace

std::string fillTemplate(const std::string& text, const Json& values, const TextEscape& escape,
                         const TemplateMacros& macros) {
  data root = dataOf(values);
  for (const auto& [name, macro] : macros) {
    root.set(name, data(kainjow::mustache::lambda2(
                       [macro = macro](const std::string& section, const kainjow::mustache::renderer& render) {
                         return render(macro(section), false);
                       })));
  }
  kainjow::mustache::mustache mustache(text);
  mustache.set_custom_escape(escape ? escape : [](const std::string& value) { return value; });
  FormatContext context(&root);
  std::string filled = mustache.render(static_cast<kainjow::mustache::basic_context<std::string>&>(context));
  if (!mustache.is_valid()) throw Error("a template of this program is wrong: " + mustache.error_message());
  return filled;
}

}  // namespace scanmill
