#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "fluid/grid/grid.hpp"
#include "fluid/grid/sphere.hpp"
#include "fluid/settings/settings.hpp"

namespace bedload {

/// Fewer cells to a diameter, and markers and their supports fill the whole sphere.
inline constexpr double least_cells_per_diameter = 4.0;

/// How deep a mobile sphere may be in a wall, in its radii.
inline constexpr double deepest_in_walls = 0.5;

/// The rules that no single key can tell: keys against each other, numbers that are allowed one by
/// one and make a run that no machine can do, and the limits of the time step. Throws UserError.
void validate(const Settings& settings);

/// Which overlaps of two spheres pass: slight ones, or those too that a run before has come to.
enum class Overlaps : bool { slight, as_they_are };

/// The rules for spheres in such a scene, each sphere by itself and mobile ones against walls and
/// neighbours. To be called at the start and whenever spheres come or change; then `changed` lists
/// the tags, ascending, of those that are looked at, of course beside all others. `spheres`: all,
/// or all that may be near the changed ones. Throws UserError with one sentence. What the spheres
/// of a fixed bed do among themselves and with walls is free: they stay.
void validate(const Settings& settings, std::span<const SphereState> spheres,
              Overlaps overlaps = Overlaps::slight);
void validate(const Settings& settings, std::span<const SphereState> spheres,
              std::span<const std::int64_t> changed);

/// What is wrong with the size or the place of a sphere on this grid, to stand behind its name
/// ("has the radius ..."); nothing where it is sound.
std::optional<std::string> flaw_of(const Grid& grid, const SphereState& sphere);

/// The part of flaw_of() that a moving sphere can come to break: spheres need cubic cells around
/// them, and y may be stretched. Throws UserError, with `file` at the head of the sentence.
void check_in_cubes(const std::string& file, const Grid& grid,
                    std::span<const SphereState> spheres);

/// The part of validate(settings) that the flow solver relies on: a step that explicit diffusion is
/// stable with. Throws UserError.
void check_explicit_diffusion(const Settings& settings, const Grid& grid);

/// Most steps that a run may take.
inline constexpr double most_steps = 1e12;

/// Fewest bytes that the fields of a run take on all ranks together: velocity, its tendency,
/// pressure and the transformed right-hand side.
double least_field_bytes(const Settings& settings);

}  // namespace bedload
