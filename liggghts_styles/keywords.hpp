#pragma once

#include <span>
#include <string_view>

namespace LAMMPS_NS {
class LAMMPS;
}

/// Keywords and their values in LIGGGHTS input lines, checked: LIGGGHTS itself reads text as 0.
namespace bedload {

/// The number written in `text`. Ends the run with one sentence (style, keyword, value found) if it
/// is not a finite number.
double read_number(LAMMPS_NS::LAMMPS* lmp, std::string_view style, std::string_view keyword,
                   std::string_view text);

/// A keyword that takes a number, and the values that are allowed: above `lower`, or equal to it if
/// `or_equal`, and not above `upper`.
struct NumberKeyword {
  std::string_view name;
  double lower;
  bool or_equal;
  double upper;
};

/// Ends the run with one sentence if `value` is not what the keyword allows.
void check_number(LAMMPS_NS::LAMMPS* lmp, std::string_view style, const NumberKeyword& keyword,
                  double value);

/// Checks those of the pairs "keyword value" among `arguments` that are in `keywords`; leaves
/// others to whoever knows them.
void check_numbers(LAMMPS_NS::LAMMPS* lmp, std::string_view style,
                   std::span<const NumberKeyword> keywords, std::span<char*> arguments);

/// Ends the run on all ranks with one sentence. To be called on every rank.
[[noreturn]] void stop_run(LAMMPS_NS::LAMMPS* lmp, std::string_view sentence);

}  // namespace bedload
