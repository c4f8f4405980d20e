// libcamera, where the program was installed with it.
#pragma once

namespace kinetrace::app {

/// Makes cameras of libcamera known if its plugin lies beside the program; a plugin that is there but cannot be loaded
/// is a warning. Does it once, however often it is called.
void load_libcamera();

}  // namespace kinetrace::app
