// Cameras through libcamera: a component of its own, kinetrace::hal_libcamera, so that nobody else links libcamera.
#pragma once

namespace kinetrace::hal {

/// From then on cameras with the backend kLibcamera can be opened and are listed. Called once, by the application,
/// before it opens or lists cameras; the first of those starts libcamera's camera manager and its thread.
void use_libcamera();

}  // namespace kinetrace::hal
