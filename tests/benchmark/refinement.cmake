kinetrace_benchmark(refinement_benchmark SOURCES refinement_benchmark.cpp LIBS kinetrace::refinement kinetrace::refinement_ceres)
target_include_directories(refinement_benchmark PRIVATE ${CMAKE_CURRENT_LIST_DIR}/../unit/refinement)

# Formulations of the refinement of objects beside each other: a program, run by hand.
if(TARGET kinetrace_batch)
  find_package(Ceres 2.1 REQUIRED)
  add_executable(formulations formulations.cpp)
  target_link_libraries(formulations PRIVATE kinetrace_options kinetrace_batch kinetrace::evaluation Ceres::ceres)
  target_include_directories(formulations PRIVATE $<TARGET_PROPERTY:kinetrace_refinement,SOURCE_DIR>/src)
endif()
