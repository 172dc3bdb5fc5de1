#pragma once

#include <cstdint>

namespace LAMMPS_NS {
class LAMMPS;
}

namespace bedload {

struct RunScript;

/// How many fixes may insert spheres while a run goes on.
int inserting_fixes(LAMMPS_NS::LAMMPS* lmp);

/// How many spheres they have inserted so far; the same on all ranks.
std::int64_t inserted_spheres(LAMMPS_NS::LAMMPS* lmp);

/// Ends the job where the script's property fluidCellSize is not the fluid's, and warns where its
/// fluidTimeStep is not, which may change from step to step.
void compare_with_fluid(LAMMPS_NS::LAMMPS* lmp);

/// Ends the job where the box of the script is triclinic or has two dimensions, unlike the fluid's.
void refuse_other_boxes(LAMMPS_NS::LAMMPS* lmp);

/// Ends the job where the script's run_style is not verlet: others split a step as the coupling
/// does not know.
void refuse_other_integrators(LAMMPS_NS::LAMMPS* lmp);

/// Ends the job where a fix insert gives spheres other numbers (compress_tags), by which the fluid
/// knows them.
void refuse_new_numbers(LAMMPS_NS::LAMMPS* lmp);

/// Warns of a fix buoyancy: the fluid's pressure gives the spheres theirs.
void warn_of_second_buoyancy(LAMMPS_NS::LAMMPS* lmp);

/// Warns where a line of the script counts steps of the script's `timestep`, which is not the one
/// that is made: insert_every_time and duration_time of an insertion.
/// @param script known to the first rank
/// @param dem_time_step that will be made [T]
void warn_of_counted_times(LAMMPS_NS::LAMMPS* lmp, const RunScript& script, double dem_time_step);

/// Warns where gravity points along a direction with ends, but no fix and no fixed sphere keeps
/// spheres from those: the fluid's walls stop the fluid alone.
void warn_without_walls(LAMMPS_NS::LAMMPS* lmp, bool fixed_spheres);

/// Warns of a fix nve, which moves spheres but never turns them: friction and the fluid's torque
/// would come to nothing.
void warn_without_spin(LAMMPS_NS::LAMMPS* lmp);

/// Warns where LIGGGHTS' step is too long for contacts of hertz or hooke, whose stiffness is the
/// material's: a large part of the Rayleigh time. Collective.
/// @param fluid_time_step [T]
void warn_of_stiff_contacts(LAMMPS_NS::LAMMPS* lmp, double fluid_time_step);

/// Warns where two spheres can touch each other through both sides of a periodic box: LIGGGHTS
/// keeps what a contact remembers by the partner's number alone, so that each of the two contacts
/// goes on with the other's. Collective.
void warn_of_contacts_through_both_sides(LAMMPS_NS::LAMMPS* lmp);

/// Warns of a fix move with NULL for a direction, which it leaves to forces: collisions and films
/// take its spheres as held in all directions.
void warn_of_partly_held(LAMMPS_NS::LAMMPS* lmp);

}  // namespace bedload
