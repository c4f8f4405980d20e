// Every way to cameras that the build has.
#pragma once

namespace kinetrace::hal::test {

/// V4L2 is always there; libcamera from the first call on, where it is built in.
void use_all_backends();

}  // namespace kinetrace::hal::test
