#include "fluid/output/history.hpp"

#include <fmt/format.h>

namespace bedload {
namespace {

/// Joins text(column) of every column with commas.
template <class Text>
std::string joined(Text&& text) {
  std::string line;
  std::apply([&](const auto&... column) { ((line += "," + text(column)), ...); }, history_columns);
  return line.substr(1);
}

}  // namespace

std::string history_header() {
  return joined([](const auto& column) { return std::string(column.name); });
}

std::string history_line(const HistoryRow& row) {
  return joined([&](const auto& column) { return fmt::format("{}", row.*column.value); });
}

}  // namespace bedload
