#include "coupling/bedload_dem/script_rules.hpp"

#include <fmt/format.h>
#include <mpi.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "atom.h"
#include "comm.h"
#include "coupling/bedload_dem/script_gravity.hpp"
#include "coupling/job/run_script.hpp"
#include "domain.h"
#include "error.h"
#include "fix.h"
#include "fix_move.h"
#include "fix_property_global.h"
#include "force.h"
#include "lammps.h"
#include "liggghts_styles/find_fix.hpp"
#include "liggghts_styles/fluid_values.hpp"
#include "liggghts_styles/formulas/rayleigh_time.hpp"
#include "liggghts_styles/keywords.hpp"
#include "liggghts_styles/private_access.hpp"
#include "modify.h"
#include "pair_gran.h"
#include "update.h"

namespace bedload {
namespace {

auto begins(std::string_view start) {
  return [start](const auto& fix) { return std::string_view(fix.style).starts_with(start); };
}

}  // namespace

int inserting_fixes(LAMMPS_NS::LAMMPS* lmp) {
  const LAMMPS_NS::Modify& modify = *lmp->modify;
  return static_cast<int>(std::count_if(modify.fix, modify.fix + modify.nfix, [](const auto* fix) {
    return std::string_view(fix->style).starts_with("insert/");
  }));
}

std::int64_t inserted_spheres(LAMMPS_NS::LAMMPS* lmp) {
  std::int64_t count = 0;
  for (int n = 0; n < lmp->modify->nfix; ++n)
    if (const auto* const fix = dynamic_cast<LAMMPS_NS::FixInsert*>(lmp->modify->fix[n]))
      count += detail::Insertion::so_far(*fix);
  return count;
}

void compare_with_fluid(LAMMPS_NS::LAMMPS* lmp) {
  const auto stated = [&](std::string_view property) {
    return FluidValue::find(lmp, "", property);
  };
  const auto of_fluid = [&](std::string_view key) { return FluidValue::find(lmp, key, "").get(); };
  const FluidValue cell = stated("fluidCellSize"), step = stated("fluidTimeStep");
  if (cell.known() && !same_as_fluid(cell.get(), of_fluid("cell_size")))
    stop_run(lmp,
             fmt::format("fix couple/fluid: property/global fluidCellSize is {:g}, and the fluid's "
                         "cells are {:g} wide (grid.length over grid.cells); they have to be the "
                         "same, or leave the property out",
                         cell.get(), of_fluid("cell_size")));
  if (step.known() && !same_as_fluid(step.get(), of_fluid("dt_fluid")) && lmp->comm->me == 0)
    lmp->error->warning(
        FLERR,
        fmt::format("fix couple/fluid: property/global fluidTimeStep is {:g}, which does not "
                    "count beside a fluid: its step is {:g}",
                    step.get(), of_fluid("dt_fluid"))
            .c_str());
}

void refuse_other_boxes(LAMMPS_NS::LAMMPS* lmp) {
  if (lmp->domain->dimension != 3)
    stop_run(
        lmp,
        "fix couple/fluid: the fluid's box has three dimensions; leave out 'dimension 2' (a box "
        "that is one diameter wide along z, where it is periodic, is as flat as spheres are)");
  if (lmp->domain->triclinic != 0)
    stop_run(lmp,
             "fix couple/fluid: the fluid's box has right angles; make that of the script with "
             "'region ID block ...'");
}

void refuse_other_integrators(LAMMPS_NS::LAMMPS* lmp) {
  if (lmp->update->integrate_style != nullptr &&
      std::string_view(lmp->update->integrate_style) != "verlet")
    stop_run(lmp, fmt::format("fix couple/fluid: loads of the fluid act in the steps of run_style "
                              "verlet alone, and this script has '{}'",
                              lmp->update->integrate_style));
}

void refuse_new_numbers(LAMMPS_NS::LAMMPS* lmp) {
  const auto* const renumbering = find_fix_if(*lmp->modify, [](const auto& fix) {
    const auto* const insertion = dynamic_cast<const LAMMPS_NS::FixInsert*>(&fix);
    return insertion != nullptr && detail::Insertion::compresses(*insertion);
  });
  if (renumbering != nullptr)
    stop_run(lmp,
             fmt::format("fix couple/fluid: fix {} (id {}) gives all spheres other numbers, and "
                         "the fluid knows them by their numbers; leave out 'compress_tags yes'",
                         renumbering->style, renumbering->id));
}

void warn_of_second_buoyancy(LAMMPS_NS::LAMMPS* lmp) {
  const auto* const buoyancy = find_fix_if(
      *lmp->modify, [](const auto& fix) { return std::string_view(fix.style) == "buoyancy"; });
  if (buoyancy == nullptr || lmp->comm->me != 0) return;
  lmp->error->warning(FLERR, fmt::format("fix couple/fluid: the fluid's force has the spheres' "
                                         "buoyancy, and fix buoyancy (id {}) gives it once more; "
                                         "leave that out",
                                         buoyancy->id)
                                 .c_str());
}

void warn_of_counted_times(LAMMPS_NS::LAMMPS* lmp, const RunScript& script, double dem_time_step) {
  if (lmp->comm->me != 0 || !lmp->update->timestep_set || inserting_fixes(lmp) == 0 ||
      same_as_fluid(lmp->update->dt, dem_time_step))
    return;
  for (const std::string_view word : {"insert_every_time", "duration_time"})
    if (std::any_of(script.lines.begin(), script.lines.end(), [word](const std::string& line) {
          return line.find(word) != std::string::npos;
        }))
      lmp->error->warning(
          FLERR,
          fmt::format("fix couple/fluid: {} was counted in steps of the script's timestep, {:.6g}, "
                      "but LIGGGHTS' step is {:.6g} here; set that timestep before the insertion",
                      word, lmp->update->dt, dem_time_step)
              .c_str());
}

void warn_without_walls(LAMMPS_NS::LAMMPS* lmp, bool fixed_spheres) {
  if (fixed_spheres || find_fix_if(*lmp->modify, begins("wall/")) != nullptr) return;
  const Triple gravity = script_gravity(lmp, [](int) { return false; }).value;
  for (std::size_t d = 0; d < 3; ++d)
    if (gravity[d] != 0.0 && lmp->domain->periodicity[d] == 0 && lmp->comm->me == 0)
      lmp->error->warning(
          FLERR,
          fmt::format("fix couple/fluid: gravity points along {0}, but the script has no wall "
                      "there and no fixed sphere, and spheres go on through the fluid's; write "
                      "'fix ID all wall/gran ... primitive type 1 {0}plane {1} ...'",
                      "xyz"[d], gravity[d] < 0.0 ? lmp->domain->boxlo[d] : lmp->domain->boxhi[d])
              .c_str());
}

void warn_without_spin(LAMMPS_NS::LAMMPS* lmp) {
  const auto* const mover = find_fix_if(*lmp->modify, [](const auto& fix) {
    const std::string_view style(fix.style);
    return style == "nve" || style == "nve/limit";
  });
  if (mover == nullptr || lmp->comm->me != 0) return;
  lmp->error->warning(
      FLERR,
      fmt::format("fix couple/fluid: fix {} (id {}) moves spheres without turning them, so that "
                  "they slide where they should roll; write 'fix {} GROUP nve/sphere'",
                  mover->style, mover->id, mover->id)
          .c_str());
}

void warn_of_stiff_contacts(LAMMPS_NS::LAMMPS* lmp, double fluid_time_step) {
  constexpr double most = 0.3;  // of the Rayleigh time; usual are a tenth to three tenths
  if (lmp->force->pair == nullptr || std::string_view(lmp->force->pair_style) != "gran") return;
  auto& pair = static_cast<LAMMPS_NS::PairGran&>(*lmp->force->pair);
  if (!pair.contact_match("normal", "hertz") && !pair.contact_match("normal", "hooke")) return;
  const LAMMPS_NS::Atom& atom = *lmp->atom;
  const auto property = [&](const char* name) {
    return static_cast<LAMMPS_NS::FixPropertyGlobal*>(lmp->modify->find_fix_property(
        name, "property/global", "peratomtype", atom.ntypes, 0, "fix couple/fluid", false));
  };
  auto *const stiffness = property("youngsModulus"), *const poisson = property("poissonsRatio");
  if (stiffness == nullptr || poisson == nullptr) return;  // LIGGGHTS asks for them itself
  double shortest = std::numeric_limits<double>::infinity();
  for (int i = 0; i < atom.nlocal; ++i) {
    const int type = atom.type[i] - 1;
    shortest = std::min(shortest, contact::rayleigh_time(atom.radius[i], atom.density[i],
                                                         stiffness->compute_vector(type),
                                                         poisson->compute_vector(type)));
  }
  MPI_Allreduce(MPI_IN_PLACE, &shortest, 1, MPI_DOUBLE, MPI_MIN, lmp->world);
  const double step = lmp->update->dt;
  if (step <= most * shortest || lmp->comm->me != 0) return;
  const double steps = 15.0 * std::ceil(fluid_time_step / (most * shortest) / 15.0);
  lmp->error->warning(
      FLERR,
      fmt::format("fix couple/fluid: LIGGGHTS' step of {:.3g} is {:.0f} % of the shortest "
                  "Rayleigh time of the spheres ({:.3g}), and contacts of hertz or hooke want "
                  "{:.0f} % at most; set 'coupling.dem_steps' of fluid.toml to {:.0f} or "
                  "lower youngsModulus",
                  step, 100.0 * step / shortest, shortest, 100.0 * most, steps)
          .c_str());
}

void warn_of_contacts_through_both_sides(LAMMPS_NS::LAMMPS* lmp) {
  const LAMMPS_NS::Atom& atom = *lmp->atom;
  const LAMMPS_NS::Domain& domain = *lmp->domain;
  if (lmp->force->pair == nullptr) return;
  std::vector<double> diameters{0.0, 0.0};  // 0: there is none
  for (int i = 0; i < atom.nlocal; ++i) diameters.push_back(2.0 * atom.radius[i]);
  const auto two_largest_first = [](std::vector<double>& all) {
    std::partial_sort(all.begin(), all.begin() + 2, all.end(), std::greater<>());
  };
  two_largest_first(diameters);
  int ranks = 1;
  MPI_Comm_size(lmp->world, &ranks);
  std::vector<double> all(2 * static_cast<std::size_t>(ranks));
  MPI_Allgather(diameters.data(), 2, MPI_DOUBLE, all.data(), 2, MPI_DOUBLE, lmp->world);
  two_largest_first(all);
  constexpr double close_by = 1.01;  // a contact is remembered until its surfaces are so far apart
  const double narrow = all[1] > 0.0 ? close_by * (all[0] + all[1]) : 0.0;
  for (const int d : {0, 1, 2})
    if (domain.periodicity[d] != 0 && domain.prd[d] < narrow && lmp->comm->me == 0)
      lmp->error->warning(
          FLERR,
          fmt::format("fix couple/fluid: the box is {:.4g} long along {}, where it is periodic: "
                      "spheres of diameters {:.4g} and {:.4g} that touch through both sides at "
                      "once exchange what their two contacts remember and gain energy; from {:.4g} "
                      "on they cannot",
                      domain.prd[d], "xyz"[d], all[0], all[1], narrow)
              .c_str());
}

void warn_of_partly_held(LAMMPS_NS::LAMMPS* lmp) {
  const auto* const partly = find_fix_if(*lmp->modify, [](const auto& fix) {
    return std::string_view(fix.style) == "move" &&
           detail::leaves_component(static_cast<const LAMMPS_NS::FixMove&>(fix));
  });
  if (partly == nullptr || lmp->comm->me != 0) return;
  lmp->error->warning(
      FLERR,
      fmt::format("fix couple/fluid: fix move (id {}) has NULL for a direction, along which its "
                  "spheres go by forces; collisions and films take them as held, so that they go "
                  "through what they meet there",
                  partly->id)
          .c_str());
}

}  // namespace bedload
