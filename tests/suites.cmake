# Read by ctest: adds one test for each suite of a test program, so that what a suite makes once serves all of its tests.

# ctest starts these first, so that none of them is left to run alone at the end.
set(longest_suites town.Town commands.Each/Examples commands.InputLimits commands.Overrides methods.ParticlesOnADevice
    evaluate.Street assets.Blend)

# scanmill_add_suites(LIBRARY PROGRAM LABELS)
function(scanmill_add_suites library program labels)
  if(NOT EXISTS ${program})
    add_test(${library}.NOT_BUILT ${program})
    return()
  endif()
  execute_process(COMMAND ${program} --gtest_list_tests OUTPUT_VARIABLE listed RESULT_VARIABLE failed)
  if(failed)
    message(FATAL_ERROR "${program} does not list its tests: ${failed}")
  endif()
  string(REGEX MATCHALL "(^|\n)[^ \n]+[.]( +#[^\n]*)?\n  [^\n]" suites "${listed}")
  foreach(suite ${suites})
    string(REGEX MATCH "[^ \n]+[.]" suite "${suite}")
    string(REGEX REPLACE "[.]$" "" name ${suite})
    add_test(${library}.${name} ${program} --gtest_filter=${suite}* --gtest_brief=1)
    set_tests_properties(${library}.${name} PROPERTIES TIMEOUT 600 LABELS "${labels}")
    list(FIND longest_suites ${library}.${name} longest)
    if(NOT longest EQUAL -1)
      set_tests_properties(${library}.${name} PROPERTIES COST 100)
    endif()
  endforeach()
endfunction()
