# Installs the library to a folder of its own, and builds and runs a program against it, outside the build.
#   cmake -DBUILD=... -DSOURCE=... -DCOMPILER=... -P run_consumer.cmake
string(RANDOM LENGTH 12 name)
set(folder /tmp/cmpg-consumer-${name})
function(run)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE output)
  message("${output}")
  if(NOT result EQUAL 0)
    file(REMOVE_RECURSE ${folder})
    message(FATAL_ERROR "'${ARGN}' ended with ${result}")
  endif()
endfunction()
run(${CMAKE_COMMAND} --install ${BUILD} --prefix ${folder}/prefix --component library)
file(COPY ${SOURCE}/tests/library/consumer DESTINATION ${folder})
run(${CMAKE_COMMAND} -S ${folder}/consumer -B ${folder}/build -DCMAKE_PREFIX_PATH=${folder}/prefix -DCMAKE_CXX_COMPILER=${COMPILER}
  -DCMAKE_BUILD_TYPE=Release "-DCMAKE_CXX_FLAGS=-Wall -Wextra -Wpedantic -Werror")
run(${CMAKE_COMMAND} --build ${folder}/build)
run(${folder}/build/recover_painting ${SOURCE}/scenes/box/scene.gltf ${SOURCE}/scenes/box/target.exr 6)
file(REMOVE_RECURSE ${folder})
