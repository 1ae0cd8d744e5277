#pragma once

// Opens pages in Chromium, as somebody opens them.

#include <string>
#include <vector>

#include "base/file.h"
#include "base/process.h"

namespace scanmill {

inline bool hasBrowser() {
  return !findProgram("chromium").empty();
}

// The <body ...> of a page once its scripts have run. The browser keeps its files in `folder`.
inline std::string bodyInBrowser(const std::filesystem::path& folder, const std::string& page,
                                 const std::vector<std::string>& flags = {}) {
  std::vector<std::string> command{"chromium",
                                   "--headless=new",
                                   "--no-sandbox",
                                   "--disable-quic",
                                   "--no-first-run",
                                   "--disable-background-networking",
                                   "--disable-component-update",
                                   "--disable-sync",
                                   "--window-size=1200,2400",
                                   "--virtual-time-budget=5000",
                                   "--dump-dom",
                                   "--user-data-dir=" + (folder / "profile").string()};
  command.insert(command.end(), flags.begin(), flags.end());
  command.push_back("file://" + page);
  Process browser(command, {{"HOME", folder.string()}});
  browser.closeInput();
  std::string dom;
  while (const auto line = browser.readLine(120)) dom += *line + "\n";
  browser.wait(60);
  const std::size_t begin = dom.find("<body");
  return begin == std::string::npos ? "" : dom.substr(begin, dom.find('>', begin) - begin);
}

// The attribute data-NAME of such a body.
inline std::string dataOf(const std::string& body, const std::string& name) {
  const std::string mark = "data-" + name + "=\"";
  const std::size_t begin = body.find(mark);
  if (begin == std::string::npos) return "absent";
  return body.substr(begin + mark.size(), body.find('"', begin + mark.size()) - begin - mark.size());
}

}  // namespace scanmill
