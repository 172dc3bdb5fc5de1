#include "liggghts_styles/contact_observers.hpp"

#include <fmt/format.h>
#include <mpi.h>

#include <algorithm>

#include "fix.h"
#include "liggghts_styles/keywords.hpp"
#include "liggghts_styles/liggghts.hpp"
#include "liggghts_styles/mobility.hpp"

namespace bedload {

void ContactObservers::add(const LAMMPS_NS::Fix* wall) {
  if (wall != nullptr) {
    walls_.push_back(wall);
    return;
  }
  pairs_ = true;
  walls_.clear();
}

void ContactObservers::check_pairs(LAMMPS_NS::LAMMPS* lmp, std::string_view style) {
  if (!pairs_)
    stop_run(lmp, fmt::format("{} works with pair_style gran and a contact model that bedload "
                              "knows: {}",
                              style, known_models));
  pairs_ = false;  // the next run's have to report again
}

void ContactObservers::check_walls(LAMMPS_NS::LAMMPS* lmp, std::string_view style,
                                   int groupbit) const {
  const Mobility mobility(lmp);
  const LAMMPS_NS::Atom& atom = *lmp->atom;
  for (int n = 0; n < lmp->modify->nfix; ++n) {
    const LAMMPS_NS::Fix* const wall = lmp->modify->fix[n];
    if (std::string_view(wall->style) != "wall/gran") continue;
    if (std::find(walls_.begin(), walls_.end(), wall) != walls_.end()) continue;
    const auto meets_it = [&](int mask) {
      return (mask & groupbit) != 0 && (mask & wall->groupbit) != 0 && !mobility.held(mask);
    };
    int found = std::any_of(atom.mask, atom.mask + atom.nlocal, meets_it) ? 1 : 0;
    MPI_Allreduce(MPI_IN_PLACE, &found, 1, MPI_INT, MPI_MAX, lmp->world);
    if (found != 0)
      stop_run(lmp,
               fmt::format("{} does not hear of the wall '{}', whose contact model is none that "
                           "bedload knows; take the one of the pairs there, or leave the wall's "
                           "spheres out of the group of {}",
                           style, wall->id, style));
  }
}

void refuse_newton(LAMMPS_NS::LAMMPS* lmp, std::string_view style) {
  if (lmp->force->newton_pair != 0)
    stop_run(lmp, fmt::format("{} needs the line 'newton off' before the box is made", style));
}

}  // namespace bedload
