# Keys for DDS Security, if DDS is available.
if(TARGET kinetrace::publishing)
  find_package(OpenSSL REQUIRED COMPONENTS Crypto)
  target_sources(kinetrace PRIVATE authority.cpp dds_permissions.cpp keys_command.cpp)
  target_link_libraries(kinetrace PRIVATE kinetrace::publishing OpenSSL::Crypto)
else()
  target_sources(kinetrace PRIVATE keys_unavailable.cpp)
endif()
