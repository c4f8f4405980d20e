// Loads the optional libcamera plugin.
#pragma once

namespace kinetrace::app {

/// Registers libcamera's cameras if the plugin lies beside the program; a plugin that cannot be loaded causes a
/// warning. Repeated calls have no effect.
void load_libcamera();

}  // namespace kinetrace::app
