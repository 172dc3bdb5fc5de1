#pragma once

#include <string>
#include <vector>

#include "fluid/grid/grid.hpp"
#include "fluid/grid/sphere.hpp"

namespace bedload {

/// Fixed spheres of a run without LIGGGHTS, from a text file with one sphere a line: x y z radius
/// [L], separated by blanks or commas; what follows a # is a comment. Tags count from 1. Throws
/// UserError with file and line.
std::vector<SphereState> read_spheres(const std::string& file, const Grid& grid);

}  // namespace bedload
