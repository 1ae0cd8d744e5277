# Installs into a new folder, moves it, builds a program of somebody else against it, and runs both programs there.
#   cmake -DBUILD=... -DSOURCE=... -DWORK=... -P install_test.cmake

function(run)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE output)
  message("${output}")
  if(NOT result EQUAL 0)
    message(FATAL_ERROR "failed (${result}): ${ARGN}")
  endif()
endfunction()

file(REMOVE_RECURSE ${WORK})
run(${CMAKE_COMMAND} --install ${BUILD} --prefix ${WORK}/first)
file(RENAME ${WORK}/first ${WORK}/prefix)
run(${CMAKE_COMMAND} -S ${SOURCE}/consumer -B ${WORK}/build -G Ninja -DCMAKE_BUILD_TYPE=Release
    -DCMAKE_PREFIX_PATH=${WORK}/prefix)
run(${CMAKE_COMMAND} --build ${WORK}/build)
set(pipeline ${WORK}/prefix/share/scanmill/pipelines/quickstart.yaml)
run(${WORK}/build/consumer ${pipeline} ${WORK}/dataset)
run(${WORK}/prefix/bin/scanmill verify ${WORK}/dataset)
run(${WORK}/prefix/bin/scanmill picture ${WORK}/dataset -o ${WORK}/picture.png)
run(${WORK}/prefix/bin/scanmill list scenes)
file(REMOVE_RECURSE ${WORK})
