# Manual pages and completions, printed by the programs themselves.
set(reference ${PROJECT_BINARY_DIR}/reference)
file(MAKE_DIRECTORY ${reference})
add_custom_command(OUTPUT ${reference}/kinetrace.1.gz ${reference}/kinetrace
  COMMAND kinetrace reference man > ${reference}/kinetrace.1
  COMMAND gzip -9nf ${reference}/kinetrace.1
  COMMAND kinetrace reference bash > ${reference}/kinetrace
  DEPENDS kinetrace VERBATIM COMMENT "Printing the manual page and the completion of kinetrace")
add_custom_target(kinetrace_reference ALL DEPENDS ${reference}/kinetrace.1.gz ${reference}/kinetrace)
install(FILES ${reference}/kinetrace.1.gz DESTINATION ${CMAKE_INSTALL_MANDIR}/man1 COMPONENT kinetrace)
install(FILES ${reference}/kinetrace DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions COMPONENT kinetrace)

# What the delivered binaries are made with and need, in this machine's versions, or the sysroot's.
add_custom_command(OUTPUT ${PROJECT_BINARY_DIR}/kinetrace.spdx.json
  COMMAND ${PROJECT_SOURCE_DIR}/toolchains/sbom ${PROJECT_VERSION} ${kinetrace_sysroot_arch} > ${PROJECT_BINARY_DIR}/kinetrace.spdx.json
  DEPENDS ${PROJECT_SOURCE_DIR}/toolchains/sbom ${PROJECT_SOURCE_DIR}/toolchains/packages-build.txt
    ${PROJECT_SOURCE_DIR}/toolchains/packages-run.txt $<$<BOOL:${CMAKE_CROSSCOMPILING}>:${PROJECT_SOURCE_DIR}/toolchains/sysroot-${kinetrace_sysroot_arch}.lock>
  VERBATIM COMMENT "Listing the packages that Kinetrace is made of")
add_custom_target(kinetrace_sbom ALL DEPENDS ${PROJECT_BINARY_DIR}/kinetrace.spdx.json)
install(FILES ${PROJECT_BINARY_DIR}/kinetrace.spdx.json DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/kinetrace COMPONENT kinetrace)
