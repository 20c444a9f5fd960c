# Finds what the project builds on. COLMAP comes first: before 3.11 its
# configuration replaces CMAKE_MODULE_PATH and switches CMAKE_AUTORCC on.
if(STRUCTNERF_COLMAP)
  set(structnerf_module_path "${CMAKE_MODULE_PATH}")
  find_package(COLMAP QUIET)
  if(NOT COLMAP_FOUND)
    message(FATAL_ERROR
      "No COLMAP with development files was found. Either install COLMAP (3.10 "
      "to 4.1) and pass -DCMAKE_PREFIX_PATH=<its prefix>, or let "
      "cmake/build_colmap.sh build one and pass the path it prints.")
  endif()
  set(CMAKE_MODULE_PATH "${structnerf_module_path}")
  set(CMAKE_AUTORCC OFF)
  message(STATUS "COLMAP ${COLMAP_VERSION}: ${COLMAP_DIR}")
  find_package(OpenCV REQUIRED COMPONENTS core flann imgcodecs imgproc quality ximgproc)
  find_package(nlohmann_json REQUIRED)
endif()

find_package(Eigen3 REQUIRED NO_MODULE)
find_package(Threads REQUIRED)
find_package(HWY REQUIRED)
find_package(Torch REQUIRED)
if(STRUCTNERF_TESTS)
  find_package(benchmark REQUIRED)
  find_package(GTest REQUIRED)
endif()
