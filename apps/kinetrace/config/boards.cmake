# The files of config/boards as text in the program, so that --board works wherever it runs.
file(GLOB board_files CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/config/boards/*.yaml)
list(SORT board_files)
set(board_entries "")
foreach(file IN LISTS board_files)
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${file})
  cmake_path(GET file STEM name)
  file(READ ${file} yaml)
  string(APPEND board_entries "    {\"${name}\", R\"yaml(${yaml})yaml\"},\n")
endforeach()
file(CONFIGURE OUTPUT ${CMAKE_CURRENT_BINARY_DIR}/board_profile_texts.cpp @ONLY CONTENT
[[// Made from config/boards by the build.
#include <array>

#include "config/board_profiles.hpp"

namespace kinetrace::app {
namespace {

constexpr auto kProfiles = std::to_array<BoardProfile>({
@board_entries@});

}  // namespace

std::span<const BoardProfile> board_profiles() noexcept {
  return kProfiles;
}

}  // namespace kinetrace::app
]])
target_sources(kinetrace_app PRIVATE board_profiles.cpp ${CMAKE_CURRENT_BINARY_DIR}/board_profile_texts.cpp)
