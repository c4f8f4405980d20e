// Exit codes, after sysexits.h.
#pragma once

#include "kinetrace/core/result.hpp"

namespace kinetrace::app {

enum class ExitCode : int {
  kOk = 0,
  kConditionHolds = 1,  ///< A condition of --fail-if holds, or a check of doctor failed.
  kUsage = 64,          ///< The command line is wrong.
  kBadData = 65,        ///< A recording or calibration is damaged or not usable.
  kNoInput = 66,        ///< A file or folder does not exist.
  kInternal = 70,       ///< A defect of this program.
  kCannotCreate = 73,   ///< The run folder cannot be made, or a result would replace a file of another kind.
  kIo = 74,             ///< Reading or writing failed during the run.
  kConfig = 78,         ///< The configuration is wrong or asks for more memory than the budget holds.
};
inline constexpr int kSignalBase = 128;  ///< Plus the signal's number, when a signal ended the run early.

[[nodiscard]] constexpr ExitCode exit_code(ErrorCode code) noexcept {
  switch (code) {
    case ErrorCode::kInvalidArgument: return ExitCode::kUsage;
    case ErrorCode::kInvalidConfig:
    case ErrorCode::kCapacity:
    case ErrorCode::kBudget: return ExitCode::kConfig;
    case ErrorCode::kNotFound: return ExitCode::kNoInput;
    case ErrorCode::kBadFormat:
    case ErrorCode::kUnsupported:
    case ErrorCode::kBadCalibration: return ExitCode::kBadData;
    case ErrorCode::kOccupied: return ExitCode::kCannotCreate;
    case ErrorCode::kIo:
    case ErrorCode::kTimeout:
    case ErrorCode::kDisconnected: return ExitCode::kIo;
    case ErrorCode::kEndOfStream:
    case ErrorCode::kIllegalState:
    case ErrorCode::kInternal: return ExitCode::kInternal;
  }
  return ExitCode::kInternal;
}

}  // namespace kinetrace::app
