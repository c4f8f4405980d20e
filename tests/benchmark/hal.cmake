find_package(OpenCV REQUIRED COMPONENTS core imgproc)
kinetrace_benchmark(hal_benchmark
  SOURCES hal_benchmark.cpp ${PROJECT_SOURCE_DIR}/tests/unit/hal/fake_capture.cpp
  LIBS kinetrace::hal kinetrace_allocation_interposer opencv_core opencv_imgproc)
target_include_directories(hal_benchmark PRIVATE ${PROJECT_SOURCE_DIR}/hal/src ${PROJECT_SOURCE_DIR}/tests/unit/hal)
