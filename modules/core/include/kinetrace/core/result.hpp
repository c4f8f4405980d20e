// Errors as values: every operation that can fail for a reason outside the program returns Result<T>.
#pragma once

#include <string>
#include <string_view>
#include <utility>

#include "kinetrace/core/expected.hpp"

namespace kinetrace {

/// Why an operation failed. An expected outcome (few features, no parallax, lost) is a status in the output, never an
/// Error.
enum class ErrorCode {
  kInvalidArgument,  ///< A value the caller passed is out of range.
  kInvalidConfig,    ///< A configuration key is unknown, duplicate, not finite or out of range.
  kNotFound,         ///< A file, folder or device does not exist.
  kIo,               ///< Reading or writing failed.
  kOccupied,         ///< The place of a result belongs to something else, which is not replaced.
  kBadFormat,        ///< A file exists but its content is damaged or not what its name says.
  kUnsupported,      ///< Well-formed, but outside what this build handles.
  kBadCalibration,   ///< A calibration is missing, not finite, swapped, or has no baseline.
  kCapacity,         ///< A fixed capacity does not hold what was asked for.
  kBudget,           ///< The memory budget does not hold the memory plan.
  kTimeout,          ///< Nothing arrived in time.
  kEndOfStream,      ///< A recording has ended.
  kIllegalState,     ///< The call does not fit the object's state.
  kDisconnected,     ///< A device has gone.
  kInternal,         ///< A library failed in a way that points to a defect.
};

/// Stable lower-case name of a code, for logs and JSON.
[[nodiscard]] constexpr std::string_view to_string(ErrorCode code) noexcept {
  switch (code) {
    case ErrorCode::kInvalidArgument: return "invalid_argument";
    case ErrorCode::kInvalidConfig: return "invalid_config";
    case ErrorCode::kNotFound: return "not_found";
    case ErrorCode::kIo: return "io";
    case ErrorCode::kOccupied: return "occupied";
    case ErrorCode::kBadFormat: return "bad_format";
    case ErrorCode::kUnsupported: return "unsupported";
    case ErrorCode::kBadCalibration: return "bad_calibration";
    case ErrorCode::kCapacity: return "capacity";
    case ErrorCode::kBudget: return "budget";
    case ErrorCode::kTimeout: return "timeout";
    case ErrorCode::kEndOfStream: return "end_of_stream";
    case ErrorCode::kIllegalState: return "illegal_state";
    case ErrorCode::kDisconnected: return "disconnected";
    case ErrorCode::kInternal: return "internal";
  }
  return "internal";
}

/// One clear line: it names the thing that failed and says what to do about it.
struct Error {
  ErrorCode code = ErrorCode::kInternal;
  std::string message;
};

template <typename T>
using Result = Expected<T, Error>;

/// Success, or why not.
using Status = Result<void>;

/// `return fail(ErrorCode::kNotFound, "...")` from any function that returns a Result.
[[nodiscard]] inline Unexpected<Error> fail(ErrorCode code, std::string message) {
  return Unexpected<Error>(Error{code, std::move(message)});
}

}  // namespace kinetrace
