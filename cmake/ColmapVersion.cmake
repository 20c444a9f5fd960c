# Turns COLMAP's version ("3.10-dev", "4.1.1") into one integer, major * 10000 +
# minor * 100 + patch (31000, 40101), because its headers carry no version macro.
# Only colmap_plugin/colmap_compat.cc looks at it.
function(structnerf_colmap_version version out)
  if(NOT version MATCHES "^([0-9]+)\\.([0-9]+)(\\.([0-9]+))?")
    message(FATAL_ERROR "COLMAP's version \"${version}\" is not understood.")
  endif()
  set(patch 0)
  if(CMAKE_MATCH_4)
    set(patch ${CMAKE_MATCH_4})
  endif()
  math(EXPR number "${CMAKE_MATCH_1} * 10000 + ${CMAKE_MATCH_2} * 100 + ${patch}")
  if(number LESS 31000)
    message(FATAL_ERROR "COLMAP ${version} is too old; 3.10 or newer is needed.")
  endif()
  set(${out} ${number} PARENT_SCOPE)
endfunction()
