if(TARGET kinetrace_publishing)
  kinetrace_benchmark(publishing_benchmark
    SOURCES publishing_benchmark.cpp ${PROJECT_SOURCE_DIR}/tests/support/sample_results.cpp
    LIBS kinetrace::publishing kinetrace_allocation_interposer)
endif()
