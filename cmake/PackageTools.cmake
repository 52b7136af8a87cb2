# Read by cpack before it makes packages. Without these tools it would make some that depend on nothing.
if(CPACK_GENERATOR STREQUAL DEB)
  foreach(tool dpkg-shlibdeps file)
    find_program(CMPG_TOOL_${tool} ${tool})
    if(NOT CMPG_TOOL_${tool})
      message(FATAL_ERROR "${tool} is not installed, by which Debian packages find what they depend on: scripts/install --packages brings it")
    endif()
  endforeach()
endif()
