#pragma once

#include <string>

#include "fluid/statistics/statistics.hpp"

namespace bedload {

/// folder/statistics.h5, written under a temporary name and renamed (README.md has the layout).
/// First rank.
void write_statistics(const std::string& folder, const FlowStatistics& statistics);

/// The numbers of a flow on one line each, for the terminal.
std::string statistics_summary(const FlowStatistics& statistics);

}  // namespace bedload
