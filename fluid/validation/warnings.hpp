#pragma once

#include <limits>
#include <span>
#include <string>
#include <vector>

#include "fluid/grid/sphere.hpp"
#include "fluid/settings/settings.hpp"
#include "fluid/validation/derived_numbers.hpp"

namespace bedload {

/// One sentence for each setting that is allowed but makes little physical sense, or has no effect
/// in this scene. Printed at the start.
std::vector<std::string> warnings(const Settings& settings, const DerivedNumbers& numbers);

/// One sentence with the keys that are set for spheres, or for mobile ones where `fixed` ones there
/// are, of a run that can have none. Printed at the start.
std::vector<std::string> warnings_without_spheres(const Settings& settings, bool fixed);

/// What is hardest among the mobile spheres of a run, in steps of the length that is in force.
struct SphereExtremes {
  static constexpr double none = std::numeric_limits<double>::infinity();
  double lightest = none, heaviest = 0.0;  ///< mass over 4 pi/3 [M]
  double thinnest_layer = none;            ///< D/sqrt(Re) in free fall [cells], and its
  double reynolds = 0.0;                   ///< Re
  double fastest = 0.0;        ///< most cells that one goes in a time step, with its present speed
  double fastest_light = 0.0;  ///< that of light ones
  double lightest_ratio = none;  ///< least density over the fluid's
  bool weigh = false;            ///< whether one is of another density than the fluid
  double heaviest_ratio = 0.0;   ///< largest density over the fluid's
  double widest = 0.0;           ///< largest diameter [L]
  double narrowest = none;       ///< smallest diameter [L]
  double time_step = 0.0;        ///< [T]
  bool held = false;             ///< whether a fixed sphere holds the fluid
};

/// Of the mobile ones among `spheres`, in steps of `time_step` [T]: with time.cfl others than
/// time.step.
SphereExtremes extremes_of(const Settings& settings, std::span<const SphereState> spheres,
                           double time_step);

/// Diffusion number nu dt/h^2 up to which free spheres half a cell apart calm down in steps of
/// implicit diffusion (test DenseFreeSpheresCalmDownInLongSteps); half as long again is too long
/// for density ratios of 0.7 and 1.5, twice as long for a bed of 2.1. Beyond it a sphere alone may
/// swing, too: kicked at a ratio of 0.7 and a number of 8 it does for ten steps.
/// @param density_ratio of the lightest sphere and the fluid
double longest_diffusion(double density_ratio);

/// One sentence for each of reference.diameter and reference.sphere_density that none of the mobile
/// spheres have, nor lies between theirs. Printed at the start.
std::vector<std::string> warnings_of_reference(const Settings& settings,
                                               const SphereExtremes& spheres);

/// One sentence for each thing that the scheme does not do well with such mobile spheres; the run
/// goes on nevertheless. Printed at the start, and whenever spheres come or change.
std::vector<std::string> warnings(const Settings& settings, const SphereExtremes& spheres);

}  // namespace bedload
