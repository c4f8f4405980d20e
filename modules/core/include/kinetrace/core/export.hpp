// Symbol visibility of the shared libraries: hidden unless marked.
#pragma once

/// Before a function's type or after `class`: part of the public interface.
#define KINETRACE_API [[gnu::visibility("default")]]
