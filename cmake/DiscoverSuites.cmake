# Writes tests for ctest of a program of GoogleTest's: one for each of its suites, one for each case whose name contains "Full" or that is listed below.
#   cmake -DPROGRAM= -DNAME= -DLABEL= -DENVIRONMENT= -DOUTPUT= -P DiscoverSuites.cmake
# The cases of a suite run in one process, which starts one device and compiles each kernel once.
execute_process(COMMAND ${PROGRAM} --gtest_list_tests OUTPUT_VARIABLE lines RESULT_VARIABLE failed)
if(failed)
  message(FATAL_ERROR "${PROGRAM} does not list its tests: ${failed}")
endif()
string(REGEX REPLACE "  #[^\n]*" "" lines "${lines}") # the values of parameters
string(REGEX REPLACE "[\n]+" ";" lines "${lines}")
set(text "")
set(suite "")
set(quick FALSE)
set(others "")
# Seconds of the longest, of a whole run on two cores. ctest without a run before begins with them, so that none of them is alone at the end.
set(seconds References/Mitsuba 221 Metamorphic 135 Features 133 Slots/Boundary 111 Resume 84 Independence 62 ProgramBudget 48 Slots/SlotDerivative 39
  Scenes/GuidedExpectation 38)
# Cases that are long tests, too: what they say a quick one has said already.
set(long
  Features.SameBitsFurnace Features.SameBitsBowl         # lobes and textures off: SameBitsBox, SameBitsMaterials, which has all of them
  Features.SameBitsEnvironment                           # a sky is in SameBitsMaterials, derivatives of emission in SameBitsBoxLight
  Features.SameBitsWithoutLightSampling                  # SameBitsBox; what is equal without light sampling: Metamorphic.RandomScenes
  CompareProgram.OptimisesFromSeveralViews               # ComparesOptimisations; several views: mpi.*.same, python.recovery
  CompareProgram.EqualTimeAndRepeats                     # CompareRunner.EqualTimeIsEqualToAPass; run.json: ProgramRender.RunJsonReproducesTheRun
)
# The end of what a process prints none of whose cases passed or failed.
set(all_skipped "PASSED  \\] 0 tests\\.\n(\\[  SKIPPED \\] [^\n]*\n)+$")
# And of one that was asked for cases that it does not have.
set(none "0 tests from 0 test suites ran")
if(LABEL)
  set(LABEL ";${LABEL}")
endif()
function(add_entry name filter label timeout cost)
  string(APPEND text "add_test([==[${name}]==] [==[${PROGRAM}]==] [==[--gtest_filter=${filter}]==])\n"
    "set_tests_properties([==[${name}]==] PROPERTIES LABELS \"${label}\" TIMEOUT ${timeout} SKIP_REGULAR_EXPRESSION [==[${all_skipped}]==]"
    " FAIL_REGULAR_EXPRESSION [==[${none}]==]"
    " COST ${cost} ENVIRONMENT \"${ENVIRONMENT}\")\n")
  set(text "${text}" PARENT_SCOPE)
endfunction()
macro(end_suite)
  if(quick)
    string(JOIN ":" without "*Full*" ${others})
    set(cost 0)
    list(FIND seconds ${suite} place)
    if(place GREATER_EQUAL 0)
      math(EXPR place "${place} + 1")
      list(GET seconds ${place} cost)
    endif()
    add_entry(${NAME}.${suite} "${suite}.*-${without}" "quick${LABEL}" 1800 ${cost})
  endif()
  set(quick FALSE)
  set(others "")
endmacro()
foreach(line IN LISTS lines)
  if(line MATCHES "^([A-Za-z0-9_/]+)\\.")
    end_suite()
    set(suite ${CMAKE_MATCH_1})
  elseif(line MATCHES "^  ([A-Za-z0-9_/]+)")
    set(case ${suite}.${CMAKE_MATCH_1})
    list(FIND long ${case} place)
    if(place GREATER_EQUAL 0)
      list(APPEND others ${case})
    endif()
    if(case MATCHES "Full" OR place GREATER_EQUAL 0)
      add_entry(${NAME}.${case} ${case} "full${LABEL}" 7200 0)
    else()
      set(quick TRUE)
    endif()
  endif()
endforeach()
end_suite()
file(WRITE ${OUTPUT} "${text}")
