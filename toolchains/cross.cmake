# Common to cross building for all architectures: compilers by name, libraries from the sysroot of
# toolchains/make-sysroot, tools (also idlc) from this machine, tests under qemu's user mode.

set(CMAKE_SYSTEM_NAME Linux)
set(CMAKE_C_COMPILER ${triplet}-gcc)
set(CMAKE_CXX_COMPILER ${triplet}-g++)
# The compiler check sets this later, after the search for packages.
set(CMAKE_LIBRARY_ARCHITECTURE ${triplet})

if(DEFINED ENV{KINETRACE_SYSROOT})
  set(CMAKE_SYSROOT $ENV{KINETRACE_SYSROOT})
else()
  set(CMAKE_SYSROOT ${CMAKE_CURRENT_LIST_DIR}/../build/sysroot-${kinetrace_sysroot_arch})
endif()
get_filename_component(CMAKE_SYSROOT ${CMAKE_SYSROOT} ABSOLUTE)
if(NOT EXISTS ${CMAKE_SYSROOT}/usr/lib/${triplet})
  message(FATAL_ERROR "There is no sysroot in ${CMAKE_SYSROOT}; run toolchains/make-sysroot ${kinetrace_sysroot_arch}")
endif()
set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)
set(CMAKE_FIND_ROOT_PATH_MODE_LIBRARY ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_INCLUDE ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_PACKAGE ONLY)
set(ENV{PKG_CONFIG_SYSROOT_DIR} ${CMAKE_SYSROOT})
set(ENV{PKG_CONFIG_LIBDIR} ${CMAKE_SYSROOT}/usr/lib/${triplet}/pkgconfig:${CMAKE_SYSROOT}/usr/share/pkgconfig)
set(CMAKE_CROSSCOMPILING_EMULATOR ${kinetrace_emulator} -L ${CMAKE_SYSROOT})
