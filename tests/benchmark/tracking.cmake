kinetrace_benchmark(tracking_benchmark SOURCES tracking_benchmark.cpp LIBS kinetrace::tracking kinetrace::segmentation)
