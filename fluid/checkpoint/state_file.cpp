#include "fluid/checkpoint/state_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "fluid/checkpoint/interpolation.hpp"
#include "fluid/files/atomic_file.hpp"
#include "fluid/files/collectively.hpp"

namespace bedload {
namespace {

constexpr std::uint64_t metadata_room = 1 << 20;
constexpr auto fields_of_state = static_cast<std::uint64_t>(
    std::count_if(field_list.begin(), field_list.end(),
                  [](const FieldEntry& entry) { return entry.in_restart; }));

template <class Real>
Hyperslab slab_of(const FlowView<Real>& flow) {
  const auto size = [](int n) { return static_cast<std::uint64_t>(n); };
  const auto& cells = flow.grid.cells;
  return {{size(cells[1]), size(cells[2]), size(cells[0])},
          {size(flow.decomposition.first()), size(flow.decomposition.first_row()), 0},
          {size(flow.decomposition.planes()), size(flow.decomposition.rows()), size(cells[0])}};
}

/// Writes one field without its ghosts, order (j, k, i).
template <class Real>
void write_field(Hdf5File& file, const FlowView<Real>& flow, const FieldEntry& entry) {
  const Field<Real>& field = flow.fields[entry.stored];
  file.write_in_pieces<Real>(entry.name, slab_of(flow), [&](int first, int planes, Real* to) {
    for (int j = first; j < first + planes; ++j)
      for (int k = 0; k < field.nz(); ++k)
        to = std::copy_n(flow.fields.row(entry, j, k), field.nx(), to);
  });
  file.set_text(entry.name, "unit", entry.unit);
}

bool is_velocity(const FieldEntry& entry) { return entry.stored == Stored::velocity; }

/// The points of a field along direction d of a stored grid, between the walls that the run has
/// now. A scalar goes on beyond a wall without a gradient.
PointRow points(const Grid& run, const StateHeader& stored, const FieldEntry& entry, int d) {
  const auto direction = static_cast<std::size_t>(d);
  const bool on_face = entry.on_face(d);
  std::array<Continuation, 2> ends{};
  for (std::size_t end = 0; end < 2; ++end) {
    const Wall wall = run.walls[direction][end];
    if (wall == Wall::periodic)
      ends[end] = Continuation::periodic;
    else if (on_face)
      ends[end] = Continuation::on_wall;
    else
      ends[end] = is_velocity(entry) && wall == Wall::no_slip ? Continuation::opposed
                                                              : Continuation::mirrored;
  }
  if (d == 1 && !stored.y_faces.empty()) return stretched_points(stored.y_faces, on_face, ends);
  const int cells = stored.cells[direction];
  return {cells, run.length[direction] / cells, on_face ? 1.0 : 0.5, ends, {}};
}

std::vector<LinearStencil> stencils(const Grid& grid, const StateHeader& stored,
                                    const FieldEntry& entry, int d, int first, int count) {
  const PointRow row = points(grid, stored, entry, d);
  const auto place = [&](int n) {
    if (d == 1) return entry.on_face(d) ? grid.y_face(n) : grid.y_centre(n);
    return entry.on_face(d) ? grid.face(n) : grid.centre(n);
  };
  std::vector<LinearStencil> list;
  for (int n = first; n < first + count; ++n) list.push_back(linear_stencil(row, place(n)));
  return list;
}

/// What the walls of direction d contribute to a velocity component; a scalar they leave alone.
double from_walls(const LinearStencil& stencil, const Grid& grid, const FieldEntry& entry, int d) {
  if (!is_velocity(entry)) return 0.0;
  const auto& velocity = grid.wall_velocity[static_cast<std::size_t>(d)];
  const auto c = static_cast<std::size_t>(entry.component);
  return stencil.wall_weight[0] * velocity[0][c] + stencil.wall_weight[1] * velocity[1][c];
}

/// Interpolates one field onto this rank's cells: first between two stored planes, then
/// within the plane.
template <class Real>
void interpolate(const StateReader& state, const Grid& grid, const Decomposition& decomposition,
                 const FieldEntry& entry, FlowFields<Real>& fields) {
  const auto& cells = state.header().cells;
  const auto nx = static_cast<std::size_t>(cells[0]), nz = static_cast<std::size_t>(cells[2]);
  const auto along_x = stencils(grid, state.header(), entry, 0, 0, grid.cells[0]);
  const auto along_y =
      stencils(grid, state.header(), entry, 1, decomposition.first(), decomposition.planes());
  const auto along_z =
      stencils(grid, state.header(), entry, 2, decomposition.first_row(), decomposition.rows());
  std::map<int, std::vector<double>> stored;  // planes in use, two at a time
  const auto plane = [&](int j) -> const std::vector<double>& {
    const auto [found, is_new] = stored.try_emplace(j);
    if (is_new) {
      found->second.resize(nx * nz);
      state.read_rows(entry, j, 0, cells[2], found->second.data());
    }
    return found->second;
  };
  std::vector<double> blended(nx * nz);
  for (int j = 0; j < decomposition.planes(); ++j) {
    const LinearStencil& y = along_y[static_cast<std::size_t>(j)];
    std::erase_if(stored,
                  [&](const auto& held) { return held.first != y.lower && held.first != y.upper; });
    const std::vector<double>&lower = plane(y.lower), &upper = plane(y.upper);
    const double y_wall = from_walls(y, grid, entry, 1);
    for (std::size_t n = 0; n < blended.size(); ++n)
      blended[n] = y.lower_weight * lower[n] + y.upper_weight * upper[n] + y_wall;
    for (int k = 0; k < decomposition.rows(); ++k) {
      const LinearStencil& z = along_z[static_cast<std::size_t>(k)];
      const double z_wall = from_walls(z, grid, entry, 2);
      const double* near = blended.data() + nx * static_cast<std::size_t>(z.lower);
      const double* far = blended.data() + nx * static_cast<std::size_t>(z.upper);
      Real* row = fields.row(entry, j, k);
      for (int i = 0; i < grid.cells[0]; ++i) {
        const LinearStencil& x = along_x[static_cast<std::size_t>(i)];
        const double x_wall = from_walls(x, grid, entry, 0);
        const double at_near =
            x.lower_weight * near[x.lower] + x.upper_weight * near[x.upper] + x_wall;
        const double at_far =
            x.lower_weight * far[x.lower] + x.upper_weight * far[x.upper] + x_wall;
        row[i] = static_cast<Real>(z.lower_weight * at_near + z.upper_weight * at_far + z_wall);
      }
    }
  }
}

/// Takes one field over as it is.
template <class Real>
void copy(const StateReader& state, const Decomposition& decomposition, const FieldEntry& entry,
          FlowFields<Real>& fields) {
  const auto nx = static_cast<std::size_t>(fields[entry.stored].nx());
  std::vector<Real> values(nx * static_cast<std::size_t>(decomposition.rows()));
  for (int j = 0; j < decomposition.planes(); ++j) {
    state.read_rows(entry, decomposition.first() + j, decomposition.first_row(),
                    decomposition.rows(), values.data());
    for (int k = 0; k < decomposition.rows(); ++k)
      std::copy_n(values.data() + nx * static_cast<std::size_t>(k), nx, fields.row(entry, j, k));
  }
}

template <class Real>
void fill_with_zero(const Decomposition& decomposition, const FieldEntry& entry,
                    FlowFields<Real>& fields) {
  for (int j = 0; j < decomposition.planes(); ++j)
    for (int k = 0; k < decomposition.rows(); ++k)
      std::fill_n(fields.row(entry, j, k), fields[entry.stored].nx(), Real{});
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
void write_state(const std::string& path, const FlowView<Real>& flow, const SaveRun& save) {
  const MPI_Comm comm = flow.decomposition.comm();
  try {
    std::uint64_t numbers = static_cast<std::uint64_t>(flow.grid.cell_count()) * fields_of_state;
    std::uint64_t run_bytes = 0;
    if (save) save({nullptr, run_group, comm, run_bytes});
    on_first_rank(comm,
                  [&] { require_space(path, numbers * sizeof(Real) + run_bytes + metadata_room); });
    const auto file = create_state(path,
                                   {.cells = flow.grid.cells,
                                    .length = flow.grid.length,
                                    .walls = flow.grid.walls,
                                    .y_faces = flow.grid.y_faces,
                                    .time = flow.time,
                                    .step = flow.step,
                                    .driving = flow.driving},
                                   comm);
    for (const FieldEntry& entry : field_list)
      if (entry.in_restart) write_field(*file, flow, entry);
    if (save) save({file.get(), run_group, comm, run_bytes});
    file->close();
    seal_state(path, comm);
  } catch (const UserError&) {
    if (flow.decomposition.rank() == 0) discard_temporary(path);
    throw;
  }
}

template <class Real>
StateRead read_state(const std::string& path, const Grid& grid, const Decomposition& decomposition,
                     FlowFields<Real>& fields) {
  return read_state(StateReader(path, decomposition.comm()), grid, decomposition, fields);
}

template <class Real>
StateRead read_state(const StateReader& state, const Grid& grid, const Decomposition& decomposition,
                     FlowFields<Real>& fields) {
  StateRead result{state.header(), !same_cells(state.header(), grid)};
  collectively(decomposition.comm(), [&] {
    check_box(state.path(), state.header(), grid);
    for (const FieldEntry& entry : field_list) {
      if (!entry.in_restart) continue;
      if (!state.has(entry))
        fill_with_zero(decomposition, entry, fields);
      else if (result.interpolated)
        interpolate(state, grid, decomposition, entry, fields);
      else
        copy(state, decomposition, entry, fields);
    }
  });
  return result;
}

template void write_state(const std::string&, const FlowView<float>&, const SaveRun&);
template void write_state(const std::string&, const FlowView<double>&, const SaveRun&);
template StateRead read_state(const std::string&, const Grid&, const Decomposition&,
                              FlowFields<float>&);
template StateRead read_state(const std::string&, const Grid&, const Decomposition&,
                              FlowFields<double>&);
template StateRead read_state(const StateReader&, const Grid&, const Decomposition&,
                              FlowFields<float>&);
template StateRead read_state(const StateReader&, const Grid&, const Decomposition&,
                              FlowFields<double>&);

}  // namespace bedload
