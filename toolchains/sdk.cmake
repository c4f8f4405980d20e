# The SDK: shared libraries made of the modules, their headers, a CMake package and pkg-config files. Four libraries, to install only those
# in use; all need the first:
#   libkinetrace             core, imaging, processing, pipeline, recording: image codecs are all it needs
#   libkinetrace-hal         recordings and cameras: OpenCV (calib3d, imgproc, core), yaml-cpp
#   libkinetrace-neural      neural networks, by the plugin kinetrace-opencv-dnn.so; OpenCV's dnn is needed by that alone
#   libkinetrace-publishing  DDS
# The programs link the same modules statically and need none of these libraries.
include(CMakePackageConfigHelpers)
include(toolchains/install_folders.cmake)
file(RELATIVE_PATH kinetrace_prefix_from_pc /${CMAKE_INSTALL_LIBDIR}/pkgconfig /)
set(kinetrace_package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/Kinetrace)

configure_file(toolchains/sdk/exports.map ${PROJECT_BINARY_DIR}/exports.map @ONLY)

# kinetrace_shared_library(NAME COMPONENT DESCRIPTION MODULES modules... [NEEDS library of ours]): libNAME of these modules, exported
# as kinetrace::COMPONENT.
function(kinetrace_shared_library name component description)
  cmake_parse_arguments(ARG "" "NEEDS" "MODULES" ${ARGN})
  set(target shared_${component})
  list(TRANSFORM ARG_MODULES PREPEND kinetrace_ OUTPUT_VARIABLE modules)
  list(TRANSFORM modules REPLACE "(.+)" "$<TARGET_OBJECTS:\\1>" OUTPUT_VARIABLE objects)
  add_library(${target} SHARED ${objects})
  set_target_properties(${target} PROPERTIES OUTPUT_NAME ${name} EXPORT_NAME ${component} LINKER_LANGUAGE CXX
    VERSION ${PROJECT_VERSION} SOVERSION ${PROJECT_VERSION_MAJOR} LIBRARY_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/lib)
  target_include_directories(${target} INTERFACE $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
  target_compile_features(${target} INTERFACE cxx_std_20)
  target_link_options(${target} PRIVATE -Wl,--no-undefined -Wl,--version-script=${PROJECT_BINARY_DIR}/exports.map)
  set_target_properties(${target} PROPERTIES LINK_DEPENDS ${PROJECT_BINARY_DIR}/exports.map)
  target_link_libraries(${target} PUBLIC Eigen3::Eigen)
  set(required eigen3)
  if(ARG_NEEDS)
    # First, so that its symbols are not taken from archives again.
    target_link_libraries(${target} PUBLIC shared_${ARG_NEEDS})
    get_target_property(required shared_${ARG_NEEDS} OUTPUT_NAME)
  endif()
  # The archives provide the external dependencies of the objects.
  target_link_libraries(${target} PRIVATE ${modules})

  string(REPLACE "kinetrace" "libkinetrace" package ${name})
  install(TARGETS ${target} EXPORT ${target}
    LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT ${package}${PROJECT_VERSION_MAJOR} NAMELINK_COMPONENT libkinetrace-dev)
  install(EXPORT ${target} NAMESPACE kinetrace:: FILE Kinetrace-${component}.cmake
    DESTINATION ${kinetrace_package_dir} COMPONENT libkinetrace-dev)
  configure_file(toolchains/sdk/library.pc.in ${PROJECT_BINARY_DIR}/${name}.pc @ONLY)
  install(FILES ${PROJECT_BINARY_DIR}/${name}.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig COMPONENT libkinetrace-dev)
endfunction()

# kinetrace_install_headers(FOLDER PATTERN...): public headers below FOLDER.
function(kinetrace_install_headers folder)
  list(TRANSFORM ARGN PREPEND "PATTERN;" OUTPUT_VARIABLE patterns)
  install(DIRECTORY ${folder}/include/ DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} COMPONENT libkinetrace-dev FILES_MATCHING ${patterns})
endfunction()

kinetrace_shared_library(kinetrace pipeline "Stereo images in, metric 3-D trajectories of everything that moves out"
  MODULES core imaging rig features segmentation tracking sfm refinement trajectory objects pipeline recording)
kinetrace_shared_library(kinetrace-hal hal "Stereo recordings and cameras for Kinetrace" MODULES hal NEEDS pipeline)
kinetrace_shared_library(kinetrace-neural neural "Neural networks that find objects for Kinetrace" MODULES neural NEEDS pipeline)
foreach(module core imaging pipeline recording neural)
  kinetrace_install_headers(modules/${module} *.hpp)
endforeach()
kinetrace_install_headers(hal *.hpp)
# Of the processing modules only the settings, which are part of the pipeline's settings.
foreach(module rig features segmentation tracking sfm refinement trajectory)
  kinetrace_install_headers(modules/${module} *config.hpp fixed_bundle_adjuster.hpp size_table.hpp)
endforeach()
if(TARGET kinetrace_publishing)
  kinetrace_shared_library(kinetrace-publishing publishing "Kinetrace's results over DDS" MODULES publishing NEEDS pipeline)
  kinetrace_install_headers(modules/publishing *.hpp)
endif()

configure_package_config_file(toolchains/sdk/KinetraceConfig.cmake.in ${PROJECT_BINARY_DIR}/KinetraceConfig.cmake
  INSTALL_DESTINATION ${kinetrace_package_dir} NO_SET_AND_CHECK_MACRO)
write_basic_package_version_file(${PROJECT_BINARY_DIR}/KinetraceConfigVersion.cmake COMPATIBILITY SameMajorVersion)
install(FILES ${PROJECT_BINARY_DIR}/KinetraceConfig.cmake ${PROJECT_BINARY_DIR}/KinetraceConfigVersion.cmake
  DESTINATION ${kinetrace_package_dir} COMPONENT libkinetrace-dev)
