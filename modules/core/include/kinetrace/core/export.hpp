// What the shared libraries show. Everything is hidden unless marked.
#pragma once

/// Before a function's type or after `class`: part of the interface that programs link against.
#define KINETRACE_API [[gnu::visibility("default")]]
