// Converts decoded native messages for listeners. Messages are untrusted.
#pragma once

#include <cstdint>
#include <functional>

#include "kinetrace.h"
#include "kinetrace/core/instance_masks.hpp"
#include "kinetrace/publishing/mask_exchange.hpp"
#include "kinetrace/publishing/result_reader.hpp"

namespace kinetrace::publishing {

void tell(const kinetrace_CameraPose& message, ResultListener& listener);
void tell(const kinetrace_TrackedObjects& message, ResultListener& listener);
void tell(const kinetrace_Health& message, ResultListener& listener);
void tell(const kinetrace_Calibration& message, ResultListener& listener);

/// `sender` as in MaskMessage.
void tell(const kinetrace_InstanceMasks& message, std::uint64_t sender,
          const std::function<void(const MaskMessage&)>& visit);

}  // namespace kinetrace::publishing
