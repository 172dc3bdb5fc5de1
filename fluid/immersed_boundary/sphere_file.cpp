#include "fluid/immersed_boundary/sphere_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <sstream>

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
  for (int d = 0; d < 3; ++d) {
    const double length = grid.length[static_cast<std::size_t>(d)];
    double x = numbers[static_cast<std::size_t>(d)];
    if (grid.periodic(d)) {
      x -= length * std::floor(x / length);
      if (x >= length) x = 0.0;
    }
    sphere.position[d] = x;
  }
  if (const auto flaw = flaw_of(grid, sphere)) throw UserError(*flaw);
  return sphere;
}

}  // namespace

std::vector<SphereState> read_spheres(const std::string& file, const Grid& grid) {
  std::ifstream stream = open_input(file);
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
