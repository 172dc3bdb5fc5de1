#pragma once

#include <string>

#include "coupling/bedload_dem/motion_rules.hpp"
#include "coupling/bedload_dem/script_gravity.hpp"
#include "coupling/exchange/message.hpp"

namespace LAMMPS_NS {
class Domain;
class LAMMPS;
}  // namespace LAMMPS_NS

namespace bedload {

class CoupledSpheres;

/// LIGGGHTS' box as it is now.
Box box_of(const LAMMPS_NS::Domain& domain);

/// A scene of which the box alone is known.
DemSceneInfo describe_box(const Box& box);

/// The scene as the script has made it so far. Ends LIGGGHTS with a sentence where mobile spheres
/// differ in their gravity. Collective.
DemSceneInfo describe_scene(LAMMPS_NS::LAMMPS* lmp, const CoupledSpheres& spheres,
                            Moment moment = Moment::before_run);

/// What acts between spheres by the script, one effect per line: name, state, reason, separated by
/// tabs.
std::string describe_effects(LAMMPS_NS::LAMMPS* lmp);

}  // namespace bedload
