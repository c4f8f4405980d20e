# Debian packages, one for each component of the installation: `cmake --build build/release --target kinetrace_packages`.
# Dependencies on libraries are found by dpkg-shlibdeps in the binaries.
set(libraries libkinetrace${PROJECT_VERSION_MAJOR} libkinetrace-hal${PROJECT_VERSION_MAJOR}
  libkinetrace-neural${PROJECT_VERSION_MAJOR})
set(programs kinetrace)
if(TARGET shared_publishing)
  list(APPEND libraries libkinetrace-publishing${PROJECT_VERSION_MAJOR})
endif()
if(TARGET kinetrace_libcamera_plugin)
  list(APPEND programs kinetrace-libcamera)
endif()
if(TARGET kinetrace_opencv_dnn)
  list(APPEND programs kinetrace-networks)
endif()
if(TARGET kinetrace-calibrate)
  list(APPEND programs kinetrace-calibration)
endif()
if(TARGET kinetrace-map)
  list(APPEND programs kinetrace-map)
endif()
if(TARGET kinetrace-refine)
  list(APPEND programs kinetrace-refinement)
endif()
if(TARGET kinetrace-simulate)
  list(APPEND programs kinetrace-simulator)
endif()

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_DIRECTORY ${PROJECT_BINARY_DIR}/packages)
set(CPACK_PACKAGE_VENDOR "The Kinetrace authors")
set(CPACK_PACKAGE_CONTACT "The Kinetrace authors <kinetrace@localhost.invalid>")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_COMPONENTS_GROUPING IGNORE)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_RELEASE 1)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS_PRIVATE_DIRS ${PROJECT_BINARY_DIR}/lib)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(CPACK_COMPONENTS_ALL ${libraries} libkinetrace-dev ${programs})

# For another architecture dpkg-shlibdeps uses the symbols that make-sysroot has noted. CPack starts the program of this name, without our
# arguments; hence a wrapper.
set(package_tools ${PROJECT_BINARY_DIR}/packaging/tools)
if(CMAKE_CROSSCOMPILING)
  set(CPACK_DEBIAN_PACKAGE_ARCHITECTURE ${kinetrace_sysroot_arch})
  find_program(KINETRACE_SHLIBDEPS dpkg-shlibdeps)
  file(WRITE ${package_tools}/dpkg-shlibdeps
    "#!/bin/sh\nDEB_HOST_ARCH=${kinetrace_sysroot_arch} exec ${KINETRACE_SHLIBDEPS} -S${CMAKE_SYSROOT} \"$@\"\n")
  file(CHMOD ${package_tools}/dpkg-shlibdeps PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE)
endif()

# Named by the packages' changelogs.
cmake_host_system_information(RESULT KINETRACE_RELEASE QUERY DISTRIB_VERSION_CODENAME)

# kinetrace_package(COMPONENT SECTION SUMMARY DETAILS [packages of ours that it needs in the same version...])
macro(kinetrace_package component section summary details)
  string(TOUPPER ${component} key)
  set(CPACK_DEBIAN_${key}_PACKAGE_NAME ${component})
  set(CPACK_DEBIAN_${key}_PACKAGE_SECTION ${section})
  set(CPACK_DEBIAN_${key}_DESCRIPTION "${summary}\n${details}")
  set(needed ${ARGN})
  list(TRANSFORM needed APPEND " (= ${PROJECT_VERSION}-${CPACK_DEBIAN_PACKAGE_RELEASE})")
  list(JOIN needed ", " CPACK_DEBIAN_${key}_PACKAGE_DEPENDS)
  configure_file(toolchains/packages/copyright.in ${PROJECT_BINARY_DIR}/packaging/${component}/copyright @ONLY)
  configure_file(toolchains/packages/changelog.in ${PROJECT_BINARY_DIR}/packaging/${component}/changelog @ONLY)
  install(CODE "execute_process(COMMAND gzip -9nf --keep ${PROJECT_BINARY_DIR}/packaging/${component}/changelog)
    file(RENAME ${PROJECT_BINARY_DIR}/packaging/${component}/changelog.gz ${PROJECT_BINARY_DIR}/packaging/${component}/changelog.Debian.gz)"
    COMPONENT ${component})
  install(FILES ${PROJECT_BINARY_DIR}/packaging/${component}/copyright ${PROJECT_BINARY_DIR}/packaging/${component}/changelog.Debian.gz
    DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/${component} COMPONENT ${component})
endmacro()

# kinetrace_library_package(NAME SUMMARY DETAILS [packages...]): the same for libNAME, with Debian's metadata of libraries.
macro(kinetrace_library_package name summary details)
  set(package lib${name}${PROJECT_VERSION_MAJOR})
  kinetrace_package(${package} libs "${summary}" "${details}" ${ARGN})
  set(control ${PROJECT_BINARY_DIR}/packaging/${package})
  file(WRITE ${control}/shlibs
    "lib${name} ${PROJECT_VERSION_MAJOR} ${package} (>= ${PROJECT_VERSION}-${CPACK_DEBIAN_PACKAGE_RELEASE})\n")
  file(WRITE ${control}/triggers "activate-noawait ldconfig\n")
  set(CPACK_DEBIAN_${key}_PACKAGE_CONTROL_EXTRA ${control}/shlibs ${control}/triggers)
endmacro()

set(what "Kinetrace follows the camera and everything that moves in front of it,\nin metres, on the CPU of a small board and in memory that is taken once.")
kinetrace_library_package(kinetrace "3-D trajectories from stereo images: library"
  "${what}\nThis is the library that computes, for programs that embed it.")
kinetrace_library_package(kinetrace-hal "3-D trajectories from stereo images: cameras and recordings"
  "${what}\nThis library reads recordings, calibrations and V4L2 cameras." libkinetrace${PROJECT_VERSION_MAJOR})
kinetrace_library_package(kinetrace-neural "3-D trajectories from stereo images: neural networks, library"
  "${what}\nThis library finds objects in images by neural networks, which the plugin\nin kinetrace-networks computes." libkinetrace${PROJECT_VERSION_MAJOR})
set(CPACK_DEBIAN_LIBKINETRACE-NEURAL${PROJECT_VERSION_MAJOR}_PACKAGE_SUGGESTS kinetrace-networks)
kinetrace_library_package(kinetrace-publishing "3-D trajectories from stereo images: results over DDS"
  "${what}\nThis library publishes results as DDS topics, also for ROS 2." libkinetrace${PROJECT_VERSION_MAJOR})
kinetrace_package(libkinetrace-dev libdevel "3-D trajectories from stereo images: development files"
  "${what}\nThese are headers, the CMake package and pkg-config files." ${libraries})
# Dependencies of the headers.
file(STRINGS toolchains/packages-build.txt eigen REGEX eigen)
string(APPEND CPACK_DEBIAN_LIBKINETRACE-DEV_PACKAGE_DEPENDS ", ${eigen}")
kinetrace_package(kinetrace video "3-D trajectories from stereo images: programs"
  "${what}\nThis is the command line program, with a systemd unit and\nexamples of configurations.")
set(CPACK_DEBIAN_KINETRACE_PACKAGE_SUGGESTS "kinetrace-calibration, kinetrace-libcamera, kinetrace-map, kinetrace-networks, kinetrace-refinement, kinetrace-simulator")
kinetrace_package(kinetrace-libcamera video "3-D trajectories from stereo images: cameras through libcamera"
  "${what}\nThis plugin opens cameras through libcamera, in the release that it was\nbuilt for." kinetrace)
kinetrace_package(kinetrace-networks video "3-D trajectories from stereo images: neural networks"
  "${what}\nThis plugin computes neural networks for instance segmentation by OpenCV,\nwith one that knows simulated pictures." kinetrace)
kinetrace_package(kinetrace-calibration video "3-D trajectories from stereo images: calibration"
  "${what}\nThis program calibrates stereo rigs from images of a target." kinetrace)
kinetrace_package(kinetrace-map video "3-D trajectories from stereo images: maps"
  "${what}\nThis program aligns them with a GNSS receiver's log and writes them for maps." kinetrace)
kinetrace_package(kinetrace-refinement video "3-D trajectories from stereo images: batch refinement"
  "${what}\nThis program refines whole recordings after a run." kinetrace)
kinetrace_package(kinetrace-simulator video "3-D trajectories from stereo images: simulator"
  "${what}\nThis program renders stereo recordings with exact truth.")
include(CPack)

# Does not build the tests, which are part of `all`.
add_custom_target(kinetrace_packages
  COMMAND ${CMAKE_COMMAND} -E rm -rf ${CPACK_PACKAGE_DIRECTORY}
  COMMAND ${CMAKE_COMMAND} -E env CMAKE_PROGRAM_PATH=${package_tools} ${CMAKE_CPACK_COMMAND} --config ${PROJECT_BINARY_DIR}/CPackConfig.cmake
  DEPENDS kinetrace kinetrace_reference kinetrace_sbom shared_pipeline shared_hal shared_neural $<TARGET_NAME_IF_EXISTS:shared_publishing>
    $<TARGET_NAME_IF_EXISTS:kinetrace_libcamera_plugin> $<TARGET_NAME_IF_EXISTS:kinetrace_opencv_dnn> $<TARGET_NAME_IF_EXISTS:kinetrace-calibrate>
    $<TARGET_NAME_IF_EXISTS:kinetrace-map> $<TARGET_NAME_IF_EXISTS:kinetrace-refine>
    $<TARGET_NAME_IF_EXISTS:kinetrace-simulate_reference>
  VERBATIM USES_TERMINAL COMMENT "Making packages")
