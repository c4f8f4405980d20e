find_package(OpenCV REQUIRED COMPONENTS core imgproc)
kinetrace_benchmark(hal_benchmark SOURCES hal_benchmark.cpp LIBS kinetrace::hal opencv_core opencv_imgproc)
