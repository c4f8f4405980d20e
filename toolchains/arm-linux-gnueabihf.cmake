# 32-bit ARM with NEON (ARMv7-A): Debian's armhf.
set(triplet arm-linux-gnueabihf)
set(CMAKE_SYSTEM_PROCESSOR armv7l)
set(kinetrace_sysroot_arch armhf)
set(kinetrace_emulator qemu-arm-static)
set(CMAKE_C_FLAGS_INIT "-mfpu=neon-vfpv4")
set(CMAKE_CXX_FLAGS_INIT "-mfpu=neon-vfpv4")
include(${CMAKE_CURRENT_LIST_DIR}/cross.cmake)
