# Manual pages and completions, printed by the programs themselves.
set(reference ${PROJECT_BINARY_DIR}/reference)
file(MAKE_DIRECTORY ${reference})

# kinetrace_reference(PROGRAM COMPONENT ARGUMENTS...): PROGRAM ARGUMENTS man|bash prints them.
function(kinetrace_reference program component)
  add_custom_command(OUTPUT ${reference}/${program}.1.gz ${reference}/${program}
    COMMAND ${program} ${ARGN} man > ${reference}/${program}.1
    COMMAND gzip -9nf ${reference}/${program}.1
    COMMAND ${program} ${ARGN} bash > ${reference}/${program}
    DEPENDS ${program} VERBATIM COMMENT "Printing the manual page and the completion of ${program}")
  add_custom_target(${program}_reference ALL DEPENDS ${reference}/${program}.1.gz ${reference}/${program})
  install(FILES ${reference}/${program}.1.gz DESTINATION ${CMAKE_INSTALL_MANDIR}/man1 COMPONENT ${component})
  install(FILES ${reference}/${program} DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions COMPONENT ${component})
endfunction()
kinetrace_reference(kinetrace kinetrace reference)
if(TARGET kinetrace-simulate)
  kinetrace_reference(kinetrace-simulate kinetrace-simulator --reference)
endif()

# Build tools and dependencies of the delivered binaries, in the versions of this machine or the sysroot.
add_custom_command(OUTPUT ${PROJECT_BINARY_DIR}/kinetrace.spdx.json
  COMMAND ${PROJECT_SOURCE_DIR}/toolchains/sbom ${PROJECT_VERSION} ${kinetrace_sysroot_arch} > ${PROJECT_BINARY_DIR}/kinetrace.spdx.json
  DEPENDS ${PROJECT_SOURCE_DIR}/toolchains/sbom ${PROJECT_SOURCE_DIR}/toolchains/list ${PROJECT_SOURCE_DIR}/toolchains/packages-build.txt
    ${PROJECT_SOURCE_DIR}/toolchains/packages-run.txt ${PROJECT_SOURCE_DIR}/toolchains/packages-plugins.txt
    ${PROJECT_SOURCE_DIR}/config/models/kinetrace-sim.onnx
    $<$<BOOL:${CMAKE_CROSSCOMPILING}>:${PROJECT_SOURCE_DIR}/toolchains/sysroot-${kinetrace_sysroot_arch}.lock>
  VERBATIM COMMENT "Listing the packages that Kinetrace is made of")
add_custom_target(kinetrace_sbom ALL DEPENDS ${PROJECT_BINARY_DIR}/kinetrace.spdx.json)
install(FILES ${PROJECT_BINARY_DIR}/kinetrace.spdx.json DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/kinetrace COMPONENT kinetrace)
