find_package(OpenCV REQUIRED COMPONENTS core imgproc features2d video calib3d)
kinetrace_benchmark(features_benchmark
  SOURCES features_benchmark.cpp
  LIBS kinetrace::features opencv_core opencv_imgproc opencv_features2d opencv_video opencv_calib3d)
target_include_directories(features_benchmark PRIVATE ${PROJECT_SOURCE_DIR}/tests/unit/features)
