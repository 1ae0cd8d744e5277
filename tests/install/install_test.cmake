# Installs into a new folder, moves it, looks at what is there, builds programs of somebody else against it, and runs
# them and the own program there.
#   cmake -DBUILD=... -DSOURCE=... -DWORK=... -DCOMPILER=... -DHEADERS=a.h,b.h -DPROGRAM=ON -P install_test.cmake
# HEADERS: those that a program of others includes; PROGRAM: the program is installed too.

include(${CMAKE_CURRENT_LIST_DIR}/run.cmake)

file(REMOVE_RECURSE ${WORK})
run(${CMAKE_COMMAND} --install ${BUILD} --prefix ${WORK}/first)
file(RENAME ${WORK}/first ${WORK}/prefix)

# The headers that are installed are those that the public ones reach, by the compiler's word, and no library's.
set(include ${WORK}/prefix/include/scanmill)
string(REPLACE "," ">\n#include <" includes "#include <${HEADERS}>\n")
file(WRITE ${WORK}/public.cpp "${includes}")
execute_process(COMMAND ${COMPILER} -std=c++20 -M -I ${include} ${WORK}/public.cpp OUTPUT_VARIABLE reached
                COMMAND_ERROR_IS_FATAL ANY)
string(REGEX MATCHALL "[^ \n\\]+" reached "${reached}")
list(FILTER reached INCLUDE REGEX "^${include}/")
file(GLOB_RECURSE installed ${include}/*)
list(SORT reached)
list(SORT installed)
if(NOT installed STREQUAL reached)
  message(FATAL_ERROR "installed:\n${installed}\nreached from the public headers:\n${reached}")
endif()
foreach(header ${installed})
  file(STRINGS ${header} foreign REGEX "^ *# *include *<[^>]*[./]")
  if(foreign)
    message(FATAL_ERROR "${header} needs the headers of a library: ${foreign}")
  endif()
endforeach()

# docs/architecture.md shows one of these programs whole.
file(READ ${SOURCE}/consumer/scan.cpp program)
file(READ ${SOURCE}/../../docs/architecture.md page)
string(FIND "${page}" "${program}" shown)
if(shown EQUAL -1)
  message(FATAL_ERROR "docs/architecture.md shows another program than tests/install/consumer/scan.cpp")
endif()

run(${CMAKE_COMMAND} -S ${SOURCE}/consumer -B ${WORK}/build -G Ninja -DCMAKE_BUILD_TYPE=Release -DPUBLIC=${HEADERS}
    -DCMAKE_CXX_COMPILER=${COMPILER} -DCMAKE_PREFIX_PATH=${WORK}/prefix)
run(${CMAKE_COMMAND} --build ${WORK}/build)
set(share ${WORK}/prefix/share/scanmill)
run(${WORK}/build/scan ${share})
run(${WORK}/build/generate ${share}/pipelines/quickstart.yaml ${WORK}/dataset)
if(PROGRAM)
  run(${WORK}/prefix/bin/scanmill verify ${WORK}/dataset)
  run(${WORK}/prefix/bin/scanmill view ${WORK}/dataset --screenshot ${WORK}/picture.png)
  run(${WORK}/prefix/bin/scanmill list scenes)
endif()
file(REMOVE_RECURSE ${WORK})
