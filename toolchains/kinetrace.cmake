# Common settings of all targets: language level, warnings, hot kernels, and one function per kind of target.
set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_POSITION_INDEPENDENT_CODE ON)
# Exported symbols of shared libraries are marked KINETRACE_API, see modules/core/include/kinetrace/core/export.hpp.
set(CMAKE_C_VISIBILITY_PRESET hidden)
set(CMAKE_CXX_VISIBILITY_PRESET hidden)
set(CMAKE_VISIBILITY_INLINES_HIDDEN ON)
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)
# Removes unused functions and libraries, which would take space on boards.
add_compile_options(-ffunction-sections -fdata-sections)
add_link_options(-Wl,--gc-sections -Wl,--as-needed)
# Files of recordings may exceed 2 GiB, also on 32-bit boards.
if(CMAKE_SIZEOF_VOID_P EQUAL 4)
  add_compile_definitions(_FILE_OFFSET_BITS=64)
endif()
if(NOT CMAKE_BUILD_TYPE)
  set(CMAKE_BUILD_TYPE Release)
endif()

# Optional.
# Looked for once: installed later, it would have everything built again.
if(NOT DEFINED KINETRACE_CCACHE)
  find_program(KINETRACE_CCACHE ccache)
  if(NOT KINETRACE_CCACHE)
    set(KINETRACE_CCACHE "" CACHE FILEPATH "Compiler cache; empty: none" FORCE)
  endif()
endif()
if(KINETRACE_CCACHE)
  # Precompiled headers have time stamps, and GCC does not report what it reads from them; without this setting ccache would never hit.
  set(CMAKE_CXX_COMPILER_LAUNCHER ${CMAKE_COMMAND} -E env CCACHE_SLOPPINESS=pch_defines,time_macros ${KINETRACE_CCACHE})
  add_compile_options($<$<CXX_COMPILER_ID:GNU>:-fpch-preprocess> "$<$<COMPILE_LANG_AND_ID:CXX,Clang>:SHELL:-Xclang -fno-pch-timestamp>")
endif()

find_package(Eigen3 3.4 REQUIRED NO_MODULE)

# Warnings are for our targets; dependencies are SYSTEM. A user's compiler may be newer than all tested ones, and warn of more.
option(KINETRACE_WARNINGS_AS_ERRORS "Stop at warnings: for those who change the sources" OFF)
add_library(kinetrace_options INTERFACE)
target_compile_options(kinetrace_options INTERFACE
  -Wall -Wextra -Wconversion -Wshadow -Wnon-virtual-dtor -Woverloaded-virtual
  $<$<BOOL:${KINETRACE_WARNINGS_AS_ERRORS}>:-Werror>
  # GCC 12 reports uninitialised reads inside Eigen's own headers.
  $<$<CXX_COMPILER_ID:GNU>:-Wno-maybe-uninitialized>)
# Vector types passed between inlined functions of one file never cross an ABI border.
target_compile_options(kinetrace_options INTERFACE $<$<CXX_COMPILER_ID:GNU>:-Wno-psabi>)
# GCC 12 falsely reports copies of strings out of bounds: with sanitizers, with sizes of 32 bits, and in tests, which concatenate strings.
set(kinetrace_no_false_bounds "$<$<CXX_COMPILER_ID:GNU>:-Wno-array-bounds;-Wno-stringop-overflow;-Wno-stringop-overread;-Wno-restrict>")
if(KINETRACE_SANITIZED OR CMAKE_SIZEOF_VOID_P EQUAL 4)
  target_compile_options(kinetrace_options INTERFACE "${kinetrace_no_false_bounds}")
endif()

# Headers of most sources. None of them may have inline functions that call its own templates: each source would instantiate them (CLI11:
# eight seconds).
set(kinetrace_common_headers
  <Eigen/Core> <Eigen/Geometry> <algorithm> <cmath> <filesystem> <functional> <memory> <span> <sstream> <string> <vector>)

# kinetrace_precompile(TARGET KIND): the headers that most sources of a kind include, compiled once for all of its targets. KIND is
# "module", "cold" (a module that is compiled for size, see kinetrace_cold) or "test".
function(_kinetrace_headers kind)
  set(source ${CMAKE_BINARY_DIR}/precompiled/${kind}.cpp)
  file(CONFIGURE OUTPUT ${source} CONTENT "")
  add_library(kinetrace_headers_${kind} OBJECT ${source})
  target_link_libraries(kinetrace_headers_${kind} PRIVATE kinetrace_options Eigen3::Eigen)
  target_precompile_headers(kinetrace_headers_${kind} PRIVATE ${kinetrace_common_headers} ${ARGN})
endfunction()
function(kinetrace_precompile target kind)
  if(NOT TARGET kinetrace_headers_${kind})
    if(kind STREQUAL "test")
      _kinetrace_headers(test <gtest/gtest.h> <gmock/gmock.h>)
      target_link_libraries(kinetrace_headers_test PRIVATE GTest::gmock GTest::gtest)
      # As CMake compiles the sources of executables.
      set_target_properties(kinetrace_headers_test PROPERTIES POSITION_INDEPENDENT_CODE OFF)
      target_compile_options(kinetrace_headers_test PRIVATE ${CMAKE_CXX_COMPILE_OPTIONS_PIE})
    else()
      _kinetrace_headers(${kind})
      if(kind STREQUAL "cold")
        kinetrace_cold(kinetrace_headers_cold)
      endif()
    endif()
  endif()
  target_precompile_headers(${target} REUSE_FROM kinetrace_headers_${kind})
endfunction()

# kinetrace_module(NAME [COLD] SOURCES ... [PUBLIC libs...] [PRIVATE libs...]): the library kinetrace_NAME, alias kinetrace::NAME, with
# headers under include/ and modules/core as its only public dependency by default. COLD: see kinetrace_cold.
function(kinetrace_module name)
  cmake_parse_arguments(ARG "COLD" "" "SOURCES;PUBLIC;PRIVATE" ${ARGN})
  add_library(kinetrace_${name} STATIC ${ARG_SOURCES})
  add_library(kinetrace::${name} ALIAS kinetrace_${name})
  target_include_directories(kinetrace_${name} PUBLIC ${CMAKE_CURRENT_SOURCE_DIR}/include PRIVATE ${CMAKE_CURRENT_SOURCE_DIR}/src)
  target_link_libraries(kinetrace_${name} PUBLIC ${ARG_PUBLIC} PRIVATE kinetrace_options ${ARG_PRIVATE})
  if(NOT name STREQUAL "core")
    target_link_libraries(kinetrace_${name} PUBLIC kinetrace::core)
  endif()
  if(ARG_COLD)
    kinetrace_cold(kinetrace_${name})
  else()
    kinetrace_precompile(kinetrace_${name} module)
  endif()
endfunction()

# kinetrace_cold(TARGET): code that runs once per command, or once per picture for a person; optimised for size on disk, not for speed.
function(kinetrace_cold target)
  target_compile_options(${target} PRIVATE $<$<NOT:$<CONFIG:Debug>>:-Os>)
  get_target_property(type ${target} TYPE)
  if(type STREQUAL "STATIC_LIBRARY")
    kinetrace_precompile(${target} cold)
  endif()
endfunction()

# Targets of hot kernels: the baseline of the architecture, and the processors of today's boards and desktops. ARM's baseline is without
# NEON, so that the results of NEON can be compared. Other architectures have the baseline twice.
set(kinetrace_baseline_flags "")
set(kinetrace_fast_flags "")
if(CMAKE_SYSTEM_PROCESSOR MATCHES "x86_64|AMD64")
  set(kinetrace_fast_flags -march=x86-64-v3 -ffp-contract=fast)
elseif(CMAKE_SYSTEM_PROCESSOR MATCHES "aarch64|arm64")
  set(kinetrace_baseline_flags -march=armv8-a+nosimd)
elseif(CMAKE_SYSTEM_PROCESSOR MATCHES "^arm")
  set(kinetrace_baseline_flags -mfpu=vfpv3-d16)
  set(kinetrace_fast_flags -mfpu=neon-vfpv4)
endif()

# kinetrace_kernel(TARGET FILE): compiles FILE twice, for the baseline and for fast processors. The source puts its code in namespace
# KINETRACE_KERNEL_ISA (kernel_baseline or kernel_fast); the caller chooses at run time with kinetrace::cpu_runs_fast_kernels()
# from core. Kernels use GCC vector extensions, so the same source serves all of them.
function(kinetrace_kernel target file)
  get_filename_component(stem ${file} NAME_WE)
  function(_variant isa flags)
    add_library(${target}_${stem}_${isa} OBJECT ${file})
    target_compile_definitions(${target}_${stem}_${isa} PRIVATE KINETRACE_KERNEL_ISA=kernel_${isa})
    target_compile_options(${target}_${stem}_${isa} PRIVATE $<$<NOT:$<CONFIG:Debug>>:-O3> ${flags})
    target_include_directories(${target}_${stem}_${isa} PRIVATE $<TARGET_PROPERTY:${target},INCLUDE_DIRECTORIES>)
    target_link_libraries(${target}_${stem}_${isa} PRIVATE kinetrace_options kinetrace::core)
    target_sources(${target} PRIVATE $<TARGET_OBJECTS:${target}_${stem}_${isa}>)
  endfunction()
  _variant(baseline "${kinetrace_baseline_flags}")
  _variant(fast "${kinetrace_fast_flags}")
endfunction()

# Emulation is up to thirty times slower.
set(kinetrace_test_timeout_s 300)
if(CMAKE_CROSSCOMPILING)
  set(kinetrace_test_timeout_s 1800)
endif()

# kinetrace_test(NAME [ALONE] SOURCES ... LIBS ... [LABELS ...]): a GoogleTest program with its tests registered one by one, labelled with
# its folder below tests/ ("unit") unless set otherwise. ALONE: the test depends on time; nothing else runs meanwhile, and under emulation,
# where time differs, its label is "time" only.
function(kinetrace_test name)
  cmake_parse_arguments(ARG "ALONE" "" "SOURCES;LIBS;LABELS" ${ARGN})
  if(NOT ARG_LABELS)
    file(RELATIVE_PATH place ${PROJECT_SOURCE_DIR}/tests ${CMAKE_CURRENT_SOURCE_DIR})
    string(REGEX REPLACE "/.*" "" ARG_LABELS "${place}")
  endif()
  if(ARG_ALONE AND CMAKE_CROSSCOMPILING)
    set(ARG_LABELS time)
  endif()
  add_executable(${name} ${ARG_SOURCES})
  target_link_libraries(${name} PRIVATE kinetrace_options ${ARG_LIBS} GTest::gmock GTest::gtest GTest::gtest_main)
  target_compile_options(${name} PRIVATE "${kinetrace_no_false_bounds}")
  target_include_directories(${name} PRIVATE ${PROJECT_SOURCE_DIR}/tests/support)
  kinetrace_precompile(${name} test)
  if(CMAKE_CROSSCOMPILING)
    target_compile_definitions(${name} PRIVATE KINETRACE_EMULATED)
  endif()
  if(KINETRACE_SANITIZED)
    target_compile_definitions(${name} PRIVATE KINETRACE_SANITIZED)
    set(environment ENVIRONMENT "TSAN_OPTIONS=suppressions=${PROJECT_SOURCE_DIR}/tests/support/tsan.supp:die_after_fork=0")
  endif()
  gtest_discover_tests(${name} DISCOVERY_MODE PRE_TEST DISCOVERY_TIMEOUT 60
    PROPERTIES LABELS "${ARG_LABELS}" TIMEOUT ${kinetrace_test_timeout_s} RUN_SERIAL "${ARG_ALONE}" ${environment})
endfunction()
