# Scripts, styles and templates that the pages of reports carry.

# Debian's packages of scripts, which the pages of reports carry.
foreach(script libjs-three:three/build/three.min.js libjs-three:three/examples/js/controls/OrbitControls.js)
  string(REPLACE : ";" script ${script})
  list(POP_FRONT script package)
  get_filename_component(name ${script} NAME)
  find_file(${name} ${script} PATHS /usr/share/javascript /usr/local/share/javascript NO_DEFAULT_PATH)
  if(NOT ${name})
    message(FATAL_ERROR "${script} is missing, which the pages of reports carry: install Debian's package ${package} "
                        "(scripts/setup does), or set -D${name}=/its/path")
  endif()
endforeach()
scanmill_text(report kThreeScript ${three.min.js})
scanmill_text(report kOrbitScript ${OrbitControls.js})
foreach(text kScanViewScript:dataset/scan_view.js kScanViewStyle:dataset/scan_view.css
             kDatasetTemplate:dataset/dataset.html kDatasetStyle:dataset/dataset.css
             kPageLayout:page/page.html kPageStyle:page/page.css kPageScript:page/page.js
             kCompareTemplate:compare/compare.html kTradeoffTemplate:tradeoff/tradeoff.html)
  string(REPLACE : ";" text ${text})
  list(GET text 0 name)
  list(GET text 1 file)
  scanmill_text(report ${name} ${PROJECT_SOURCE_DIR}/src/studio/report/${file})
endforeach()
