find_package(OpenCV REQUIRED COMPONENTS core calib3d)
kinetrace_benchmark(sfm_benchmark
  SOURCES sfm_benchmark.cpp
  LIBS kinetrace::sfm kinetrace::refinement opencv_core opencv_calib3d)
target_include_directories(sfm_benchmark PRIVATE ${PROJECT_SOURCE_DIR}/tests/unit/sfm)
