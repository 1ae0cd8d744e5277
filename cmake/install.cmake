# What is installed: the program with its files, the core as one archive with its headers.

# The core as one archive, for other C++ programs.
list(TRANSFORM core_libraries REPLACE "(.+)" "$<TARGET_OBJECTS:\\1>" OUTPUT_VARIABLE objects)
add_library(scanmill_archive STATIC ${objects})
set_target_properties(scanmill_archive PROPERTIES OUTPUT_NAME scanmill EXPORT_NAME scanmill)
target_include_directories(scanmill_archive INTERFACE $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}/scanmill>)
target_link_options(scanmill_archive INTERFACE
                    $<INSTALL_INTERFACE:-Wl,-rpath,$<INSTALL_PREFIX>/${CMAKE_INSTALL_LIBDIR}/scanmill>)
target_compile_features(scanmill_archive INTERFACE cxx_std_20)
target_link_libraries(scanmill_archive INTERFACE $<INSTALL_INTERFACE:embree;hwy::hwy;assimp::assimp;meshoptimizer::meshoptimizer;draco::draco;pugixml::pugixml;lzf;re2;TBB::tbb;OpenSSL::Crypto;LibArchive::LibArchive;PNG::PNG;JPEG::JPEG;OpenEXR::OpenEXR;yaml-cpp;fmt::fmt;Threads::Threads;${CMAKE_DL_LIBS}>)

include(CMakePackageConfigHelpers)
set(package ${CMAKE_INSTALL_LIBDIR}/cmake/scanmill)
configure_package_config_file(src/scanmill-config.cmake.in scanmill-config.cmake INSTALL_DESTINATION ${package})
write_basic_package_version_file(scanmill-config-version.cmake COMPATIBILITY SameMinorVersion)
install(TARGETS scanmill_archive EXPORT scanmill ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT development)
install(EXPORT scanmill NAMESPACE scanmill:: DESTINATION ${package} FILE scanmill-targets.cmake
        COMPONENT development)
install(FILES ${PROJECT_BINARY_DIR}/scanmill-config.cmake ${PROJECT_BINARY_DIR}/scanmill-config-version.cmake
        DESTINATION ${package} COMPONENT development)

# What a program of others includes, and what these headers include.
set(public_headers
    base/error.h
    config/resources.h
    dataset/manifest.h
    dataset/reader.h
    dataset/verify.h
    formats/format.h
    methods/method.h
    pipeline/run/generate.h
    pipeline/read/pipeline.h
    pipeline/plan/plan.h
    pipeline/scenes/shot_source.h
    scan/scan.h
    scene/builder.h
    scene/scene.h
    scenefile/scene_file.h
    sense/sense.h
    sensors/sensor.h
    sensors/shot.h)
scanmill_include_closure(installed_headers ${public_headers})
foreach(header ${installed_headers})
  cmake_path(GET header PARENT_PATH folder)
  install(FILES src/core/${header} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/scanmill/${folder} COMPONENT development)
endforeach()
install(DIRECTORY pipelines scenes labels DESTINATION ${CMAKE_INSTALL_DATADIR}/scanmill COMPONENT program)
install(FILES scripts/blender_passes.py DESTINATION ${CMAKE_INSTALL_DATADIR}/scanmill/scripts COMPONENT program)
install(FILES README.md CHANGELOG.md DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/scanmill COMPONENT program)
install(DIRECTORY docs DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/scanmill COMPONENT program)
install(FILES LICENSE DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/scanmill RENAME copyright COMPONENT program)
install(FILES LICENSE DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/libscanmill-dev RENAME copyright COMPONENT development)

# What the program says of its commands, as manual page and for the completion of bash.
if(SCANMILL_STUDIO)
  install(TARGETS scanmill RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT program)
endif()
if(SCANMILL_STUDIO AND NOT SCANMILL_SANITIZE)
  find_package(Python3 REQUIRED COMPONENTS Interpreter)
  set(pages ${PROJECT_BINARY_DIR}/pages)
  add_custom_command(OUTPUT ${pages}/scanmill.1 ${pages}/scanmill.bash DEPENDS scanmill scripts/program_pages.py
                     COMMAND Python3::Interpreter ${PROJECT_SOURCE_DIR}/scripts/program_pages.py $<TARGET_FILE:scanmill> ${pages})
  add_custom_target(scanmill_pages ALL DEPENDS ${pages}/scanmill.1 ${pages}/scanmill.bash)
  install(FILES ${pages}/scanmill.1 DESTINATION ${CMAKE_INSTALL_MANDIR}/man1 COMPONENT program)
  install(FILES ${pages}/scanmill.bash DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions RENAME scanmill
          COMPONENT program)
endif()
