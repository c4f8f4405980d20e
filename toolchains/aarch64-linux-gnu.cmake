# 64-bit ARM: Debian's arm64.
set(triplet aarch64-linux-gnu)
set(CMAKE_SYSTEM_PROCESSOR aarch64)
set(kinetrace_sysroot_arch arm64)
set(kinetrace_emulator qemu-aarch64-static)
include(${CMAKE_CURRENT_LIST_DIR}/cross.cmake)
