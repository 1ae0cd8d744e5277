#include "report/page/report_html.h"

#include <fmt/core.h>

#include <algorithm>
#include <charconv>
#include <cmath>

#include "base/base64.h"
#include "base/hash.h"
#include "charts/svg_text.h"

namespace scanmill {

namespace {

constexpr const char* kCss = R"(
:root{color-scheme:light dark;--page:#f4f6f8;--card:#ffffff;--ink:#1f2328;--muted:#59636e;--line:#dfe3e8;--accent:#0072B2;
--strong:#eaf3fa;--bad:#b3360b}
@media (prefers-color-scheme:dark){:root{--page:#0b0e13;--card:#12161c;--ink:#e6edf3;--muted:#9aa4af;--line:#2a313b;
--accent:#58b0ea;--strong:#14283a;--bad:#f08a5d}}
*{box-sizing:border-box}
body{margin:0;background:var(--page);color:var(--ink);font:15px/1.5 Helvetica,Arial,'Liberation Sans',sans-serif}
main{max-width:1220px;margin:0 auto;padding:28px 20px 60px}
h1{font-size:27px;line-height:1.2;margin:0 0 4px}
h2{font-size:20px;margin:40px 0 6px;scroll-margin-top:10px}
h3{font-size:15px;margin:0 0 4px}
p{margin:6px 0;max-width:88ch}.lead,.small{color:var(--muted)}.small{font-size:13px}
a{color:var(--accent);text-decoration:none}a:hover{text-decoration:underline}
nav{display:flex;flex-wrap:wrap;gap:2px 16px;margin:14px 0 0;font-size:13.5px}
dl.facts{display:grid;grid-template-columns:max-content 1fr;gap:3px 18px;margin:16px 0 0;background:var(--card);
border:1px solid var(--line);border-radius:8px;padding:14px 18px;font-size:14px}
dl.facts dt{color:var(--muted)}dl.facts dd{margin:0;overflow-wrap:anywhere}
.card{background:var(--card);border:1px solid var(--line);border-left:4px solid var(--accent);border-radius:8px;
padding:12px 18px}
.cards{display:grid;grid-template-columns:repeat(auto-fit,minmax(min(430px,100%),1fr));gap:12px;margin:12px 0}
.card code{display:block;margin-top:6px}
.card.none{border-left-color:var(--line)}.card .need{color:var(--muted);font-size:13px;margin:0 0 2px}
.card h3{font-size:16px;overflow-wrap:anywhere}
code,pre{font-family:ui-monospace,SFMono-Regular,Menlo,Consolas,'DejaVu Sans Mono',monospace;font-size:12.5px}
code{overflow-wrap:anywhere}
pre{background:var(--card);border:1px solid var(--line);border-radius:8px;padding:10px 14px;overflow-x:auto;margin:8px 0}
figure{margin:0;background:var(--card);border:1px solid var(--line);border-radius:8px;padding:4px;overflow-x:auto}
figure svg{display:block;max-width:100%;height:auto;margin:0 auto}
figure img{display:block;width:100%;border-radius:5px}
figure.picture{cursor:zoom-in}figure.picture.wide{cursor:zoom-out}
figcaption{padding:6px 12px;font-size:13px;color:var(--muted)}
.figures{display:grid;grid-template-columns:repeat(2,minmax(0,1fr));grid-auto-flow:row dense;gap:12px;margin:12px 0}
.figures>figure:only-child,.figures>figure.wide{grid-column:1/-1}
@media (max-width:980px){.figures{grid-template-columns:minmax(0,1fr)}}
@media (max-width:640px){figure svg{max-width:none;margin:0}h1{font-size:23px}
dl.facts{grid-template-columns:1fr;gap:0}dl.facts dd{margin:0 0 6px}}
.table{overflow:auto;width:fit-content;max-width:100%;max-height:78vh;border:1px solid var(--line);border-radius:8px;background:var(--card)}
.scroller{position:relative;width:fit-content;max-width:100%;margin:12px 0}
.scroller>.hint{display:none;margin:0 0 4px;max-width:none;font-size:13px;color:var(--accent)}
.scroller.more>.hint{display:block}.scroller.end>.hint{visibility:hidden}
.scroller.more:not(.end)::after{content:"";position:absolute;top:26px;right:1px;bottom:1px;width:36px;z-index:3;
pointer-events:none;background:linear-gradient(to right,transparent,rgba(0,114,178,.28));border-radius:0 8px 8px 0}
.scroller.more th:first-child,.scroller.more td:first-child{border-right:1px solid var(--line)}
.wide .scroller{left:50%;transform:translateX(-50%);width:max-content;min-width:100%;
max-width:calc(100vw - 56px)}
table{border-collapse:separate;border-spacing:0;font-size:12.5px;font-variant-numeric:tabular-nums}
th,td{padding:4px 10px;text-align:right;white-space:nowrap;border-bottom:1px solid var(--line)}
tbody tr:last-child td{border-bottom:0}
th{background:var(--card);color:var(--muted);font-weight:600;position:sticky;top:0;z-index:1}
thead tr.columns th{cursor:pointer;user-select:none}
thead tr.groups+tr.columns th{top:27px}
thead tr.groups th{text-align:center;border-left:1px solid var(--line)}thead tr.groups th:first-child{border-left:0}
thead tr.columns th:hover{color:var(--ink)}
th[aria-sort=ascending]::after{content:" \2191"}th[aria-sort=descending]::after{content:" \2193"}
th:first-child,td:first-child{text-align:left;position:sticky;left:0;background:var(--card)}
th:first-child{z-index:2}
td:first-child{font-family:ui-monospace,SFMono-Regular,Menlo,Consolas,'DejaVu Sans Mono',monospace;font-size:12px}
tr.strong td,tr.strong td:first-child{background:var(--strong)}tr.strong td:first-child{font-weight:700}
tbody tr:hover td{background:var(--strong)}
th.words,td.words{text-align:left}
td.why{text-align:left;color:var(--bad);white-space:normal}
@media (max-width:640px){td:first-child{min-width:132px;max-width:46vw;white-space:normal;overflow-wrap:anywhere}}
details{margin:10px 0}summary{cursor:pointer;color:var(--accent)}
ul{padding-left:22px;margin:6px 0}
)";

constexpr const char* kScript = R"(
document.querySelectorAll('tr.columns th').forEach(function(th){
  th.addEventListener('click',function(){
    var table=th.closest('table'),body=table.tBodies[0],at=th.cellIndex;
    var down=th.getAttribute('aria-sort')==='ascending';
    table.querySelectorAll('tr.columns th').forEach(function(o){o.removeAttribute('aria-sort')});
    th.setAttribute('aria-sort',down?'descending':'ascending');
    var key=function(row){
      var cell=row.cells[at];
      if(!cell||cell.className==='why')return null;
      return cell.dataset.v===undefined?cell.textContent:Number(cell.dataset.v);
    };
    Array.from(body.rows).sort(function(a,b){
      var x=key(a),y=key(b);
      if(x===null||y===null)return (x===null)-(y===null);
      var order=typeof x==='number'&&typeof y==='number'?x-y:String(x).localeCompare(String(y));
      return down?-order:order;
    }).forEach(function(row){body.appendChild(row)});
  });
});
document.querySelectorAll('.scroller').forEach(function(box){
  var table=box.querySelector('.table');
  var look=function(){
    var hidden=table.scrollWidth-table.clientWidth;
    box.classList.toggle('more',hidden>2);
    box.classList.toggle('end',hidden>2&&table.scrollLeft>=hidden-2);
  };
  table.addEventListener('scroll',look);
  window.addEventListener('resize',look);
  var fold=box.closest('details');
  if(fold)fold.addEventListener('toggle',look);
  look();
});
document.querySelectorAll('figure.picture').forEach(function(figure){
  figure.addEventListener('click',function(){figure.classList.toggle('wide')});
});
)";

constexpr double kHalfRow = 600;  // pixels: of a chart that two abreast hardly shrink

// Of the element's attribute; 0 where it has none.
double svgWidth(std::string_view svg) {
  constexpr std::string_view kName = " width=\"";
  const std::string_view element = svg.substr(0, svg.find('>'));
  const std::size_t at = element.find(kName);
  double width = 0;
  if (at == std::string_view::npos) return width;
  const std::string_view value = element.substr(at + kName.size());
  std::from_chars(value.data(), value.data() + value.size(), width);
  return width;
}

std::string attribute(const char* name, const std::string& value) {
  return value.empty() ? "" : fmt::format(" {}=\"{}\"", name, escapeXml(value));
}

// As a Content-Security-Policy names a script that may run: its SHA-256, in base64 (W3C, CSP level 3, 2.3.1).
std::string scriptSource(const std::string& script) {
  const std::string hex = sha256(script);
  std::string bytes;
  for (std::size_t i = 0; i + 1 < hex.size(); i += 2) {
    unsigned value = 0;
    std::from_chars(hex.data() + i, hex.data() + i + 2, value, 16);
    bytes += static_cast<char>(value);
  }
  return fmt::format(" 'sha256-{}'", base64(bytes));
}

}  // namespace

void HtmlTable::group(std::string title, std::size_t columns) {
  groups_.push_back({std::move(title), columns});
}

void HtmlTable::column(std::string title, std::string hint, bool words) {
  columns_.push_back({std::move(title), std::move(hint), words});
}

void HtmlTable::row(std::vector<HtmlCell> cells, bool strong) {
  rows_.push_back({std::move(cells), strong, false});
}

void HtmlTable::failure(std::string name, std::string why) {
  rows_.push_back({{{std::move(name)}, {std::move(why)}}, false, true});
}

std::string HtmlTable::html() const {
  std::string out =
      "<div class=\"scroller\"><p class=\"hint\">Scroll sideways for more columns \xE2\x86\x92</p>"
      "<div class=\"table\" tabindex=\"0\"><table><thead>";
  if (!groups_.empty()) {
    out += "<tr class=\"groups\">";
    for (const Group& g : groups_) out += fmt::format("<th colspan=\"{}\">{}</th>", g.columns, escapeXml(g.title));
    out += "</tr>";
  }
  out += "<tr class=\"columns\">";
  for (const Column& c : columns_) {
    out += fmt::format("<th{}{}>{}</th>", attribute("class", c.words ? "words" : ""), attribute("title", c.hint),
                       escapeXml(c.title));
  }
  out += "</tr></thead><tbody>\n";
  for (const Row& row : rows_) {
    out += row.strong ? "<tr class=\"strong\">" : "<tr>";
    for (std::size_t i = 0; i < row.cells.size(); ++i) {
      const HtmlCell& cell = row.cells[i];
      if (row.failed && i == 1) {
        out += fmt::format("<td class=\"why\" colspan=\"{}\">{}</td>", std::max<std::size_t>(columns_.size(), 2) - 1,
                           escapeXml(cell.text));
        continue;
      }
      const std::string order = std::isfinite(cell.order) ? fmt::format(" data-v=\"{:.9g}\"", cell.order) : "";
      const bool words = i < columns_.size() && columns_[i].words;
      out += fmt::format("<td{}{}{}>{}</td>", attribute("class", words ? "words" : ""), order,
                         attribute("title", cell.hint), escapeXml(cell.text));
    }
    out += "</tr>\n";
  }
  return out + "</tbody></table></div></div>\n";
}

std::string htmlPage(const std::string& title, const std::string& head, const std::vector<HtmlSection>& sections,
                     const HtmlExtras& extras) {
  std::string nav, body;
  for (const HtmlSection& s : sections) {
    if (s.body.empty()) continue;
    nav += fmt::format("<a href=\"#{}\">{}</a>\n", s.id, escapeXml(s.title));
    body += fmt::format("<section{}>\n<h2 id=\"{}\">{}</h2>\n{}{}</section>\n", s.wide ? " class=\"wide\"" : "", s.id,
                        escapeXml(s.title), s.lead.empty() ? "" : htmlParagraph(s.lead, "lead"), s.body);
  }
  std::string sources = scriptSource(kScript);
  std::string scripts = fmt::format("<script>{}</script>\n", kScript);
  for (const std::string& script : extras.scripts) {
    sources += scriptSource(script);
    scripts += fmt::format("<script>{}</script>\n", script);
  }
  return fmt::format(
      "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
      "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; script-src{6}; "
      "style-src 'unsafe-inline'; img-src data:; connect-src 'none'; base-uri 'none'; form-action 'none'\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>{0}</title>\n"
      "<style>{1}{7}</style>\n</head>\n<body>\n<main>\n<h1>{0}</h1>\n{2}<nav>\n{3}</nav>\n{4}</main>\n"
      "{5}</body>\n</html>\n",
      escapeXml(title), kCss, head, nav, body, scripts, sources, extras.css);
}

std::string htmlParagraph(const std::string& text, const char* kind) {
  return *kind == 0 ? fmt::format("<p>{}</p>\n", escapeXml(text))
                    : fmt::format("<p class=\"{}\">{}</p>\n", kind, escapeXml(text));
}

std::string htmlCode(const std::string& text) {
  return fmt::format("<pre>{}</pre>\n", escapeXml(text));
}

std::string htmlDetails(const std::string& summary, const std::string& body) {
  return body.empty() ? "" : fmt::format("<details><summary>{}</summary>\n{}</details>\n", escapeXml(summary), body);
}

std::string htmlFigures(const std::vector<std::string>& svgs) {
  std::string figures;
  for (const std::string& svg : svgs) {
    if (svg.empty()) continue;
    figures += fmt::format("<figure{}>{}</figure>\n", svgWidth(svg) > kHalfRow ? " class=\"wide\"" : "", svg);
  }
  return figures.empty() ? "" : fmt::format("<div class=\"figures\">\n{}</div>\n", figures);
}

}  // namespace scanmill
