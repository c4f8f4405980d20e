// All capture backends of the build.
#pragma once

namespace kinetrace::hal::test {

/// V4L2 is always available; libcamera from the first call on, if built in.
void use_all_backends();

}  // namespace kinetrace::hal::test
