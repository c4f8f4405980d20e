# What a study measures and shows, apart from the program so that its tests need no pipeline.
add_library(kinetrace_study STATIC
  gray16_images.cpp mots_images.cpp study_errors.cpp study_plot.cpp study_summary.cpp study_truth.cpp)
target_include_directories(kinetrace_study PUBLIC ${CMAKE_CURRENT_SOURCE_DIR})
target_link_libraries(kinetrace_study
  PUBLIC kinetrace::evaluation kinetrace::imaging PRIVATE kinetrace_options kinetrace_drawing)
