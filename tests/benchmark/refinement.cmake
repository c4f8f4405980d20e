kinetrace_benchmark(refinement_benchmark SOURCES refinement_benchmark.cpp LIBS kinetrace::refinement kinetrace::refinement_ceres)
target_include_directories(refinement_benchmark PRIVATE ${CMAKE_CURRENT_LIST_DIR}/../unit/refinement)
