// observations.bin: a header, then records of recording::Observation.
#pragma once

#include <string_view>

#include "kinetrace/recording/observations.hpp"

namespace kinetrace::recording {

inline constexpr std::string_view kObservationFile = "observations.bin";
/// As long as a record, so that records are aligned.
inline constexpr std::string_view kObservationHeader = "kinetrace observations\n1";
static_assert(kObservationHeader.size() == sizeof(Observation));

}  // namespace kinetrace::recording
