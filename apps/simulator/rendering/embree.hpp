// Ray queries for Embree versions 3 and 4; only this file depends on the version.
#pragma once

#include <array>
#include <cstddef>
#include <span>

#if KINETRACE_EMBREE_VERSION >= 4  // As CMakeLists.txt has found.
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

namespace kinetrace::simulator {

/// Packets as wide as an AVX2 register, which Embree traces in place; wider ones it would copy.
inline constexpr std::size_t kGroupWidth = 8;

#if RTC_VERSION_MAJOR >= 4

/// A ray whose far end lies before its origin is inactive: it lies beyond the packet's end, or was blocked already.
struct ActiveRays {
  alignas(32) std::array<int, kGroupWidth> valid;

  explicit ActiveRays(const RTCRay8& rays) noexcept {
    for (std::size_t i = 0; i < kGroupWidth; ++i) {
      valid[i] = rays.tfar[i] >= 0.F ? -1 : 0;
    }
  }
};

/// Nearest hits of nearly parallel rays.
inline void intersect(RTCScene scene, std::span<RTCRayHit8> groups) {
  RTCIntersectArguments arguments;
  rtcInitIntersectArguments(&arguments);
  arguments.flags = RTC_RAY_QUERY_FLAG_COHERENT;
  for (RTCRayHit8& group : groups) {
    rtcIntersect8(ActiveRays(group.ray).valid.data(), scene, &group, &arguments);
  }
}

/// Blocked rays get a far end of minus infinity.
inline void occlude(RTCScene scene, std::span<RTCRay8> groups) {
  RTCOccludedArguments arguments;
  rtcInitOccludedArguments(&arguments);
  arguments.flags = RTC_RAY_QUERY_FLAG_COHERENT;
  for (RTCRay8& group : groups) {
    rtcOccluded8(ActiveRays(group).valid.data(), scene, &group, &arguments);
  }
}

inline void occlude(RTCScene scene, RTCRay& ray) {
  rtcOccluded1(scene, &ray);
}

#else

inline RTCIntersectContext coherent_context() {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  return context;
}

/// Nearest hits of nearly parallel rays.
inline void intersect(RTCScene scene, std::span<RTCRayHit8> groups) {
  RTCIntersectContext context = coherent_context();
  rtcIntersectNM(scene, &context, reinterpret_cast<RTCRayHitN*>(groups.data()), kGroupWidth,
                 static_cast<unsigned>(groups.size()), sizeof groups[0]);
}

/// Blocked rays get a far end of minus infinity.
inline void occlude(RTCScene scene, std::span<RTCRay8> groups) {
  RTCIntersectContext context = coherent_context();
  rtcOccludedNM(scene, &context, reinterpret_cast<RTCRayN*>(groups.data()), kGroupWidth,
                static_cast<unsigned>(groups.size()), sizeof groups[0]);
}

inline void occlude(RTCScene scene, RTCRay& ray) {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcOccluded1(scene, &context, &ray);
}

#endif

}  // namespace kinetrace::simulator
