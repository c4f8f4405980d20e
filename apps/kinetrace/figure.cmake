# The pictures of a run, apart from the program so that their tests build quickly.
add_library(kinetrace_figure STATIC
  figure_choice.cpp figure_cloud_panels.cpp figure_film.cpp figure_image_panels.cpp figure_images.cpp figure_overlay.cpp figure_page.cpp
  figure_plan.cpp figure_points.cpp figure_run.cpp figure_scene.cpp figure_trajectory_panels.cpp figure_views.cpp)
target_include_directories(kinetrace_figure PUBLIC ${CMAKE_CURRENT_SOURCE_DIR})
target_link_libraries(kinetrace_figure
  PUBLIC kinetrace_drawing kinetrace::hal kinetrace::recording
  PRIVATE kinetrace_options nlohmann_json::nlohmann_json)
