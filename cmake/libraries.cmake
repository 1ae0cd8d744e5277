# What makes libraries, modules and texts of folders and files.

# scanmill_caps(src N tests N): the most lines of both folders (scripts/check_layers).
function(scanmill_caps)
endfunction()

# scanmill_library(LAYER NAME "subject" CAP N ...): the folder src/LAYER/NAME becomes a static library. It may include the
# libraries before it; the studio may include the core, never the other way round (scripts/check_layers). CAP: its most
# lines. BATCH: how many sources are compiled as one; the fewer, the less a change of one of them compiles. OPTIMIZE: the
# level of a release, 3 where none is said; 1 where no loop of the library takes time. PRIVATE: the libraries of others that
# it links. A library may have folders that are libraries of their own and stand before it: methods/world is
# scanmill_methods_world.
function(scanmill_library layer path subject)
  string(REPLACE / _ name ${path})
  cmake_parse_arguments(LIBRARY "" "CAP;BATCH;OPTIMIZE" "PRIVATE" ${ARGN})
  if(NOT LIBRARY_BATCH)
    set(LIBRARY_BATCH 6)
  endif()
  set(folder ${PROJECT_SOURCE_DIR}/src/${layer}/${path})
  file(GLOB sources CONFIGURE_DEPENDS ${folder}/*.cpp ${folder}/*/*.cpp)
  list(FILTER sources EXCLUDE REGEX "_module(\\.cpp|/[^/]+)$")
  get_property(folders GLOBAL PROPERTY SCANMILL_LIBRARY_FOLDERS)
  foreach(other ${folders})
    list(FILTER sources EXCLUDE REGEX "^${other}/")
  endforeach()
  set_property(GLOBAL APPEND PROPERTY SCANMILL_LIBRARY_FOLDERS ${folder})
  add_library(scanmill_${name} STATIC ${sources})
  get_property(before GLOBAL PROPERTY SCANMILL_LIBRARIES)
  list(REVERSE before)
  target_link_libraries(scanmill_${name} PUBLIC scanmill_options ${before} PRIVATE ${LIBRARY_PRIVATE})
  set_target_properties(scanmill_${name} PROPERTIES UNITY_BUILD ${SCANMILL_UNITY} UNITY_BUILD_BATCH_SIZE ${LIBRARY_BATCH})
  if(SCANMILL_UNITY AND CMAKE_CXX_COMPILER_ID STREQUAL GNU)
    # g++ does not say it of the file that it compiles, but of files that this one includes.
    target_compile_options(scanmill_${name} PRIVATE -Wno-subobject-linkage)
  endif()
  target_include_directories(scanmill_${name} PUBLIC ${PROJECT_SOURCE_DIR}/src/${layer})
  if(SCANMILL_FUZZ)
    target_compile_options(scanmill_${name} PRIVATE -fsanitize=fuzzer-no-link)
  endif()
  if(LIBRARY_OPTIMIZE AND CMAKE_BUILD_TYPE STREQUAL Release)
    target_compile_options(scanmill_${name} PRIVATE -O${LIBRARY_OPTIMIZE})
  endif()
  set_property(GLOBAL APPEND PROPERTY SCANMILL_LIBRARIES scanmill_${name})
endfunction()

# scanmill_module(LAYER NAME OTHER ...): libscanmill_NAME.so of OTHER_module.cpp in the library's folder, or of all of its
# folder OTHER_module, and the libraries of others; it contains no code of ours but headers. Whatever links the library
# builds it.
function(scanmill_module layer name other)
  set(target scanmill_${name}_module)
  set(folder ${PROJECT_SOURCE_DIR}/src/${layer}/${name})
  file(GLOB sources CONFIGURE_DEPENDS ${folder}/${other}_module.cpp ${folder}/${other}_module/*.cpp)
  add_library(${target} MODULE ${sources})
  target_include_directories(${target} PRIVATE ${PROJECT_SOURCE_DIR}/src/${layer})
  target_link_libraries(${target} PRIVATE scanmill_options ${ARGN})
  set_target_properties(${target} PROPERTIES OUTPUT_NAME scanmill_${name} LIBRARY_OUTPUT_DIRECTORY ${CMAKE_BUILD_RPATH}
                                             CXX_VISIBILITY_PRESET hidden BUILD_RPATH "" INSTALL_RPATH "")
  add_dependencies(scanmill_${name} ${target})
  install(TARGETS ${target} LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR}/scanmill COMPONENT program)
  if(SCANMILL_PYTHON AND layer STREQUAL core)
    install(TARGETS ${target} LIBRARY DESTINATION ${python_folder}/scanmill/lib COMPONENT python EXCLUDE_FROM_ALL)
  endif()
endfunction()

# Sets `result` to the text of a file, in which each line `#include "OTHER"` is replaced by the text of that file in the same
# folder, at its first place. CMake runs again when one of them changes.
function(scanmill_included_text result file)
  get_filename_component(folder ${file} DIRECTORY)
  set(found ${file})
  file(READ ${file} text)
  while(text MATCHES "\n#include \"([^\"\n]+)\"\n")
    set(other ${folder}/${CMAKE_MATCH_1})
    string(FIND "${text}" "${CMAKE_MATCH_0}" place)
    string(LENGTH "${CMAKE_MATCH_0}" length)
    math(EXPR end "${place} + ${length}")
    string(SUBSTRING "${text}" 0 ${place} before)
    string(SUBSTRING "${text}" ${end} -1 behind)
    set(inserted "")
    if(NOT other IN_LIST found)
      if(NOT EXISTS ${other})
        message(FATAL_ERROR "${file} includes \"${CMAKE_MATCH_1}\": there is no ${other}")
      endif()
      list(APPEND found ${other})
      file(READ ${other} inserted)
    endif()
    set(text "${before}\n${inserted}${behind}")
  endwhile()
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${found})
  set(${result} "${text}" PARENT_SCOPE)
endfunction()

# scanmill_text(LIBRARY NAME FILE): a file of text that the program carries, with what it includes, as
# `extern const std::string_view NAME` of namespace scanmill.
function(scanmill_text library name file)
  scanmill_included_text(text ${file})
  set(source ${PROJECT_BINARY_DIR}/generated/${library}/${name}.cpp)
  file(CONFIGURE OUTPUT ${source} @ONLY CONTENT [[#include <string_view>
namespace scanmill {
extern const std::string_view @name@;
const std::string_view @name@ = R"scanmilltext(@text@)scanmilltext";
}  // namespace scanmill
]])
  target_sources(scanmill_${library} PRIVATE ${source})
endfunction()

# Sets `result` to the headers (relative to src/core or src/studio) and all of ours that they include, directly or not.
# CMake runs again when one of them changes.
function(scanmill_include_closure result)
  set(open ${ARGN})
  set(found ${open})
  while(open)
    list(POP_FRONT open header)
    set(file ${PROJECT_SOURCE_DIR}/src/core/${header})
    if(NOT EXISTS ${file})
      set(file ${PROJECT_SOURCE_DIR}/src/studio/${header})
    endif()
    if(NOT EXISTS ${file})
      continue()  # one that CMake writes
    endif()
    set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${file})
    file(STRINGS ${file} includes REGEX [[^#include "]])
    list(TRANSFORM includes REPLACE [[^#include "([^"]+)".*]] [[\1]])
    list(REMOVE_ITEM includes "" ${found})
    list(APPEND open ${includes})
    list(APPEND found ${includes})
  endwhile()
  set(${result} ${found} PARENT_SCOPE)
endfunction()
