#pragma once

#include "atom.h"

namespace bedload {

/// Place of the atom `tag` among those that this rank owns; -1: it is not here. Atom::map reads
/// beyond its array for tags above the highest that is left when atoms have been deleted.
inline int owned_atom(LAMMPS_NS::Atom& atom, int tag) {
  constexpr int array = 1;  // Atom::map_style
  if (atom.map_style == array && tag > atom.map_tag_max) return -1;
  const int i = atom.map(tag);
  return i < atom.nlocal ? i : -1;
}

}  // namespace bedload
