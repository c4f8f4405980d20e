// Lines for the user on standard error.
#pragma once

#include <string_view>

#include "cli/failure.hpp"

namespace kinetrace::app {

void print_error(std::string_view message);
void print_warning(std::string_view message);

/// Prints the failure; returns its exit code.
int report(const Failure& failure);

}  // namespace kinetrace::app
