# Installation of the programs and their files; each COMPONENT becomes a package, see packages.cmake.
include(toolchains/install_folders.cmake)
install(TARGETS kinetrace RUNTIME COMPONENT kinetrace)
install(DIRECTORY config/ DESTINATION ${CMAKE_INSTALL_DATADIR}/kinetrace COMPONENT kinetrace FILES_MATCHING PATTERN *.yaml
  PATTERN models EXCLUDE)
install(FILES config/kinetrace.service DESTINATION lib/systemd/system COMPONENT kinetrace)
if(TARGET kinetrace_libcamera_plugin)
  # The program searches for its plugin there; both have the same architecture.
  install(TARGETS kinetrace_libcamera_plugin LIBRARY DESTINATION lib/kinetrace COMPONENT kinetrace-libcamera)
endif()
if(TARGET kinetrace_opencv_dnn)
  install(TARGETS kinetrace_opencv_dnn LIBRARY DESTINATION lib/kinetrace COMPONENT kinetrace-networks)
  install(DIRECTORY config/models/ DESTINATION ${CMAKE_INSTALL_DATADIR}/kinetrace/models COMPONENT kinetrace-networks
    FILES_MATCHING PATTERN *.yaml PATTERN *.onnx)
endif()
if(TARGET kinetrace-calibrate)
  # In the folder of the program that starts it.
  install(TARGETS kinetrace-calibrate RUNTIME COMPONENT kinetrace-calibration)
endif()
if(TARGET kinetrace-map)
  install(TARGETS kinetrace-map RUNTIME COMPONENT kinetrace-map)
endif()
if(TARGET kinetrace-refine)
  install(TARGETS kinetrace-refine RUNTIME COMPONENT kinetrace-refinement)
endif()
if(TARGET kinetrace-simulate)
  install(TARGETS kinetrace-simulate RUNTIME COMPONENT kinetrace-simulator)
endif()
