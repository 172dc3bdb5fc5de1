#include "fluid/spheres/sphere_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <sstream>

#include "fluid/errors.hpp"

namespace bedload {
namespace {

constexpr double least_cells_per_diameter = 4.0;

/// The numbers of a line without its comment. Throws what is no number.
std::vector<double> numbers_of(std::string line) {
  line.resize(std::min(line.size(), line.find('#')));
  std::replace(line.begin(), line.end(), ',', ' ');
  std::istringstream words(line);
  std::vector<double> numbers;
  for (std::string word; words >> word;) {
    std::istringstream text(word);
    double number = 0.0;
    if (!(text >> number) || !text.eof() || !std::isfinite(number)) throw word;
    numbers.push_back(number);
  }
  return numbers;
}

SphereState sphere_of(const std::vector<double>& numbers, const Grid& grid) {
  if (numbers.size() != 4)
    throw UserError(
        fmt::format("has {} numbers, but must have four: x y z radius", numbers.size()));
  SphereState sphere;
  sphere.mobile = false;
  sphere.radius = numbers[3];
  if (!(2.0 * sphere.radius >= least_cells_per_diameter * grid.h))
    throw UserError(
        fmt::format("has the radius {}, but the diameter must be at least {} cells ({})",
                    sphere.radius, least_cells_per_diameter, least_cells_per_diameter * grid.h));
  for (int d = 0; d < 3; ++d) {
    const double length = grid.length[static_cast<std::size_t>(d)];
    double x = numbers[static_cast<std::size_t>(d)];
    if (grid.periodic(d)) {
      if (2.0 * sphere.radius > length)
        throw UserError(
            fmt::format("has the diameter {}, but the box is only {} long along periodic {}",
                        2.0 * sphere.radius, length, "xyz"[d]));
      x -= length * std::floor(x / length);
      if (x >= length) x = 0.0;
    } else if (x < -sphere.radius || x > length + sphere.radius) {
      throw UserError(
          fmt::format("has {} = {}, but the box reaches from 0 to {}", "xyz"[d], x, length));
    }
    sphere.position[d] = x;
  }
  return sphere;
}

}  // namespace

std::vector<SphereState> read_spheres(const std::string& file, const Grid& grid) {
  std::ifstream stream(file);
  if (!stream)
    throw UserError(fmt::format("{}: the file of 'spheres.file' cannot be opened.", file));
  std::vector<SphereState> spheres;
  std::string line;
  for (int number = 1; std::getline(stream, line); ++number) try {
      const std::vector<double> numbers = numbers_of(line);
      if (numbers.empty()) continue;
      spheres.push_back(sphere_of(numbers, grid));
      spheres.back().tag = static_cast<std::int64_t>(spheres.size());
    } catch (const std::string& word) {
      throw UserError(fmt::format("{}, line {}: '{}' is no number.", file, number, word));
    } catch (const UserError& error) {
      throw UserError(fmt::format("{}, line {}: the sphere {}.", file, number, error.what()));
    }
  if (spheres.empty()) throw UserError(fmt::format("{}: the file holds no sphere.", file));
  return spheres;
}

}  // namespace bedload
