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

std::optional<double> numberOf(const data* value) {
  if (value == nullptr || !value->is_string()) return std::nullopt;
  const std::string& text = value->string_value();
  char* end = nullptr;
  const double number = std::strtod(text.c_str(), &end);
  if (text.empty() || *end != 0 || !std::isfinite(number)) return std::nullopt;
  return number;
}

const std::map<std::string, std::function<std::string(double)>>& numberFormats() {
  static const std::map<std::string, std::function<std::string(double)>> formats{
      {"m", metresText},       {"s", secondsText},
      {"amount", shortNumber}, {"share", shareText},
      {"factor", factorText},  {"bytes", shortBytes},
      {"digits", threeDigits}, {"count", [](double value) { return grouped(static_cast<std::uint64_t>(value)); }}};
  return formats;
}

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

class FormatContext : public kainjow::mustache::context<std::string> {
 public:
  explicit FormatContext(const data* values) { context::push(values); }

  const data* get(const std::string& name) const override {
    const std::size_t colon = name.find(':');
    if (colon == std::string::npos) return context::get(name);
    const std::string path = name.substr(0, colon), format = name.substr(colon + 1);
    if (format == "any") return keep(data(isAny(context::get(path))));
    if (format == "join") return keepText(joined(context::get(path)));
    if (format == "words") {
      const data* value = context::get(path);
      return value == nullptr || !value->is_string() ? nullptr : keepText(keyAsWords(value->string_value()));
    }
    const std::optional<double> number = figure(path);
    if (!number) return nullptr;
    if (format.starts_with("plural=")) {
      return keepText(pluralOf(static_cast<std::uint64_t>(*number), format.substr(format.find('=') + 1)));
    }
    if (format == "unit") {
      const data* unit = context::get("unit");
      const bool any = unit != nullptr && unit->is_string();
      return keepText(fmt::format("{:.3g}{}{}", *number, any ? " " : "", any ? unit->string_value() : ""));
    }
    const auto known = numberFormats().find(format);
    return keepText(known != numberFormats().end() ? known->second(*number)
                                                   : fmt::format(fmt::runtime("{:" + format + "}"), *number));
  }

 private:
  std::optional<double> figure(const std::string& path) const {
    const std::size_t slash = path.find('/');
    if (slash == std::string::npos) return numberOf(context::get(path));
    const std::optional<double> part = numberOf(context::get(path.substr(0, slash)));
    const std::optional<double> whole = numberOf(context::get(path.substr(slash + 1)));
    if (!part || !whole) return std::nullopt;
    return *whole == 0 ? 0 : *part / *whole;
  }

  const data* keep(data value) const { return &kept_.emplace_back(std::move(value)); }
  const data* keepText(const std::string& text) const { return keep(text.empty() ? data(false) : data(text)); }

  mutable std::deque<data> kept_;  // owns the data to which get() has returned pointers
};

}  // namespace

std::string fillTemplate(const std::string& text, const Json& values, const TextEscape& escape,
                         const TemplateMacros& macros) {
  data all = dataOf(values);
  for (const auto& [name, write] : macros) {
    all.set(name, data(kainjow::mustache::lambda2(
                      [write = write](const std::string& inner, const kainjow::mustache::renderer& render) {
                        return render(write(inner), false);
                      })));
  }
  kainjow::mustache::mustache filled(text);
  filled.set_custom_escape(escape ? escape : [](const std::string& value) { return value; });
  FormatContext context(&all);
  std::string out = filled.render(static_cast<kainjow::mustache::basic_context<std::string>&>(context));
  if (!filled.is_valid()) throw Error("a template of this program is wrong: " + filled.error_message());
  return out;
}

}  // namespace scanmill
