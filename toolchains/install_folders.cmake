# Installation folders. Libraries of several architectures lie side by side, as usual on Debian.
if(NOT DEFINED CMAKE_INSTALL_LIBDIR AND CMAKE_LIBRARY_ARCHITECTURE)
  set(CMAKE_INSTALL_LIBDIR lib/${CMAKE_LIBRARY_ARCHITECTURE} CACHE STRING "Folder of libraries, below the prefix")
endif()
include(GNUInstallDirs)
# Installation does not need the tests.
set(CMAKE_SKIP_INSTALL_ALL_DEPENDENCY ON)
