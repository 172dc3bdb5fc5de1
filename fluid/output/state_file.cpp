#include "fluid/output/state_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "fluid/output/agreement.hpp"
#include "fluid/output/aside_file.hpp"
#include "fluid/output/interpolation.hpp"

namespace bedload {
namespace {

constexpr std::uint64_t metadata_room = 1 << 20;
constexpr int pressure_index = 3;

template <class Real>
Hyperslab slab_of(const FlowView<Real>& flow) {
  const auto size = [](int n) { return static_cast<std::uint64_t>(n); };
  const auto& cells = flow.grid.cells;
  return {{size(cells[1]), size(cells[2]), size(cells[0])},
          {size(flow.slabs.first()), size(flow.slabs.first_row()), 0},
          {size(flow.slabs.planes()), size(flow.slabs.rows()), size(cells[0])}};
}

/// Writes one component without its ghosts, order (j, k, i).
template <class Real>
void write_component(Hdf5File& file, const std::string& name, const Hyperslab& slab,
                     const Field<Real>& field, int c) {
  file.write_in_pieces<Real>(name, slab, [&](int first, int planes, Real* to) {
    for (int j = first; j < first + planes; ++j)
      for (int k = 0; k < field.nz(); ++k) to = std::copy_n(field.row(j, k, c), field.nx(), to);
  });
}

/// Component c (3: pressure) lives in this component of that field.
template <class Real>
Real* row_of(Field<Real>& velocity, Field<Real>& pressure, int c, int j, int k) {
  return c == pressure_index ? pressure.row(j, k) : velocity.row(j, k, c);
}

/// The points of component c (3: pressure) along direction d of a stored grid, between the walls
/// that the run has now.
PointRow points(const Grid& run, const StateHeader& stored, int c, int d) {
  const auto direction = static_cast<std::size_t>(d);
  std::array<Continuation, 2> ends{};
  for (std::size_t end = 0; end < 2; ++end) {
    const Wall wall = run.walls[direction][end];
    if (wall == Wall::periodic)
      ends[end] = Continuation::periodic;
    else if (c == d)
      ends[end] = Continuation::on_wall;
    else
      ends[end] = c != pressure_index && wall == Wall::no_slip ? Continuation::opposed
                                                               : Continuation::mirrored;
  }
  if (d == 1 && !stored.y_faces.empty()) return stretched_points(stored.y_faces, c == d, ends);
  const int cells = stored.cells[direction];
  return {cells, run.length[direction] / cells, c == d ? 1.0 : 0.5, ends, {}};
}

std::vector<LinearStencil> stencils(const Grid& grid, const StateHeader& stored, int c, int d,
                                    int first, int count) {
  const PointRow row = points(grid, stored, c, d);
  const auto place = [&](int n) {
    if (d == 1) return c == d ? grid.y_face(n) : grid.y_centre(n);
    return c == d ? grid.face(n) : grid.centre(n);
  };
  std::vector<LinearStencil> list;
  for (int n = first; n < first + count; ++n) list.push_back(linear_stencil(row, place(n)));
  return list;
}

/// What the walls of direction d contribute to component c (3: pressure, which they leave alone).
double from_walls(const LinearStencil& stencil, const Grid& grid, int c, int d) {
  if (c == pressure_index) return 0.0;
  const auto& velocity = grid.wall_velocity[static_cast<std::size_t>(d)];
  return stencil.wall_weight[0] * velocity[0][static_cast<std::size_t>(c)] +
         stencil.wall_weight[1] * velocity[1][static_cast<std::size_t>(c)];
}

/// Interpolates one component onto this rank's cells: first between two stored planes, then
/// within the plane.
template <class Real>
void interpolate(const StateReader& state, const Grid& grid, const Decomposition& slabs, int c,
                 Field<Real>& velocity, Field<Real>& pressure) {
  const auto& cells = state.header().cells;
  const auto nx = static_cast<std::size_t>(cells[0]), nz = static_cast<std::size_t>(cells[2]);
  const auto along_x = stencils(grid, state.header(), c, 0, 0, grid.cells[0]);
  const auto along_y = stencils(grid, state.header(), c, 1, slabs.first(), slabs.planes());
  const auto along_z = stencils(grid, state.header(), c, 2, slabs.first_row(), slabs.rows());
  std::map<int, std::vector<double>> stored;  // planes in use, two at a time
  const auto plane = [&](int j) -> const std::vector<double>& {
    const auto [entry, is_new] = stored.try_emplace(j);
    if (is_new) {
      entry->second.resize(nx * nz);
      state.read_rows(c, j, 0, cells[2], entry->second.data());
    }
    return entry->second;
  };
  std::vector<double> blended(nx * nz);
  for (int j = 0; j < slabs.planes(); ++j) {
    const LinearStencil& y = along_y[static_cast<std::size_t>(j)];
    std::erase_if(stored, [&](const auto& entry) {
      return entry.first != y.lower && entry.first != y.upper;
    });
    const std::vector<double>&lower = plane(y.lower), &upper = plane(y.upper);
    const double y_wall = from_walls(y, grid, c, 1);
    for (std::size_t n = 0; n < blended.size(); ++n)
      blended[n] = y.lower_weight * lower[n] + y.upper_weight * upper[n] + y_wall;
    for (int k = 0; k < slabs.rows(); ++k) {
      const LinearStencil& z = along_z[static_cast<std::size_t>(k)];
      const double z_wall = from_walls(z, grid, c, 2);
      const double* near = blended.data() + nx * static_cast<std::size_t>(z.lower);
      const double* far = blended.data() + nx * static_cast<std::size_t>(z.upper);
      Real* row = row_of(velocity, pressure, c, j, k);
      for (int i = 0; i < grid.cells[0]; ++i) {
        const LinearStencil& x = along_x[static_cast<std::size_t>(i)];
        const double x_wall = from_walls(x, grid, c, 0);
        const double at_near =
            x.lower_weight * near[x.lower] + x.upper_weight * near[x.upper] + x_wall;
        const double at_far =
            x.lower_weight * far[x.lower] + x.upper_weight * far[x.upper] + x_wall;
        row[i] = static_cast<Real>(z.lower_weight * at_near + z.upper_weight * at_far + z_wall);
      }
    }
  }
}

/// Takes one component over as it is.
template <class Real>
void copy(const StateReader& state, const Decomposition& slabs, int c, Field<Real>& velocity,
          Field<Real>& pressure) {
  const auto nx = static_cast<std::size_t>(velocity.nx());
  std::vector<Real> values(nx * static_cast<std::size_t>(velocity.nz()));
  for (int j = 0; j < slabs.planes(); ++j) {
    state.read_rows(c, slabs.first() + j, slabs.first_row(), slabs.rows(), values.data());
    for (int k = 0; k < velocity.nz(); ++k)
      std::copy_n(values.data() + nx * static_cast<std::size_t>(k), nx,
                  row_of(velocity, pressure, c, j, k));
  }
}

/// A state fits when box and periodic directions are those of the run.
void check_box(const std::string& path, const StateHeader& found, const Grid& wanted) {
  for (std::size_t d = 0; d < 3; ++d) {
    if (std::abs(found.length[d] - wanted.length[d]) > 1e-6 * wanted.length[d])
      throw UserError(fmt::format(
          "{}: the state's box is {} long along {}, but grid.length says {}; only the cells may "
          "differ.",
          path, found.length[d], "xyz"[d], wanted.length[d]));
    if ((found.walls[d][0] == Wall::periodic) != (wanted.walls[d][0] == Wall::periodic))
      throw UserError(fmt::format(
          "{}: the state is {} along {}, but boundary.{} is {}.", path,
          found.walls[d][0] == Wall::periodic ? "periodic" : "closed by walls", "xyz"[d], "xyz"[d],
          wanted.walls[d][0] == Wall::periodic ? "\"periodic\"" : "a wall"));
  }
}

}  // namespace

bool same_cells(const StateHeader& stored, const Grid& grid) {
  const auto close = [&](double a, double b) { return std::abs(a - b) < 1e-9 * grid.length[1]; };
  return stored.cells == grid.cells && std::equal(stored.y_faces.begin(), stored.y_faces.end(),
                                                  grid.y_faces.begin(), grid.y_faces.end(), close);
}

template <class Real>
void write_state(const std::string& path, const FlowView<Real>& flow, const StateExtras& extras) {
  const MPI_Comm comm = flow.slabs.comm();
  try {
    std::uint64_t numbers = static_cast<std::uint64_t>(flow.grid.cell_count()) * 4;
    std::uint64_t extra_numbers = 0;
    for (const auto& [name, values] : extras) extra_numbers += values.size();
    on_first_rank(comm, [&] {
      require_space(path, numbers * sizeof(Real) + extra_numbers * sizeof(double) + metadata_room);
    });
    const auto file = create_state(path,
                                   {.cells = flow.grid.cells,
                                    .length = flow.grid.length,
                                    .walls = flow.grid.walls,
                                    .y_faces = flow.grid.y_faces,
                                    .time = flow.time,
                                    .step = flow.step,
                                    .driving = flow.driving},
                                   comm);
    const Hyperslab slab = slab_of(flow);
    for (int c = 0; c < 3; ++c)
      write_component(*file, state_datasets[static_cast<std::size_t>(c)], slab, flow.velocity, c);
    write_component(*file, state_datasets[pressure_index], slab, flow.pressure, 0);
    if (!extras.empty()) file->make_group("extra");
    const bool first_rank = flow.slabs.rank() == 0;
    for (const auto& [name, values] : extras) {
      const std::uint64_t n = values.size();
      file->write("extra/" + name, {{n}, {0}, {first_rank ? n : 0}}, values.data());
    }
    file->close();
    seal_state(path, comm);
  } catch (const UserError&) {
    if (flow.slabs.rank() == 0) discard_aside(path);
    throw;
  }
}

template <class Real>
StateRead read_state(const std::string& path, const Grid& grid, const Decomposition& slabs,
                     Field<Real>& velocity, Field<Real>& pressure) {
  const StateReader state(path, slabs.comm());
  StateRead result{state.header(), !same_cells(state.header(), grid), {}};
  together(slabs.comm(), [&] {
    check_box(path, state.header(), grid);
    for (int c = 0; c < 4; ++c) {
      if (!state.has(c))
        pressure.fill(Real{});
      else if (result.interpolated)
        interpolate(state, grid, slabs, c, velocity, pressure);
      else
        copy(state, slabs, c, velocity, pressure);
    }
    result.extras = state.extras();
  });
  return result;
}

template void write_state(const std::string&, const FlowView<float>&, const StateExtras&);
template void write_state(const std::string&, const FlowView<double>&, const StateExtras&);
template StateRead read_state(const std::string&, const Grid&, const Decomposition&, Field<float>&,
                              Field<float>&);
template StateRead read_state(const std::string&, const Grid&, const Decomposition&, Field<double>&,
                              Field<double>&);

}  // namespace bedload
