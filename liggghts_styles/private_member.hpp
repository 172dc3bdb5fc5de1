#pragma once

namespace bedload::detail {

/// A private member of a class of LIGGGHTS, which has no other way for a program to look at it
/// without editing its sources. An explicit template instantiation may name a private member; that
/// is the legal door used here:
///
///     struct ScriptLine {
///       friend constexpr auto member(ScriptLine);
///     };
///     template struct PrivateMember<ScriptLine, &LAMMPS_NS::Input::line>;
///
/// and `input.*member(ScriptLine{})` is the member.
template <class Name, auto Member>
struct PrivateMember {
  friend constexpr auto member(Name) { return Member; }
};

}  // namespace bedload::detail
