# The Python package as it is imported from the build: the extension, and links to the files of src/python/scanmill.

set(package_folder ${PROJECT_BINARY_DIR}/python/scanmill)
pybind11_add_module(scanmill_python MODULE NO_EXTRAS src/python/bindings.cpp src/python/jobs.cpp
                    src/python/pass_recorder.cpp src/python/simulator.cpp)
target_link_libraries(scanmill_python PRIVATE ${core_libraries} nlohmann_json::nlohmann_json)
target_include_directories(scanmill_python PRIVATE ${PROJECT_SOURCE_DIR}/src)
set_target_properties(scanmill_python PROPERTIES OUTPUT_NAME _core LIBRARY_OUTPUT_DIRECTORY ${package_folder}
                                                 BUILD_RPATH ${CMAKE_BUILD_RPATH} INSTALL_RPATH $ORIGIN/lib)
install(TARGETS scanmill_python LIBRARY DESTINATION ${python_folder}/scanmill COMPONENT python EXCLUDE_FROM_ALL)
install(DIRECTORY pipelines scenes labels DESTINATION ${python_folder}/scanmill/share COMPONENT python EXCLUDE_FROM_ALL)
file(GLOB package_files CONFIGURE_DEPENDS src/python/scanmill/*)
list(FILTER package_files EXCLUDE REGEX __pycache__)
install(FILES ${package_files} DESTINATION ${python_folder}/scanmill COMPONENT python EXCLUDE_FROM_ALL)
foreach(file ${package_files})
  get_filename_component(name ${file} NAME)
  file(MAKE_DIRECTORY ${package_folder})
  file(CREATE_LINK ${file} ${package_folder}/${name} SYMBOLIC)
endforeach()
