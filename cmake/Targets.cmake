# Helpers that give every target of the project the same warnings and flags.

function(structnerf_compile_options target)
  target_compile_options(${target} PRIVATE
    "$<$<COMPILE_LANGUAGE:CXX>:-Wall;-Wextra>"
    "$<$<COMPILE_LANGUAGE:CUDA>:-Xcompiler=-Wall,-Wextra>")
  if(STRUCTNERF_WERROR)
    target_compile_options(${target} PRIVATE
      "$<$<COMPILE_LANGUAGE:CXX>:-Werror>"
      "$<$<COMPILE_LANGUAGE:CUDA>:--Werror=all-warnings>")
  endif()
  target_include_directories(${target} PUBLIC ${PROJECT_SOURCE_DIR})
  if(STRUCTNERF_SANITIZE)
    target_compile_options(${target} PRIVATE
      "$<$<COMPILE_LANGUAGE:CXX>:-fsanitize=${STRUCTNERF_SANITIZE};-fno-omit-frame-pointer>")
    target_link_options(${target} PUBLIC -fsanitize=${STRUCTNERF_SANITIZE})
    # With sanitizers Eigen allocates in another way unless told not to. COLMAP
    # has none, and matrices are made there and freed here.
    target_compile_definitions(${target} PRIVATE EIGEN_MALLOC_ALREADY_ALIGNED=1)
  endif()
endfunction()

# structnerf_library(name SOURCES ... PUBLIC_LIBS ... PRIVATE_LIBS ...)
function(structnerf_library name)
  cmake_parse_arguments(arg "" "" "SOURCES;PUBLIC_LIBS;PRIVATE_LIBS" ${ARGN})
  add_library(${name} STATIC ${arg_SOURCES})
  target_link_libraries(${name} PUBLIC ${arg_PUBLIC_LIBS}
                                PRIVATE ${arg_PRIVATE_LIBS})
  structnerf_compile_options(${name})
endfunction()

# structnerf_test(x_test.cc libraries... [LAUNCHER command...] [CASES name...]): a
# GoogleTest program whose ctest name is its path below tests/ without the
# suffix. The launcher is a command that runs the program given behind it. With
# cases, each is a ctest of its own, which runs the tests whose names end in it.
function(structnerf_test source)
  cmake_parse_arguments(arg "" "" "LAUNCHER;CASES" ${ARGN})
  cmake_path(ABSOLUTE_PATH source BASE_DIRECTORY ${CMAKE_CURRENT_SOURCE_DIR})
  file(RELATIVE_PATH name ${PROJECT_SOURCE_DIR}/tests ${source})
  string(REGEX REPLACE "\\.cc$" "" name ${name})
  string(REPLACE "/" "_" target ${name})
  add_executable(${target} ${source})
  target_link_libraries(${target} PRIVATE ${arg_UNPARSED_ARGUMENTS} GTest::gtest_main GTest::gmock)
  structnerf_compile_options(${target})
  foreach(case ${arg_CASES})
    add_test(NAME ${name}/${case} COMMAND ${arg_LAUNCHER}
      $<TARGET_FILE:${target}> --gtest_filter=*${case})
  endforeach()
  if(NOT arg_CASES)
    add_test(NAME ${name} COMMAND ${arg_LAUNCHER} $<TARGET_FILE:${target}>)
  endif()
endfunction()
