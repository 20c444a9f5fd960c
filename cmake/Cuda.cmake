# Kernels for NVIDIA graphics cards, where there is a compiler for them. They
# compile without a card and need the CUDA runtime only, which is linked
# statically.
include(CheckLanguage)
find_program(STRUCTNERF_NVCC nvcc
  HINTS ENV CUDA_HOME ENV CUDA_PATH PATH_SUFFIXES bin PATHS /usr/local/cuda)
if(STRUCTNERF_NVCC AND NOT DEFINED ENV{CUDACXX})
  set(ENV{CUDACXX} ${STRUCTNERF_NVCC})
endif()
if(NOT DEFINED STRUCTNERF_CUDA)
  set(structnerf_cuda_default OFF)
  check_language(CUDA)
  if(CMAKE_CUDA_COMPILER)
    # Earlier ones do not know all of the architectures below.
    execute_process(COMMAND ${CMAKE_CUDA_COMPILER} --version
      OUTPUT_VARIABLE structnerf_nvcc_version)
    if(structnerf_nvcc_version MATCHES "release ([0-9.]+)" AND
        CMAKE_MATCH_1 VERSION_GREATER_EQUAL 12)
      set(structnerf_cuda_default ON)
    else()
      message(STATUS "${CMAKE_CUDA_COMPILER} is older than 12 and not used.")
    endif()
  endif()
endif()
option(STRUCTNERF_CUDA "Build the engine for NVIDIA graphics cards"
  ${structnerf_cuda_default})
if(STRUCTNERF_NVCC AND NOT STRUCTNERF_CUDA)
  message(STATUS "Without CUDA; -DSTRUCTNERF_CUDA=ON uses ${STRUCTNERF_NVCC}.")
endif()
# Every architecture that CUDA 13 still knows, up to Hopper; later cards compile
# the last one's intermediate code when the program starts.
set(STRUCTNERF_CUDA_ARCHITECTURES 75-real 80-real 86-real 89-real 90
  CACHE STRING "Architectures of graphics cards")
if(STRUCTNERF_CUDA)
  set(CMAKE_CUDA_STANDARD 17)
  set(CMAKE_CUDA_STANDARD_REQUIRED ON)
  set(CMAKE_CUDA_RUNTIME_LIBRARY Static)
  enable_language(CUDA)
endif()
