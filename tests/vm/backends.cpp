#include "backends.hpp"

#ifdef KINETRACE_WITH_LIBCAMERA
#include "kinetrace/hal/libcamera_backend.hpp"
#endif

namespace kinetrace::hal::test {

void use_all_backends() {
#ifdef KINETRACE_WITH_LIBCAMERA
  use_libcamera();
#endif
}

}  // namespace kinetrace::hal::test
