# The libraries of others. docs/contributing.md says what each is for.

find_package(Threads REQUIRED)
find_package(fmt REQUIRED)
find_package(yaml-cpp REQUIRED)
find_package(nlohmann_json REQUIRED)
find_package(TBB REQUIRED)
find_package(OpenSSL REQUIRED COMPONENTS Crypto)
find_package(embree REQUIRED)  # 3.13 or 4: see src/core/scene/embree.h
find_package(hwy REQUIRED)  # Google Highway: SIMD
find_package(assimp REQUIRED)
find_package(meshoptimizer REQUIRED)
find_package(pugixml REQUIRED)
find_package(draco REQUIRED)
find_package(OpenEXR 3 REQUIRED)
find_package(VTK 9.1 REQUIRED COMPONENTS CommonCore CommonDataModel CommonMath RenderingCore RenderingOpenGL2 glew)
find_package(OpenGL REQUIRED COMPONENTS EGL)
find_package(PkgConfig REQUIRED)
find_package(LibArchive REQUIRED)
find_package(PNG REQUIRED)
find_package(JPEG REQUIRED)
# What libosmium, which is headers alone, reads files with.
find_package(EXPAT REQUIRED)
find_package(BZip2 REQUIRED)
find_package(ZLIB REQUIRED)
find_package(Eigen3 REQUIRED NO_MODULE)  # headers
find_package(GDAL CONFIG REQUIRED)
find_package(Boost REQUIRED)  # headers: Boost.Polygon
find_file(osmium osmium/io/any_input.hpp REQUIRED)
find_path(NANOFLANN_INCLUDE_DIR nanoflann.hpp REQUIRED)
find_path(XXHASH_INCLUDE_DIR xxhash.h REQUIRED)
find_path(LZF_INCLUDE_DIR lzf.h PATH_SUFFIXES liblzf REQUIRED)
find_library(LZF_LIBRARY lzf REQUIRED)
if(SCANMILL_STUDIO OR SCANMILL_TESTS OR SCANMILL_BENCHMARKS)
  pkg_check_modules(PCL REQUIRED IMPORTED_TARGET pcl_io pcl_common pcl_registration)
endif()
pkg_check_modules(LZ4 REQUIRED IMPORTED_TARGET liblz4)
pkg_check_modules(RE2 REQUIRED IMPORTED_TARGET re2)  # Debian 12 has no CMake package of it
pkg_check_modules(OPENIMAGEIO REQUIRED IMPORTED_TARGET OpenImageIO)  # its CMake package wants its tools installed too
if(SCANMILL_PYTHON)
  # Debian's own, which has Debian's numpy; `pip install .` names its own.
  if(NOT Python_EXECUTABLE AND EXISTS /usr/bin/python3)
    set(Python_EXECUTABLE /usr/bin/python3)
  endif()
  find_package(Python COMPONENTS Interpreter Development.Module REQUIRED)
  find_package(pybind11 REQUIRED)
  set(CMAKE_POSITION_INDEPENDENT_CODE ON)  # of the libraries too, which the extension links
endif()
if(SCANMILL_STUDIO)
  find_package(glfw3 REQUIRED)
  find_package(Freetype REQUIRED)  # of Dear ImGui
  pkg_check_modules(IMGUI REQUIRED IMPORTED_TARGET imgui)
  find_package(cxxopts REQUIRED)
  find_path(MUSTACHE_INCLUDE_DIR kainjow/mustache.hpp)
  if(NOT MUSTACHE_INCLUDE_DIR)
    message(FATAL_ERROR "kainjow/mustache.hpp is missing: install Debian's package libkainjow-mustache-dev (scripts/setup does)")
  endif()
endif()
