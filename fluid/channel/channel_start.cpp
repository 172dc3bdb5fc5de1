#include <algorithm>
#include <functional>
#include <span>
#include <vector>

#include "fluid/channel/channel.hpp"
#include "fluid/channel/diagnostics.hpp"
#include "fluid/settings/errors.hpp"

// How a channel comes to the field that its first step starts from: given, restored, made free of
// divergence.

namespace bedload {

/// One projection over a unit time, from own planes to valid ghosts.
template <class Real>
void Channel<Real>::project_start_field() {
  walls_.close_own_planes(velocity_);
  if (decomposition_.at_upper_wall())
    for (int k = 0; k < decomposition_.rows(); ++k)
      walls_.close_wall_face(velocity_, decomposition_.planes() - 1, k);
  projection_.begin();
  projection_.eliminate_planes(0, decomposition_.planes(), 1.0);
  projection_.couple();
  projection_.correct({.step = 1.0});
  walls_.fill(velocity_);
}

template <class Real>
void Channel<Real>::measure_start() {
  streamwise_sum_ = streamwise_sum(velocity_, grid_, decomposition_);
  fastest_ = largest_local_speed(velocity_, grid_, decomposition_);
  MPI_Allreduce(MPI_IN_PLACE, &fastest_, 1, MPI_DOUBLE, MPI_MAX, comm());
  choose_time_step();
  check_field();
  clock_ = {};
}

template <class Real>
void Channel<Real>::set_velocity(const std::function<double(int, const Vec3&)>& value) {
  for (int j = 0; j < decomposition_.planes(); ++j)
    for (int k = 0; k < decomposition_.rows(); ++k)
      for (int c = 0; c < 3; ++c) {
        Real* row = velocity_.row(j, k, c);
        for (int i = 0; i < grid_.cells[0]; ++i) {
          const int plane = decomposition_.first() + j, line = decomposition_.first_row() + k;
          const Vec3 place(c == 0 ? grid_.face(i) : grid_.centre(i),
                           c == 1 ? grid_.y_face(plane) : grid_.y_centre(plane),
                           c == 2 ? grid_.face(line) : grid_.centre(line));
          row[i] = static_cast<Real>(value(c, place));
        }
      }
  project_start_field();
  measure_start();
}

template <class Real>
void Channel<Real>::restored(double time, std::int64_t step, double driving_force,
                             bool project_it) {
  time_ = time;
  step_ = step;
  driving_.set(driving_force / settings_.fluid.density);
  if (project_it) {
    project_start_field();
  } else {
    walls_.close_own_planes(velocity_);
  }
  renew_ghosts();
  measure_start();
}

template <class Real>
void Channel<Real>::shift_to_bulk_velocity() {
  const double bulk = streamwise_sum(velocity_, grid_, decomposition_) / grid_.cubes();
  const auto shift = static_cast<Real>(driving_.missing<Real>(bulk));
  for (int j = 0; j < decomposition_.planes(); ++j)
    for (int k = 0; k < decomposition_.rows(); ++k) {
      Real* u = velocity_.row(j, k, 0);
      for (int i = 0; i < grid_.cells[0]; ++i) u[i] += shift;
    }
}

template <class Real>
void Channel<Real>::renew_ghosts() {
  walls_.fill(velocity_);
  for (const FieldEntry& entry : field_list)
    if (entry.place == Place::centre) walls_.fill_scalar(fields_[entry.stored]);
}

template <class Real>
void Channel<Real>::save(const SaveGroup& group) const {
  group.value("driving_acceleration", driving_.acceleration());
  group.value("streamwise_sum", streamwise_sum_);
  group.value("fastest_cell", fastest_);
  group.value("last_time_step", dt_made_);
}

template <class Real>
void Channel<Real>::load(const LoadGroup& group) {
  driving_.set(group.value<double>("driving_acceleration"));
  streamwise_sum_ = group.value<double>("streamwise_sum");
  fastest_ = group.value<double>("fastest_cell");
  dt_made_ = group.value<double>("last_time_step");
  choose_time_step();
}

template class Channel<float>;
template class Channel<double>;

}  // namespace bedload
