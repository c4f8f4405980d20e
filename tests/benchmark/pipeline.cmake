if(TARGET kinetrace_rendered_drive)
  kinetrace_benchmark(pipeline_benchmark SOURCES pipeline_benchmark.cpp LIBS kinetrace_rendered_drive)
endif()
