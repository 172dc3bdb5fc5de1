#include "fluid/immersed_boundary/sphere_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <sstream>

#include "fluid/grid/sphere_bins.hpp"
#include "fluid/settings/errors.hpp"
#include "fluid/settings/input_file.hpp"
#include "fluid/validation/validate.hpp"

namespace bedload {
namespace {

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
  sphere.position = inside_the_box(grid, Vec3(numbers[0], numbers[1], numbers[2]));
  if (const auto flaw = flaw_of(grid, sphere)) throw UserError(*flaw);
  return sphere;
}

/// Throws where two spheres stand at one place, which has all its markers twice.
/// @param lines of `file`, one for each sphere
void refuse_twins(const std::string& file, const std::vector<SphereState>& spheres,
                  const std::vector<int>& lines, const Grid& grid) {
  constexpr double same = 1e-6;  // radii
  double largest = 0.0;
  for (const SphereState& sphere : spheres) largest = std::max(largest, sphere.radius);
  SphereBins bins(grid, 2.0 * largest);
  for (std::size_t n = 0; n < spheres.size(); ++n) {
    const SphereState& sphere = spheres[n];
    bins.near(sphere.position, same * sphere.radius, [&](int other) {
      const auto m = static_cast<std::size_t>(other);
      if (shortest_way(grid, sphere.position, spheres[m].position).norm() < same * sphere.radius)
        throw UserError(fmt::format(
            "{}, line {}: the sphere is where that of line {} is; along a periodic direction both "
            "ends of the box are one place. Leave one of them out.",
            file, lines[n], lines[m]));
    });
    bins.insert(sphere.position, static_cast<int>(n));
  }
}

}  // namespace

std::vector<SphereState> read_spheres(const std::string& file, const Grid& grid) {
  std::ifstream stream = open_input(file);
  std::vector<SphereState> spheres;
  std::vector<int> lines;
  std::string line;
  for (int number = 1; std::getline(stream, line); ++number) try {
      const std::vector<double> numbers = numbers_of(line);
      if (numbers.empty()) continue;
      spheres.push_back(sphere_of(numbers, grid));
      spheres.back().tag = static_cast<std::int64_t>(spheres.size());
      lines.push_back(number);
    } catch (const std::string& word) {
      throw UserError(fmt::format("{}, line {}: '{}' is no number.", file, number, word));
    } catch (const UserError& error) {
      throw UserError(fmt::format("{}, line {}: the sphere {}.", file, number, error.what()));
    }
  if (spheres.empty()) throw UserError(fmt::format("{}: the file holds no sphere.", file));
  refuse_twins(file, spheres, lines, grid);
  return spheres;
}

}  // namespace bedload
